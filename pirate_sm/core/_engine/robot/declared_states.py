"""Compare the declared states of the robot with its sensors before it moves.

At the start of a run with sensors every state and every held part is marked as declared, and again
each time that the controller was away. For a limited time the sensors are compared with the marks,
by the criteria in the profile's ``seen``. A confirmed mark is removed. A contradicted mark refuses
the start, or ends the run. A mark that stays open, because a signal is unknown or lies between the
limits, remains until a command confirms the state.
"""

from __future__ import annotations

from functools import lru_cache
from math import inf, isnan, nan
from typing import NamedTuple

from pirate_sm.core._engine.moment import has_come
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.criteria import OF_WHEELS
from pirate_sm.core._engine.robot.evidence import SensorVerdict, kind_of, verdict
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    DECLARED,
    LAPSED,
    MOST_REMEMBERED,
    STOPPED,
    Mark,
    Marks,
    RobotState,
    at_rest_in,
    states_of,
)
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._model.faults import BuiltInFault

CODE = BuiltInFault.START_CONTRADICTED.code

LOOKING = "the sensors are still being compared with the states that were declared"


class Watched(NamedTuple):
    """A mark, with the times since which the sensors agree with it and contradict it, or NaN."""

    mark: Mark
    agrees_s: float = nan
    against_s: float = nan
    told: str = ""
    for_s: float = 0.0

    def after(self, shown: SensorVerdict, now: float, *, strange: bool = False) -> Watched:
        """Return it with what sensors show now; while something is strange they agree with none."""
        agrees_s = since(self.agrees_s, shown.agrees and not strange, now)
        against_s = since(self.against_s, bool(shown.against), now)
        return Watched(self.mark, agrees_s, against_s, shown.against, shown.for_s)

    def is_confirmed(self, now: float) -> bool:
        """Return whether the sensors have agreed for long enough."""
        return has_come(now, self.agrees_s + self.for_s)

    def is_denied(self, now: float) -> bool:
        """Return whether they have contradicted it for long enough."""
        return has_come(now, self.against_s + self.for_s)


class Before(NamedTuple):
    """The robot as it was known when the connection to it was interrupted.

    Attributes:
        sensing: What its sensors had shown.
        body: Its state.
        away_s: How long its controller was silent; NaN if nobody knows.
        resumes: Whether the mission is paused until the comparison is over.
    """

    sensing: Sensing
    body: RobotState
    away_s: float
    resumes: bool


class Look(NamedTuple):
    """The state of a running comparison of sensors and declared states.

    Attributes:
        until_s: Latest end of the comparison.
        setpoints: Setpoints of the declared configuration.
        marks: Marks that are not decided yet.
        before: The robot before the connection was interrupted; None at the start of a run.
        strange_s: Since when it differs from that; NaN while it does not.
    """

    until_s: float
    setpoints: Numbers
    marks: tuple[Watched, ...]
    before: Before | None = None
    strange_s: float = nan

    @property
    def due_s(self) -> float:
        """Return the next time at which a mark is decided without a new frame."""
        lasting = [each.agrees_s + each.for_s for each in self.marks if not isnan(each.agrees_s)]
        return min((self.until_s, *lasting))

    def uncontradicted(self) -> Look:
        """Return it without what contradicts marks, which counts where a comparison ends."""
        return self._replace(
            marks=tuple(each._replace(against_s=nan, told="") for each in self.marks)
        )


class LookResult(NamedTuple):
    """The result of a comparison: its new state, confirmed marks, and contradictions.

    Attributes:
        look: The comparison; None once it is over.
        turning: Whether wheels turn that were declared to stand or to turn the other way.
    """

    look: Look | None
    confirmed: frozenset[Mark]
    contradictions: tuple[str, ...] = ()
    turning: bool = False


def declared_in(robot: RobotSpec, configuration: int) -> RobotState:
    """Return a robot declared to be in a configuration, with everything unconfirmed.

    Its wheels count as not driven in any case: only a command drives them.
    """
    rest = at_rest_in(robot, configuration)
    values = list(rest.values)
    for slot in robot.safe_zero:
        values[slot] = 0.0
    marks = {Mark("part", part, DECLARED) for part in robot.held[configuration]}
    marks |= {Mark("region", region, DECLARED) for region in range(len(robot.regions))}
    marks |= {Mark("region", region, STOPPED) for region in robot.driven[configuration]}
    return rest._replace(values=tuple(values), marks=frozenset(marks))


def begin(
    robot: RobotSpec, body: RobotState, now: float, before: Before | None = None
) -> Look | None:
    """Return a new comparison; None where the sensors could show none of the declared states.

    After an interruption there always is one, because the whole robot is compared.
    """
    names = states_of(robot, body)
    marks = tuple(
        Watched(mark)
        for mark in sorted(body.marks)
        if mark.command == DECLARED and kind_of(robot, names, mark) not in ("", "accepted")
    )
    if not marks and before is None:
        return None
    setpoints = at_rest_in(robot, body.configuration).values
    return Look(now + robot.sight.within_s, setpoints, marks, before)


def seen_again(robot: RobotSpec, before: Look | None, body: RobotState) -> Look | None:
    """Return the comparison for parts whose sensors were not known; None without any.

    It has no end: a part stays unconfirmed until its sensors or a command show that it holds.

    Args:
        robot: The robot.
        before: The comparison so far.
        body: The robot's state, with the marks of these parts.
    """
    lapsed = lapsed_in(body.marks)
    if not lapsed:
        return None
    known = {each.mark: each for each in before.marks} if before is not None else {}
    marks = tuple(known.get(mark, Watched(mark)) for mark in lapsed)
    return Look(inf, at_rest_in(robot, body.configuration).values, marks)


def as_last_seen(body: RobotState) -> RobotState:
    """Return the robot as it is if the parts hold whose sensors are not known now."""
    lapsed = lapsed_in(body.marks)
    return body._replace(marks=body.marks.difference(lapsed)) if lapsed else body


@lru_cache(maxsize=MOST_REMEMBERED)
def lapsed_in(marks: Marks) -> tuple[Mark, ...]:
    """Return in order the marks of parts whose sensors are not known now."""
    return tuple(sorted(mark for mark in marks if mark.command == LAPSED))


def awaiting(robot: RobotSpec, body: RobotState) -> frozenset[Mark]:
    """Return the declared states that only the next accepted setpoints can confirm."""
    names = states_of(robot, body)
    return frozenset(
        mark
        for mark in body.marks
        if mark.command == DECLARED and kind_of(robot, names, mark) == "accepted"
    )


def accepted(robot: RobotSpec, body: RobotState) -> RobotState:
    """Confirm the declared states whose only criterion is accepted setpoints."""
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
    strange: tuple[str, ...] = (),
) -> LookResult:
    """Return the result of the comparison at this moment.

    Args:
        robot: The robot.
        before: The comparison so far.
        body: The declared state of the robot.
        numbers: Signals in SI.
        diameter_m: Inner diameter of the pipe; None where it is unknown.
        now: Time in seconds.
        strange: What the robot cannot have changed while it was away. While there is any, nothing
            is confirmed; once it has lasted, the comparison is over.
    """
    open_: list[Watched] = []
    confirmed: set[Mark] = set()
    lasting_s = max((part.for_s for part in robot.sight.parts if part is not None), default=0.0)
    strange_s = since(before.strange_s, bool(strange), now)
    over = has_come(now, before.until_s) or has_come(now, strange_s + lasting_s)
    for each in before.marks:
        if each.mark not in body.marks:
            continue
        shown = verdict(robot, before.setpoints, body, each.mark, numbers, diameter_m)
        watched = each.after(shown, now, strange=bool(strange))
        if watched.is_confirmed(now):
            confirmed.add(each.mark)
        else:
            open_.append(watched)
    if (open_ or strange) and not over:
        following = before._replace(marks=tuple(open_), strange_s=strange_s)
        return LookResult(following, frozenset(confirmed))
    wrong = [each for each in open_ if each.is_denied(now)]
    names = states_of(robot, body)
    turning = any(kind_of(robot, names, each.mark) in OF_WHEELS for each in wrong)
    told = tuple(f"{_declared(robot, body, each.mark)}, but {each.told}" for each in wrong)
    return LookResult(None, frozenset(confirmed), strange or told, turning)


def parts_left_open(robot: RobotSpec, body: RobotState) -> tuple[str, ...]:
    """Return the names of parts that are declared to hold and are not confirmed."""
    open_ = sorted(m.which for m in body.marks if m.kind == "part" and m.command == DECLARED)
    return tuple(robot.parts[part] for part in open_)


# --- inside ---------------------------------------------------------------------------------


def since(since_s: float, holds: bool, now: float) -> float:
    """Return since when something holds; NaN while it does not."""
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
