"""Plays an event sequence in a trace: its events happen one after the other, and no others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf, isfinite

from pirate_sm.core.effects import (
    Ask,
    Effect,
    Ended,
    Log,
    PhaseChange,
    TriggerFired,
    WaitArmed,
    WakeAt,
)
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import (
    Answer,
    CommandFailed,
    Event,
    FaultReport,
    SignalReport,
    SubmitStatus,
    Tick,
)
from pirate_sm.core.mission import Happening
from pirate_sm.core.program import Program, Question, Wait
from pirate_sm.core.robot import RobotSpec
from pirate_sm.running.runtime.first_choice import FirstChoice
from pirate_sm.running.runtime.trace_repeats import LoopWatch
from pirate_sm.running.runtime.trigger_script import TriggerScript

_EARLIER_S = 1e-10
"""Time events come this much before a deadline, so that the loop does not report it first."""


def longest_s(course: Sequence[Happening], robot: RobotSpec, program: Program) -> float:
    """Return the longest time that a course can take, s: its longest deadline for each event."""
    deadlines = [command.nominal_s for command in robot.commands]
    for each in program.instructions:
        if isinstance(each, Wait):
            deadlines += [each.within_s, *(trigger.held_s for trigger in each.triggers)]
            deadlines += [trigger.after_s or 0.0 for trigger in each.triggers]
        elif isinstance(each, Question):
            deadlines.append(each.timeout_s)
    longest = max((each for each in deadlines if isfinite(each)), default=0.0)
    return longest * sum(each.happens == "time" for each in course)


class CoursePlayer:
    """A companion that makes the events happen; after the last one all goes well.

    Args:
        course: The events, without the start, and the signals after each.
        program: The mission.
        decide: Sets the result of the array under way.
        release: Is called when arrays need no decision any more.

    Attributes:
        over: Whether all events have happened.
    """

    listening = False

    def __init__(
        self,
        course: Sequence[tuple[Happening, SignalReport | None]],
        program: Program,
        decide: Callable[[SubmitStatus, str], None],
        release: Callable[[], None],
    ) -> None:
        self._left = list(course)[::-1]
        self._decide = decide
        self._release = release
        self._wake_s = inf
        self._open: dict[type[Effect], Effect] = {}
        self._after = (
            LoopWatch(lambda: 0),
            TriggerScript(program),
            FirstChoice("the event sequence is over"),
        )
        self.over = False
        self.due_s = 0.0
        if not course:
            self._finish(0.0)

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Remember what the mission waits for."""
        for effect in effects:
            if isinstance(effect, WakeAt):
                self._wake_s = effect.at_s
            elif isinstance(effect, TriggerFired | PhaseChange | Ended):
                self._open.pop(WaitArmed, None)
            elif isinstance(effect, WaitArmed | Ask):
                self._open[type(effect)] = effect
        if self.over:
            for companion in self._after:
                companion.react(effects, now_s)
        self._plan(now_s)

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """After the last event, show the state to the companions that take over."""
        if not self.over:
            return ()
        return [
            line for each in self._after if now_s >= each.due_s for line in each.look(state, now_s)
        ]

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the next event."""
        if self.over:
            said = [
                event for each in self._after if now_s >= each.due_s for event in each.speak(now_s)
            ]
            self._plan(now_s)
            return said
        event, report = self._left.pop()
        said = [*([report] if report is not None else ()), *self._said(event)]
        if not self._left:
            self._finish(now_s)
        self._plan(now_s)
        return said

    def _said(self, event: Happening) -> Sequence[Event]:
        match event.happens:
            case "accepted" | "rejected" as fate:
                self._decide(fate, "" if fate == "accepted" else "so the event sequence")
            case "not_done":
                return (CommandFailed("not done in time, so the event sequence"),)
            case "answer":
                return (Answer(event.answer or ""),)
            case "fault":
                message = event.message or "so the event sequence"
                return (FaultReport(event.fault or "", message, of=event.of),)
            case "time" | "sensors":
                return (Tick(),)
            case "start":
                pass
        return ()

    def _plan(self, now_s: float) -> None:
        if self.over:
            self.due_s = min(each.due_s for each in self._after)
            return
        event, _ = self._left[-1]
        self.due_s = max(now_s, self._wake_s - _EARLIER_S) if event.happens == "time" else now_s

    def _finish(self, now_s: float) -> None:
        """Accept arrays, fire first triggers and give first answers from now on."""
        self.over = True
        self._release()
        for companion in self._after:
            companion.react(tuple(self._open.values()), now_s)
