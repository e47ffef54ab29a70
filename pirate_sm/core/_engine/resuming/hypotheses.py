"""The states in which an interrupted run may have left the robot, and how far it has driven."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, isnan, nan, pi, remainder
from typing import Literal, NamedTuple

from pirate_sm.core._engine.mission.program import Program
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot import command_outcome, commands
from pirate_sm.core._engine.robot.declared_states import declared_in
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    DECLARED,
    DENIED,
    STOPPED,
    Flight,
    Mark,
    Marks,
    Motion,
    RobotState,
    at_rest_in,
    safe_values,
    states_of,
)
from pirate_sm.core._engine.robot.state_signs import OF_WHEELS
from pirate_sm.core._engine.robot.state_verdicts import kind_of, verdict
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._engine.state import EngineState


class Hypothesis(NamedTuple):
    """A configuration in which the robot may be.

    Attributes:
        name: ``recorded``: as the recording ends. ``sent``: a command whose first array was
            submitted last was accepted although nobody has recorded it. ``adopted``: nothing was
            recorded.
        body: The robot at rest there, with everything unconfirmed. Its values are those of the
            array that holds it: recorded duties, wheels and the slots of loops at zero.
        command: The command that leads there; empty where none does.
        drives: Whether its array drives wheels.
    """

    name: Literal["recorded", "sent", "adopted"]
    body: RobotState
    command: str = ""
    drives: bool = False

    def in_configuration(self, robot: RobotSpec, there: int, last: EngineState) -> Hypothesis:
        """Return the same robot in a configuration that an operator gives, with nothing confirmed.

        Args:
            robot: The robot.
            there: Index of the configuration.
            last: The engine's last recorded state; what was open then is still open.
        """
        kept = {each for each in last.robot.marks if each.command not in (DECLARED, STOPPED)}
        known = {(mark.kind, mark.which) for mark in kept}
        declared = declared_in(robot, there).marks
        marks = kept | {each for each in declared if (each.kind, each.which) not in known}
        body = self.body._replace(configuration=there, marks=frozenset(marks))
        return Hypothesis("recorded", body)


def hypotheses(
    robot: RobotSpec, program: Program, last: EngineState, maybe: int | None = None
) -> tuple[Hypothesis, ...]:
    """Return where the robot may be; the recorded configuration comes first.

    Args:
        robot: The robot.
        program: The mission.
        last: The engine's last recorded state.
        maybe: A command, by its index, that may have been sent after it; None if the recording
            shows everything that was sent. A command whose first array is in flight in ``last``
            counts without it.
    """
    body = last.robot
    flight, motion = body.flight, body.motion
    if maybe is not None and flight is None and not command_outcome.refusal(robot, body, maybe):
        moment = Moment(robot, program, False, 0.0)
        begun = commands.begin(moment, body, last.sensing, maybe, None, "")
        flight, motion = begun.flight, begun.motion
    found = [Hypothesis("recorded", _at_rest(robot, program, last, body))]
    if flight is not None and motion is not None and flight.purpose == "gate":
        sent = _after(robot, body, flight, motion)
        name = robot.commands[motion.command].name
        drives = any(flight.values[slot] for slot in robot.safe_zero)
        found.append(Hypothesis("sent", _at_rest(robot, program, last, sent), name, drives))
    return tuple(found)


def unproven(robot: RobotSpec, body: RobotState) -> Marks:
    """Return the marks of a robot of which nothing is confirmed any more.

    What had been confirmed is *declared*: sensors may confirm it. What was not confirmed keeps its
    mark, which only a command removes.
    """
    here = body.configuration
    kept = {mark for mark in body.marks if mark.command not in (DECLARED, STOPPED)}
    known = {(mark.kind, mark.which) for mark in kept}
    every = {Mark("part", part, DECLARED) for part in robot.held[here]}
    every |= {Mark("region", region, DECLARED) for region in range(len(robot.regions))}
    kept |= {mark for mark in every if (mark.kind, mark.which) not in known}
    return frozenset(kept | {Mark("region", each, STOPPED) for each in robot.driven[here]})


def denied(
    robot: RobotSpec, program: Program, last: EngineState, rest: RobotState
) -> Iterator[Mark]:
    """Yield the marks; those that the last known signals contradict are denied.

    A part that stands across the mouth of a tee, for example, shows another diameter. There the
    sensors say nothing now either, and a command must confirm the part. Wheels that turned may
    have come to rest since.
    """
    names, setpoints = states_of(robot, rest), at_rest_in(robot, rest.configuration).values
    for mark in rest.marks:
        numbers, diameter_m = last.sensing.numbers, program.diameter_m
        wheels = kind_of(robot, names, mark) in OF_WHEELS
        if mark.command != DECLARED or wheels:
            yield mark
        elif verdict(robot, setpoints, rest, mark, numbers, diameter_m).against:
            yield mark._replace(command=DENIED)
        else:
            yield mark


def _after(robot: RobotSpec, body: RobotState, flight: Flight, motion: Motion) -> RobotState:
    """Return the robot after the acceptance of a command's first array."""
    return body._replace(
        configuration=motion.target,
        marks=command_outcome.marks_after(robot, body.configuration, body.marks, motion.command),
        values=flight.values,
        seeking=flight.seeking,
    )


def _at_rest(robot: RobotSpec, program: Program, last: EngineState, body: RobotState) -> RobotState:
    """Return the robot with nothing under way, everything unconfirmed and the values of a hold."""
    rest = RobotState(
        body.configuration,
        safe_values(robot, body, last.sensing.numbers),
        marks=unproven(robot, body),
        next_id=body.next_id + (body.flight is not None),
        control=body.control,
    )
    return rest._replace(marks=frozenset(denied(robot, program, last, rest)))


# --- how far it has driven --------------------------------------------------------------------


class DarkWay(NamedTuple):
    """How far the robot has driven while nobody recorded it.

    Attributes:
        low_m: Least way, by the sign of odometry; ``high_m`` the largest.
        exact: Whether the way is known; it is the same as both bounds then.
        why: How it is known, or why it is not, for people.
        moved: What the wheels show that the motors cannot have done; empty if nothing.
        seen: Number indexes of the wheel angles that count on from where they were.
    """

    low_m: float
    high_m: float
    exact: bool
    why: str
    moved: str = ""
    seen: frozenset[int] = frozenset()


def dark_way(robot: RobotSpec, last: EngineState, numbers: Numbers, driven_s: float) -> DarkWay:
    """Return how far the robot has driven.

    The largest speed of the wheels bounds the way. The wheels that were driven show it if at least
    two of them do and all of these agree. An absolute angle shows it up to whole turns, if the
    bound is below half a turn. A counted angle shows it unless its counter may have begun anew,
    which is so if it is as near to zero as the robot can have driven since.

    Args:
        robot: The robot.
        last: The engine's last recorded state.
        numbers: The signals now.
        driven_s: How long the wheels may have been driven meanwhile; infinite if nobody knows, 0 if
            none was.
    """
    dark = robot.sight.dark
    most_m = dark.top_m_s * driven_s if driven_s else 0.0
    ways = [way for way in _ways(robot, last, numbers, most_m) if way.driven or not driven_s]
    rolled_m = [way.rolled_m for way in ways]
    shown = "wheels have rolled " + ", ".join(f"{way * 1000:z.0f}" for way in rolled_m) + " mm"
    seen = frozenset(way.angle for way in ways)
    if not driven_s:
        if last.robot.motion is None and max(map(abs, rolled_m), default=0.0) > dark.agree_m:
            moved = f"no wheel was driven, but {shown}"
            return DarkWay(-inf, inf, False, moved, moved)
        return DarkWay(0.0, 0.0, True, "no wheel was driven", "", seen)
    level = [way.level_m for way in ways]
    if max(map(abs, level), default=0.0) > most_m + dark.agree_m:
        moved = f"{shown}, but driven they can have {most_m * 1000:.0f} mm"
        return DarkWay(-inf, inf, False, moved, moved)
    if len(ways) > 1 and max(level) - min(level) <= dark.agree_m:
        way_m = sum(rolled_m) / len(ways)
        return DarkWay(way_m, way_m, True, f"{len(ways)} driven wheels agree on it", "", seen)
    why = f"its {shown}" if len(ways) > 1 else "its wheels do not show it"
    return DarkWay(-most_m, most_m, False, why)


def odometry_m(robot: RobotSpec, last: Sensing, way: DarkWay) -> float:
    """Return the odometry with the middle of the way added; NaN if the robot has no odometry."""
    if robot.odometry < 0:
        return nan
    known = last.numbers[robot.odometry]
    return known + (way.low_m + way.high_m) / 2 if way.high_m < inf else known


class _Way(NamedTuple):
    """The way of one wheel.

    Attributes:
        angle: Number index of its angle.
        driven: Whether it was driven when the recording ends.
        rolled_m: Way since its board was recorded last.
        level_m: Way since the last of all boards was, for comparison.
    """

    angle: int
    driven: bool
    rolled_m: float
    level_m: float


def _ways(robot: RobotSpec, last: EngineState, numbers: Numbers, most_m: float) -> Iterator[_Way]:
    """Yield the way of each wheel that shows it."""
    dark, sensing = robot.sight.dark, last.sensing
    for wheel, board in zip(robot.wheels, robot.wheel_boards, strict=True):
        was, now = sensing.angles[wheel.place], numbers[wheel.angle]
        size_m = abs(wheel.metres_per_rad)
        if isnan(was) or isnan(now):
            continue
        if wheel.place in dark.absolute:
            if most_m >= pi * size_m:
                continue
            rolled_m = remainder(now - was, 2 * pi) * wheel.metres_per_rad
        elif abs(now) * size_m > most_m + dark.agree_m:
            rolled_m = (now - was) * wheel.metres_per_rad
        else:
            continue
        speed_m_s = sensing.numbers[wheel.speed] * wheel.metres_per_rad
        earlier_s = max(sensing.heard_s) - sensing.heard_s[board]
        level_m = rolled_m - (0.0 if isnan(speed_m_s) else speed_m_s * earlier_s)
        yield _Way(wheel.angle, last.robot.latest[wheel.slot] != 0, rolled_m, level_m)
