"""Whether the sensors agree with the configuration that the robot is said to be in."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import degrees, isnan, radians

from pirate_sm.engine.robot import RobotSpec
from pirate_sm.engine.robot_state import at_rest_in
from pirate_sm.engine.sensing import Sensing, nothing_known, observe
from pirate_sm.model.derived import DiameterOf
from pirate_sm.model.events import SensorFrame
from pirate_sm.model.profile import Profile

_ANGLE_RAD = radians(10)
_DIAMETER_SHARE = 0.15

Check = Callable[[Sequence[SensorFrame]], str]


def check_of(
    profile: Profile, robot: RobotSpec, configuration: int, diameter_m: float | None
) -> Check:
    """What says in one sentence what does not agree; empty when all does.

    Args:
        profile: The robot.
        robot: The same, as the engine runs it.
        configuration: Where it is said to be.
        diameter_m: Inner diameter of the pipe, for parts that are said to clamp; None: unknown.
    """

    def check(frames: Sequence[SensorFrame]) -> str:
        sensing = nothing_known(robot)
        rest = at_rest_in(robot, configuration).values
        for frame in frames:
            sensing, _ = observe(robot, sensing, frame, rest, rest, 0.0, sent=False)
        found = [*_angles(robot, rest, sensing)]
        if diameter_m is not None:
            found += _parts(profile, robot, configuration, diameter_m, sensing)
        if not found:
            return ""
        states = ", ".join(robot.table.configurations[configuration])
        return (
            f"the robot is not in the configuration that it is said to be in ({states}): "
            f"{'; '.join(found)}. Say with --state REGION=STATE where it is"
        )

    return check


def _angles(robot: RobotSpec, rest: tuple[float, ...], sensing: Sensing) -> Iterator[str]:
    """Angle setpoints that are not where they are said to be."""
    for slot, value in zip(robot.slots, rest, strict=True):
        if slot.unit != "angle" or slot.angle < 0 or isnan(value):
            continue
        angle = sensing.numbers[slot.angle]
        if abs(angle - value) > _ANGLE_RAD:
            yield f"{slot.name} is at {degrees(angle):.0f} deg, not {degrees(value):.0f} deg"


def _parts(
    profile: Profile, robot: RobotSpec, configuration: int, diameter_m: float, sensing: Sensing
) -> Iterator[str]:
    """Parts that are said to clamp and do not show the diameter of the pipe."""
    held = {robot.parts[part] for part in robot.held[configuration]}
    for name, derived in profile.derived.items():
        if isinstance(derived, DiameterOf) and derived.diameter_of in held:
            seen_m = sensing.numbers[robot.vocabulary.numbers.index(name)]
            if abs(seen_m - diameter_m) > _DIAMETER_SHARE * diameter_m:
                yield (
                    f"the {derived.diameter_of} part spans {seen_m * 1000:.0f} mm, "
                    f"the pipe {diameter_m * 1000:.0f} mm"
                )
