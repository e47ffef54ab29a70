"""Whether motors can do what the criterion of a command asks for, by the actuation in force."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from pirate_sm.checking.actuation_in_force import Actuated, InForce, under
from pirate_sm.engine.robot.criteria import CriterionSpec, StalledSpec, TurningSpec


def too_strong(force: InForce, done: CriterionSpec, led: Sequence[Actuated]) -> str:
    """Return why a joint cannot bear the required torque; empty if it can.

    Args:
        force: What is in force.
        done: The criterion.
        led: Where the command leads to; one that suffices is enough.
    """
    if not isinstance(done, StalledSpec) or not led:
        return ""
    for load in done.loads:
        if load.slot < 0:
            continue
        most, slot = max(force.most_nm(at, load.slot) for at in led), load.slot
        if most <= load.least_nm:
            there = under(force.robot, led[0].control)
            return (
                f"its motor gives '{force.profile.slots[slot].joint}' at most {most:.3g} Nm there,"
                f" and more than {load.least_nm:.3g} Nm are asked for{there}"
            )
    return ""


def too_slow(force: InForce, done: CriterionSpec, led: Sequence[Actuated]) -> str:
    """Return why no wheel can reach the required speed; empty if one can.

    The arguments are those of :func:`too_strong`.
    """
    if not isinstance(done, TurningSpec):
        return ""
    speeds = [force.most_rad_s(at, slot) for at in led for slot, _ in done.wheels]
    most = max(speeds, default=inf)
    if most > done.above:
        return ""
    if most == 0:
        return "no wheel is driven in the states that it leads to"
    there = under(force.robot, led[0].control)
    return (
        f"wheels turn with at most {most:.3g} rad/s there, {done.above:.3g} rad/s are asked"
        f" for{there}"
    )
