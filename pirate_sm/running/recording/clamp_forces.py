"""How hard a clamped robot presses at a moment of a run: by statics, and between which bounds.

The bounds are those of all static states that its signals, the friction of its pipe, the brakes and
the rolling resistance of its wheels admit
(``docs/decisions/0123-normal-forces-come-with-an-interval.md``).
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isnan, nan
from typing import Any, NamedTuple

from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.loading import LoadedMission, simulated_profile

SUM = "sum"
"""The row of all wheels that hold."""


class ClampForce(NamedTuple):
    """The normal force of a wheel that holds, or the sum of them, N; NaN is unknown.

    Attributes:
        wheel: Name of the wheel, or ``sum``.
        force_n: By the statics of the chain, which leave it to braked wheels in equal shares what
            those bear along the pipe.
        least_n: The least that any static state admits.
        greatest_n: The greatest; infinite where nothing bounds it.
    """

    wheel: str
    force_n: float
    least_n: float
    greatest_n: float


def clamp_forces(
    loaded: LoadedMission, state: EngineState, options: Mapping[str, Any]
) -> tuple[ClampForce, ...]:
    """Return the force of each wheel that holds and of all, last; empty where no part holds.

    Args:
        loaded: The mission with its robot and its pipe.
        state: Of an engine that has every signal.
        options: Of the run, whose twin or numbers say which robot was simulated.

    Raises:
        UsageError: SciPy is not installed.
        LoadError: The file of the twin is not there any more, or another one.
    """
    robot, pipe = loaded.robot, loaded.pipe
    twin, seed, numbers = (options.get(name) for name in ("twin", "seed", "numbers"))
    profile = simulated_profile(loaded.loaded_robot.profile, twin, seed or 0, numbers or {})
    walls = pipe.friction if pipe is not None and pipe.friction else profile.simulation.friction
    motors = [profile.motors[profile.slots[wheel.slot].motor] for wheel in robot.wheels]
    wheels, intervals = Engine(robot, loaded.program, nominal=False).normal_forces(
        state,
        walls.static,
        [motor.hold_torque or 0.0 for motor in motors],
        resists=profile.simulation.tyre.rolling_resistance,
        is_round=pipe is not None and pipe.section == "round",
    )
    if robot.traction is None or not wheels:
        return ()
    signals = [robot.traction.wheels[wheel].normal_force for wheel in wheels]
    forces_n = [state.sensing.shown[each] if each >= 0 else nan for each in signals]
    names = [profile.body.wheels[wheel].name for wheel in wheels]
    found = zip((*names, SUM), (*forces_n, sum(forces_n)), intervals, strict=True)
    return tuple(ClampForce(name, force_n, *between) for name, force_n, between in found)


def in_words(force: ClampForce) -> str:
    """Return a force with its interval as text: ``sum 143 N (34 to 486 N)``."""
    known = "" if isnan(force.force_n) else f" {force.force_n:.0f} N"
    if isnan(force.least_n):
        return f"{force.wheel}{known} (in motion, against something, or with a dead wheel)"
    return f"{force.wheel}{known} ({force.least_n:.0f} to {force.greatest_n:.0f} N)"
