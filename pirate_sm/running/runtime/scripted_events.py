"""What happens by a script: triggers, whole event sequences, first choices, the end of patience."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import inf, isfinite
from typing import Literal, NamedTuple

from pirate_sm.core.companion import CompanionBase
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
    Abort,
    Answer,
    CommandFailed,
    Event,
    FaultReport,
    SignalReport,
    Skip,
    SubmitStatus,
    Tick,
)
from pirate_sm.core.program import Program, Question, Wait
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot.backends.trace_script import Happening
from pirate_sm.running.runtime.ending import Stop, StopRequests

# --- answers --------------------------------------------------------------------------------------


class Answered(Log):
    """A question was answered automatically; the message has the answer and the reason."""

    __slots__ = ()


class FirstChoice(CompanionBase):
    """Answers every question immediately with the expected answer, because nobody can be asked.

    Args:
        why: Why nobody can be asked, for a log line with each answer. Empty: no log lines.
        level: Level of the log lines.
    """

    def __init__(self, why: str = "", level: Literal["info", "warning"] = "info") -> None:
        self._why = why
        self._level = level
        self.due_s = inf
        self._choice = ""

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Prepare the first choice of a question; drop that of a withdrawn question."""
        for effect in effects:
            if isinstance(effect, Ask):
                asked = bool(effect.question and effect.choices)
                self._choice = effect.choices[0] if asked else ""
                self.due_s = now_s if asked else inf

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Return a log line with the coming answer."""
        if not self._why:
            return ()
        return (Answered(self._level, f"answered '{self._choice}' ({self._why})"),)

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the answer."""
        self.due_s = inf
        return (Answer(self._choice),)


# --- patience -------------------------------------------------------------------------------------


LONGEST_S = 3600.0
"""A rehearsed mission that has not ended by then is stopped."""


class Patience(CompanionBase):
    """A companion that stops a run that does not end by itself."""

    def __init__(self, requests: StopRequests) -> None:
        self._requests = requests
        self.due_s = LONGEST_S

    def speak(self, now_s: float) -> Sequence[Event]:
        """Ask the run to end; return no event."""
        self.due_s = inf
        reason = f"it had not ended after {LONGEST_S:g} s"
        self._requests.ask(Stop(reason, 1))
        return ()


# --- repetitions ----------------------------------------------------------------------------------


class LoopWatch(CompanionBase):
    """Ends a trace that comes back to an earlier situation.

    Only a script decides what happens in a trace. If a situation recurs and the script has no new
    entry for it, the mission would repeat itself without end.

    Args:
        pending: Returns how many entries of the script are unused.
    """

    def __init__(self, pending: Callable[[], int]) -> None:
        self.due_s = inf
        self._pending = pending
        self._seen: set[object] = set()
        self._repeated = ""

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Ask to look when the mission begins a wait or asks a question."""
        if any(isinstance(each, WaitArmed) or _asks(each) for each in effects):
            self.due_s = now_s

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Compare the situation, without its times, with all earlier ones."""
        mission = state.mission._replace(
            armed_s=0.0, since=(), offset_s=0.0, second_s=0.0, entered=0
        )
        body = state.robot._replace(next_id=0)
        situation = (mission, body, state.words, state.rules, self._pending())
        self._repeated = LOOP if situation in self._seen else ""
        self._seen.add(situation)
        return ()

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the end of the run if the situation has recurred."""
        self.due_s = inf
        return (Abort(self._repeated),) if self._repeated else ()


LOOP = (
    "the trace has come back to a situation in which it has been before: from here the mission "
    "would repeat itself without end (other triggers must be fired)"
)


def _asks(effect: Effect) -> bool:
    return isinstance(effect, Ask) and bool(effect.question)


# --- triggers -------------------------------------------------------------------------------------


FIRST_TRIGGER_AFTER_S = 1.0


class Firing(NamedTuple):
    """One entry of a script: the trigger to fire in a wait that has it.

    Attributes:
        trigger: Name of the trigger, or ``within`` to let the time limit pass.
        after_s: Time after the start of the wait. None: the trigger's own time if it has one;
            otherwise before another trigger fires by time, at most ``FIRST_TRIGGER_AFTER_S``.
        phase: Only in this phase; empty for any.
    """

    trigger: str
    after_s: float | None = None
    phase: str = ""


class TriggerScript(CompanionBase):
    """Fires triggers: as listed, otherwise the first trigger of each wait.

    A wait uses up the first entry that fits it.

    Args:
        program: The mission.
        firings: The entries, in order.

    Attributes:
        unused: Entries that no wait has used yet.
        forestalled: Entries whose wait ended for another reason before they were due.
    """

    def __init__(self, program: Program, firings: Iterable[Firing] = ()) -> None:
        self.due_s = inf
        self.unused = list(firings)
        self.forestalled: list[Firing] = []
        self._planned: Firing | None = None
        self._program = program
        self._armed = False
        self._trigger = ""

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Ask to look at a new wait; forget a wait that is over."""
        for effect in effects:
            if isinstance(effect, WaitArmed):
                self._armed, self.due_s = True, now_s
            elif isinstance(effect, TriggerFired | PhaseChange | Ended):
                self._armed, self.due_s = False, inf
                planned, self._planned = self._planned, None
                by = effect.trigger if isinstance(effect, TriggerFired) else ""
                stopped = isinstance(effect, Ended) and effect.outcome == "interrupted"
                if planned is not None and planned.trigger != by and not stopped:
                    self.forestalled.append(planned)

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Plan the trigger of a wait that has just begun."""
        wait = self._program.instructions[state.mission.pc]
        if self._armed and isinstance(wait, Wait):
            self._armed = False
            self._trigger, after_s = self._plan(wait)
            self.due_s = now_s + after_s
        return ()

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the planned trigger when it is due."""
        if now_s < self.due_s:
            return ()
        self.due_s = inf
        return (Skip(self._trigger),)

    def _plan(self, wait: Wait) -> tuple[str, float]:
        """Return the trigger to fire and its time after the start; infinite: let time pass."""
        names = [trigger.name for trigger in wait.triggers]
        for firing in self.unused:
            if firing.phase in ("", wait.phase) and firing.trigger in (*names, "within"):
                self.unused.remove(firing)
                self._planned = firing
                if firing.trigger == "within":
                    return "", inf
                usual_s = _before_time(wait, firing.trigger)
                return firing.trigger, usual_s if firing.after_s is None else firing.after_s
        return (names[0], _before_time(wait, names[0])) if names else ("", inf)


def _before_time(wait: Wait, chosen: str) -> float:
    """Return when to fire the chosen trigger so that no other one fires first by time alone.

    A trigger that becomes true by time alone fires at that time.
    """
    times = {each.name: each.after_s for each in wait.triggers if each.after_s is not None}
    own_s = times.pop(chosen, inf)
    limit_s = min([wait.within_s, *times.values()])
    return own_s if own_s < limit_s else min(FIRST_TRIGGER_AFTER_S, limit_s / 2)


# --- event sequences ------------------------------------------------------------------------------


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


class CoursePlayer(CompanionBase):
    """A companion that makes the events happen; after the last one all goes well.

    Args:
        course: The events, without the start, and the signals after each.
        program: The mission.
        decide: Sets the result of the array under way.
        release: Is called when arrays need no decision any more.

    Attributes:
        over: Whether all events have happened.
    """

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
