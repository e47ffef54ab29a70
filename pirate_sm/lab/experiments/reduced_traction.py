"""Runs a variant of a traction experiment on the reduced physics."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from pirate_sm.core.errors import UsageError
from pirate_sm.core.geometry import span_m
from pirate_sm.core.models import Profile
from pirate_sm.lab.experiments.reduced_kernel import GRAVITY_M_S2, simulate
from pirate_sm.lab.experiments.setups import NoiseLevel, TractionSetup, Variant
from pirate_sm.simulation.arrays import Floats


@dataclass(frozen=True)
class TractionRun:
    """What happened, a row for each tick of the controller; columns of matrices are wheels.

    Attributes:
        times_s: Times.
        place_m: Of the robot along the pipe.
        speed_m_s: Of the robot.
        rim_m_s: Rim speeds r d ω, positive forward.
        measured_m_s: The same as the controller sees them.
        friction_n: Friction forces on the robot, positive forward.
        normal_n: Normal forces.
        motor_n: Motor torques at the rim, d τ / r.
    """

    times_s: Floats
    place_m: Floats
    speed_m_s: Floats
    rim_m_s: Floats
    measured_m_s: Floats
    friction_n: Floats
    normal_n: Floats
    motor_n: Floats

    @property
    def odometry_error_m(self) -> Floats:
        """How far the robot has come beyond what each wheel has rolled: x − r Σ ω Δt."""
        tick_s = self.times_s[1] - self.times_s[0]
        errors: Floats = self.place_m[:, None] - np.cumsum(self.measured_m_s, axis=0) * tick_s
        return errors

    @property
    def way_m(self) -> float:
        """How far apart the outermost places were."""
        return float(np.ptp(self.place_m))

    @property
    def slip_m_s(self) -> Floats:
        """Slip speeds r d ω − v, as they are."""
        slips: Floats = self.rim_m_s - self.speed_m_s[:, None]
        return slips

    @property
    def used_friction(self) -> Floats:
        """Friction coefficients |F| / N in use; NaN where nothing presses."""
        with np.errstate(divide="ignore", invalid="ignore"):
            used: Floats = np.abs(self.friction_n) / self.normal_n
        return used


def run_traction(
    profile: Profile,
    setup: TractionSetup,
    variant: Variant,
    noise: NoiseLevel,
    *,
    seed: int = 0,
    sticks: bool = False,
) -> TractionRun:
    """Return what a robot of this profile does.

    Args:
        profile: Of the robot; masses, wheel radius, links and parts count.
        setup: The experiment.
        variant: Which parts of the controller work.
        noise: On what the controller measures.
        seed: Of the noise.
        sticks: Whether friction sticks, instead of the law of fig. 4-3.

    Raises:
        UsageError: The setup does not fit the robot.
    """
    _check_parts(profile, setup)
    physics, control, body = setup.physics, setup.control, profile.body
    ticks = round(setup.timeline.end / physics.tick)
    times_s: Floats = np.multiply(np.arange(ticks), physics.tick, dtype=np.float64)
    random = np.random.default_rng(seed)
    tilt = _tilt(times_s, setup)
    seen_tilt = tilt + noise.tilt * random.standard_normal(ticks)
    rim_noise = body.wheel_radius * noise.speed * random.standard_normal((ticks, len(body.wheels)))
    mass = mass_kg(profile)
    compensating = variant.compensated & (times_s >= setup.timeline.compensate)
    ahead = mass * GRAVITY_M_S2 * np.sin(seen_tilt) / len(body.wheels) * compensating
    normal = _normal_forces(profile, setup, variant, times_s, tilt, seen_tilt)
    out: Floats = np.zeros((ticks, 2 + 3 * len(body.wheels)))
    simulate(
        np.array([_law(setup, wheel.part) for wheel in body.wheels]),
        np.array(
            [
                mass,
                (physics.rotor + physics.disk) / body.wheel_radius**2,
                control.gain / body.wheel_radius,
                physics.tick,
            ]
        ),
        np.column_stack([_wanted(times_s, setup), tilt, ahead]),
        normal,
        rim_noise,
        sticks,
        max(round(physics.tick / physics.step), 1),
        out,
        np.zeros((5, len(body.wheels))),
    )
    rim, force, motor = np.split(out[:, 2:], 3, axis=1)
    return TractionRun(times_s, out[:, 0], out[:, 1], rim, rim + rim_noise, force, normal, motor)


def _check_parts(profile: Profile, setup: TractionSetup) -> None:
    parts = set(profile.body.parts)
    told: dict[str, Iterable[str]] = {
        "physics.friction": setup.physics.friction,
        "control.friction": setup.control.friction,
        "timeline.clamp": setup.timeline.clamp,
    }
    for where, given in told.items():
        if set(given) != parts:
            names = ", ".join(sorted(parts))
            raise UsageError(f"{where} of the experiment names other parts than the robot: {names}")
    for part in parts:
        if lever_m(profile, setup, part) <= 0:
            raise UsageError(
                f"the part {part} is too short for a pipe of the experiment's diameter"
            )


def mass_kg(profile: Profile) -> float:
    """Return the mass of the whole robot."""
    body = profile.body
    return sum(wheel.mass for wheel in body.wheels) + sum(link.mass for link in body.links)


def lever_m(profile: Profile, setup: TractionSetup, part: str) -> float:
    """Return the length along the pipe of a leg of the part's V (eq. 3-3)."""
    height_m = setup.physics.diameter - 2 * profile.body.wheel_radius
    return span_m(min(profile.body.legs_m(part)), height_m)


def _law(setup: TractionSetup, part: str) -> tuple[float, ...]:
    """Return the row of a wheel for the kernel."""
    physics = setup.physics
    friction, bristle = physics.friction[part], physics.bristle
    return (
        friction.static, friction.kinetic, physics.threshold, bristle.stiffness, bristle.damping
    )  # fmt: skip


def _tilt(times_s: Floats, setup: TractionSetup) -> Floats:
    turn = setup.timeline.turn
    tilt: Floats = np.interp(times_s, (turn.begin, turn.to), (0.0, turn.tilt))
    return tilt


def _wanted(times_s: Floats, setup: TractionSetup) -> Floats:
    """Return the wanted speed at each tick, m/s; 0 where the wheels are braked."""
    wanted = np.zeros_like(times_s)
    for drive in setup.timeline.drives:
        sign = 1.0 if drive.way == "forward" else -1.0
        wanted[(times_s >= drive.begin) & (times_s < drive.to)] = sign * setup.control.speed
    return wanted


def _normal_forces(
    profile: Profile,
    setup: TractionSetup,
    variant: Variant,
    times_s: Floats,
    tilt: Floats,
    seen_tilt: Floats,
) -> Floats:
    """Return each wheel's normal force: its share of the clamp and of the weight (eq. 3-3, 3-5)."""
    body, weight = profile.body, mass_kg(profile) * GRAVITY_M_S2
    joints = {joint.name: joint.wheel for joint in body.joints}
    apexes = {joints[part.apex] for part in body.parts.values()}
    columns = []
    for wheel in body.wheels:
        torque = _clamp_torque(profile, setup, variant, wheel.part, times_s, seen_tilt)
        share = 2.0 if wheel.name in apexes else 1.0
        pressed = share * torque / lever_m(profile, setup, wheel.part)
        columns.append(pressed + weight * np.abs(np.cos(tilt)) / len(body.wheels))
    return np.column_stack(columns)


def _clamp_torque(
    profile: Profile,
    setup: TractionSetup,
    variant: Variant,
    part: str,
    times_s: Floats,
    seen_tilt: Floats,
) -> Floats:
    """Return the torque of a part's apex: nothing, fixed, or as eq. 3-24 has it, Nm."""
    control, timeline = setup.control, setup.timeline
    torque = np.where(times_s >= timeline.clamp[part], control.fixed, 0.0)
    if not variant.gripped:
        return torque
    count = len(profile.body.wheels)
    weight = mass_kg(profile) * GRAVITY_M_S2
    needed = control.safety * weight * np.abs(np.sin(seen_tilt)) / (count * control.friction[part])
    pressed = weight * np.abs(np.cos(seen_tilt)) / count + needed
    share = 0.5 if control.share == "as_printed" else 1.0
    gripped: Floats = share * lever_m(profile, setup, part) * pressed
    return np.where(times_s >= timeline.grip, gripped, torque)
