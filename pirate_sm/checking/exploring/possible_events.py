"""List the events that robot, sensors or operator can cause next."""

from __future__ import annotations

from collections.abc import Iterator
from math import isinf
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import Answer, CommandFailed, Event, FaultReport, SubmitResult, Tick
from pirate_sm.core.program import HandlerSpec, Program, Question, Wait, awaits_torques
from pirate_sm.core.robot import RobotSpec, confirmed_parts, obeyed

Kind: TypeAlias = Literal[
    "start", "accepted", "rejected", "time", "lasting", "failed", "sensors", "answer", "fault"
]

NOT_DONE = "not done in time"
UNSAID = "so the check"
"""Message of a fault without a rule of the robot, which therefore denies no clamp."""

REFUSED = "the backend refused the setpoints"


class PossibleEvent(NamedTuple):
    """One possible event.

    Attributes:
        kind: ``time``: the next deadline comes, at which a command counts as done. ``sensors``: the
            signals change. ``lasting``: the signals alternate for a time, so that a wait continues.
        event: The event for the engine.
        at_s: Time of the event.
        word: The operator's answer, or the fault's code.
    """

    kind: Kind
    event: Event
    at_s: float
    word: str = ""


_Question: TypeAlias = tuple[str, frozenset[str] | None, tuple[str | None, ...]]
_Situation: TypeAlias = tuple[tuple[HandlerSpec, ...], tuple[str | None, ...], frozenset[int]]


class Moves:
    """Lists the possible events of a state.

    Args:
        robot: The robot with its faults.
        program: The mission.
        conditions: Decides whether a fault's rule can be true.
    """

    def __init__(self, robot: RobotSpec, program: Program, conditions: Conditions) -> None:
        self._robot = robot
        self._program = program
        self.conditions = conditions
        self._possible: dict[_Question, tuple[FaultReport, ...]] = {}
        self._reports: dict[_Situation, tuple[FaultReport, ...]] = {}

    def of(self, state: EngineState, now: float) -> Iterator[PossibleEvent]:
        """Yield all events that can happen next, in the order of the engine."""
        mission, body = state.mission, state.robot
        if body.flight is not None:
            number = body.flight.setpoint_id
            yield PossibleEvent("accepted", SubmitResult(number, "accepted"), now)
            if body.flight.purpose == "gate":
                yield PossibleEvent("rejected", SubmitResult(number, "rejected", REFUSED), now)
            elif mission.diverting is None and awaits_torques(self._program, state):
                yield PossibleEvent("failed", CommandFailed(NOT_DONE), now)
        elif body.motion is not None and mission.diverting is None:
            yield PossibleEvent("time", Tick(), state.wake_at_s)
            yield PossibleEvent("failed", CommandFailed(NOT_DONE), now)
        if mission.diverting is not None:
            return
        if mission.begun:
            yield from self._spoken(state, now)
        if not mission.handling:
            yield from self._faults(state, now)

    def _spoken(self, state: EngineState, now: float) -> Iterator[PossibleEvent]:
        """Yield the events for which a wait or a question waits."""
        it = self._program.instructions[state.mission.pc]
        if isinstance(it, Wait):
            if any(trigger.condition is not None for trigger in it.triggers):
                yield PossibleEvent("sensors", Tick(), now)
            for trigger in it.triggers:
                if trigger.answer:
                    yield PossibleEvent("answer", Answer(trigger.answer), now, trigger.answer)
        elif isinstance(it, Question):
            for choice, _ in it.choices:
                yield PossibleEvent("answer", Answer(choice), now, choice)
        else:
            return
        if not isinf(state.wake_at_s):
            yield PossibleEvent("time", Tick(), state.wake_at_s)

    def _faults(self, state: EngineState, now: float) -> Iterator[PossibleEvent]:
        """Yield one fault for each handler that can be needed and each clamp that it denies."""
        robot = self._robot
        situation = (
            self._program.handlers[state.mission.pc],
            obeyed(robot, state.robot),
            confirmed_parts(robot, state.robot),
        )
        reports = self._reports.get(situation)
        if reports is None:
            reports = self._reports[situation] = tuple(self._needed(*situation))
        for report in reports:
            yield PossibleEvent("fault", report, now, report.code)

    def _needed(
        self,
        handlers: tuple[HandlerSpec, ...],
        states: tuple[str | None, ...],
        clamped: frozenset[int],
    ) -> Iterator[FaultReport]:
        """Yield the possible faults, one for each target and set of denied clamps."""
        known = set()
        robot = self._robot
        for place, handler in enumerate(handlers):
            for report in self.reports(handler, states):
                things = robot.owners.things_of(report.of)
                if any(each.handles(report.code, things) for each in handlers[:place]):
                    continue  # an inner handler hides the outer ones
                denied = robot.denied_by_report(report) & clamped
                if (handler.go, denied) in known or (handler.go is None and not denied):
                    continue  # without effect, or with the same effect as another fault
                known.add((handler.go, denied))
                yield report if denied else report._replace(message=UNSAID)

    def reports(
        self, handler: HandlerSpec, states: tuple[str | None, ...]
    ) -> tuple[FaultReport, ...]:
        """Return the reports of the fault that are possible in these states, for this handler.

        A fault without a rule is always possible.
        """
        key = handler.code, handler.of, states
        if key not in self._possible:
            own = [rule for rule in self._robot.faults if rule.code == handler.code]
            if own:
                found = [
                    FaultReport(rule.code, rule.message, of=rule.of)
                    for rule in own
                    if self.conditions.ask([(rule.when.tree, True)], states).possible
                ]
            else:
                whose = self._robot.possible_owners.get(handler.code, frozenset())
                named = whose if handler.of is None else whose & handler.of
                each = [(name,) for name in sorted(named)] if named else [()]
                found = [FaultReport(handler.code, UNSAID, of=of) for of in each]
            things = self._robot.owners.things_of
            self._possible[key] = tuple(
                each for each in found if handler.handles(each.code, things(each.of))
            )
        return self._possible[key]
