"""What clamp torques of a thesis say: of friction, of zeros, and of the forces at the wheels."""

from __future__ import annotations

from itertools import pairwise
from math import degrees

from pirate_sm.core.geometry import span_m
from pirate_sm.core.models import Profile
from pirate_sm.lab.experiments.setups import ClampReadings, ExperimentResult


def explain_clamp(
    profile: Profile, clamp: ClampReadings, diameter_m: float, result: ExperimentResult
) -> None:
    """Add what each reading lacks of the torque of its stalled motor, and what it presses with.

    The spring that measures is in series with the motor, so at most the motor's torque can be
    read; friction before the spring takes from it, a zero that is off adds or takes. Friction
    behind it shows only while something else moves the joint.
    """
    body, lengths_m = profile.body, [link.length for link in profile.body.links]
    for joint, read in clamp.torques.items():
        slot = next(slot for slot in profile.slots if slot.joint == joint)
        motor = profile.motors[slot.motor]
        given = clamp.duty * (motor.stall_torque or 0.0)
        missing, stiffness = given - read, getattr(motor, "stiffness", 0.0)
        result.values[f"clamp.{joint}.missing"] = missing
        zero = f"a zero off by {degrees(abs(missing) / stiffness):.1f} deg" if stiffness else ""
        cause = (
            f"{missing:.3f} Nm less: friction before its spring, or {zero}"
            if missing >= 0
            else f"{-missing:.3f} Nm more, which no friction before its spring gives: {zero}, a"
            f" stronger motor, or a push from outside while friction behind the spring holds"
        )
        result.notes.append(
            f"clamp torque of {joint}: {read:.3f} Nm, the stalled motor gives {given:.3f} Nm at"
            f" a duty of {clamp.duty:.0%}, {cause}"
        )
    spans_m = [span_m(each, diameter_m - 2 * body.wheel_radius) for each in lengths_m]
    pressed = chain_forces_n([clamp.torques[joint.name] for joint in body.joints], spans_m)
    apexes = {part.apex: name for name, part in body.parts.items()}
    shares = {joint.wheel: 2.0 for joint in body.joints if joint.name in apexes}
    sides = zip(body.wheels, pressed, strict=True)
    texts = []
    for wheel, force_n in sides:
        leg_m, apex = min(body.legs_m(wheel.part)), body.parts[wheel.part].apex
        by_apex = (
            shares.get(wheel.name, 1.0)
            * clamp.torques[apex]
            / span_m(leg_m, diameter_m - 2 * body.wheel_radius)
        )
        texts.append(f"{wheel.name} {by_apex:.1f} and {force_n:.1f}")
    result.notes.append(
        f"normal forces of these torques in N, by eq. 3-3 and by the statics of the whole chain:"
        f" {', '.join(texts)}"
    )


def chain_forces_n(torques_nm: list[float], spans_m: list[float]) -> list[float]:
    """Return how hard the walls press on each wheel of a chain without friction, N.

    A chain that is bent alternately is a beam with these bending moments at its joints, and none at
    its ends; the walls press across the pipe alone, so a force is how the slope of the moment
    changes at a wheel.

    Args:
        torques_nm: Of the joints, by their size.
        spans_m: Lengths of the links along the pipe.
    """
    bent = [torque * (-1) ** number for number, torque in enumerate(torques_nm)]
    slopes = [(b - a) / span for (a, b), span in zip(pairwise([0, *bent, 0]), spans_m, strict=True)]
    return [(b - a) * (-1) ** number for number, (a, b) in enumerate(pairwise([0, *slopes, 0]))]
