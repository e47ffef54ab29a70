"""Compare what is declared of the robot with its sensors before it moves.

A robot that starts with sensors has every state and every held part marked as declared. For a
bounded time the marks are compared with what the sensors show, by the profile's ``seen``. What
they confirm loses its mark. What they contradict refuses the start. What they leave open, because
a signal is unknown or lies between the limits, stays unconfirmed until a command has confirmed it.
"""

from __future__ import annotations

from math import isnan, nan
from typing import NamedTuple

from pirate_sm.engine.deadlines import has_come
from pirate_sm.engine.robot.confirmation_spec import DrivenSpec, StandingSpec
from pirate_sm.engine.robot.criteria import AcceptedSpec
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.robot.robot_state import (
    DECLARED,
    STOPPED,
    Mark,
    Numbers,
    RobotState,
    at_rest_in,
    states_of,
)
from pirate_sm.engine.robot.sensor_verdict import spec_of, verdict
from pirate_sm.model.fault_codes import BuiltInFault

CODE = BuiltInFault.START_CONTRADICTED.code

LOOKING = "the sensors are still being compared with the states that were declared"


_NEVER_SHOWN = (AcceptedSpec, type(None))


class Watched(NamedTuple):
    """A mark, since when the sensors agree with it and since when they contradict it, else NaN."""

    mark: Mark
    agrees_s: float = nan
    against_s: float = nan
    told: str = ""
    for_s: float = 0.0


class Look(NamedTuple):
    """The sensors are being compared with what is declared.

    Attributes:
        until_s: When that ends at the latest.
        setpoints: Those of the declared configuration.
        marks: What is not decided yet.
    """

    until_s: float
    setpoints: Numbers
    marks: tuple[Watched, ...]

    @property
    def due_s(self) -> float:
        """Return when time alone decides something."""
        lasting = [each.agrees_s + each.for_s for each in self.marks if not isnan(each.agrees_s)]
        return min((self.until_s, *lasting))


class LookResult(NamedTuple):
    """What has come of a look: where it stands, what is confirmed, and why the start is refused.

    Attributes:
        look: None once it is over.
        turning: Whether wheels turn that were declared to stand or to turn the other way.
    """

    look: Look | None
    confirmed: frozenset[Mark]
    contradictions: tuple[str, ...] = ()
    turning: bool = False


def declared_in(robot: RobotSpec, configuration: int) -> RobotState:
    """Return a robot that is said to be in a configuration, of which nothing is confirmed.

    Its wheels are not taken to be driven, whatever is said: only a command drives them.
    """
    rest = at_rest_in(robot, configuration)
    values = list(rest.values)
    for slot in robot.safe_zero:
        values[slot] = 0.0
    marks = {Mark("part", part, DECLARED) for part in robot.held[configuration]}
    marks |= {Mark("region", region, DECLARED) for region in range(len(robot.regions))}
    marks |= {Mark("region", region, STOPPED) for region in robot.driven[configuration]}
    return rest._replace(values=tuple(values), marks=frozenset(marks))


def begin(robot: RobotSpec, body: RobotState, now: float) -> Look | None:
    """Begin to look at what is declared; None where nothing of it could be seen."""
    names = states_of(robot, body)
    marks = tuple(
        Watched(mark)
        for mark in sorted(body.marks)
        if mark.command == DECLARED and not isinstance(spec_of(robot, names, mark), _NEVER_SHOWN)
    )
    if not marks:
        return None
    setpoints = at_rest_in(robot, body.configuration).values
    return Look(now + robot.sight.within_s, setpoints, marks)


def awaiting(robot: RobotSpec, body: RobotState) -> frozenset[Mark]:
    """Return the declared states that only the next accepted setpoints can confirm."""
    names = states_of(robot, body)
    return frozenset(
        mark
        for mark in body.marks
        if mark.command == DECLARED and isinstance(spec_of(robot, names, mark), AcceptedSpec)
    )


def accepted(robot: RobotSpec, body: RobotState) -> RobotState:
    """Confirm the declared states that the setpoints in force make, where nothing shows more."""
    names = states_of(robot, body)
    held = {
        mark
        for mark in awaiting(robot, body)
        if all(
            write.how != "set" or body.values[write.slot] == write.value
            for write in body.stages(robot, mark.which, names[mark.which])[-1]
        )
    }
    return body._replace(marks=body.marks - held) if held else body


def look(
    robot: RobotSpec,
    before: Look,
    body: RobotState,
    numbers: Numbers,
    diameter_m: float | None,
    now: float,
) -> LookResult:
    """Compare what is declared with the sensors at this moment.

    Args:
        robot: The robot.
        before: What was known so far.
        body: What the robot is declared to be.
        numbers: Signals in SI.
        diameter_m: Of the pipe; None where it is not known.
        now: Time in seconds.
    """
    open_: list[Watched] = []
    confirmed: set[Mark] = set()
    for each in before.marks:
        if each.mark not in body.marks:
            continue
        shown = verdict(robot, before.setpoints, body, each.mark, numbers, diameter_m)
        agrees_s = _since(each.agrees_s, shown.agrees, now)
        against_s = _since(each.against_s, bool(shown.against), now)
        if shown.agrees and has_come(now, agrees_s + shown.for_s):
            confirmed.add(each.mark)
        else:
            open_.append(Watched(each.mark, agrees_s, against_s, shown.against, shown.for_s))
    if open_ and not has_come(now, before.until_s):
        return LookResult(before._replace(marks=tuple(open_)), frozenset(confirmed))
    wrong = [each for each in open_ if has_come(now, each.against_s + each.for_s)]
    turning = any(
        isinstance(spec_of(robot, states_of(robot, body), each.mark), StandingSpec | DrivenSpec)
        for each in wrong
    )
    told = tuple(f"{_declared(robot, body, each.mark)}, but {each.told}" for each in wrong)
    return LookResult(None, frozenset(confirmed), told, turning)


def parts_left_open(robot: RobotSpec, body: RobotState) -> tuple[str, ...]:
    """Return the parts that are declared to hold and that the sensors have not confirmed."""
    open_ = sorted(m.which for m in body.marks if m.kind == "part" and m.command == DECLARED)
    return tuple(robot.parts[part] for part in open_)


# --- inside ---------------------------------------------------------------------------------


def _since(since_s: float, holds: bool, now: float) -> float:
    if not holds:
        return nan
    return now if isnan(since_s) else since_s


def _declared(robot: RobotSpec, body: RobotState, mark: Mark) -> str:
    names = states_of(robot, body)
    if mark.kind == "region":
        return f"{robot.regions[mark.which]} is declared {names[mark.which]}"
    states = ", ".join(
        f"{robot.regions[each]} {names[each]}" for each in sorted(robot.part_regions[mark.which])
    )
    return f"the {robot.parts[mark.which]} part is declared to hold ({states})"
