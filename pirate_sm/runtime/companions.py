"""Who stands beside a mission and tells the engine something: a script, an operator."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from math import inf
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol, runtime_checkable

from pirate_sm.engine.mission.program import Program, Wait
from pirate_sm.model.effects import (
    Ask,
    Effect,
    Ended,
    Log,
    PhaseChange,
    TriggerFired,
    WaitArmed,
)
from pirate_sm.model.events import Abort, Answer, Event, Skip

if TYPE_CHECKING:
    from pirate_sm.engine.robot.robot_spec import RobotSpec
    from pirate_sm.engine.state import EngineState
    from pirate_sm.runtime.loop import MissionRun

FIRST_TRIGGER_AFTER_S = 1.0


class Companion(Protocol):
    """Sees what the engine does and speaks up at times of its own choosing.

    Attributes:
        due_s: Mission time at which it wants to be asked next; infinite: not before ``react``.
        listening: Whether a person is being waited for, so that time must not run ahead of theirs.
    """

    @property
    def due_s(self) -> float:
        """When it wants to be asked next."""
        ...

    @property
    def listening(self) -> bool:
        """Whether a person is being waited for."""
        ...

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """It knows what has just happened."""
        ...

    def speak(self, now_s: float) -> Sequence[Event]:
        """What it has to say at ``due_s``, which it has moved on; often nothing."""
        ...


@runtime_checkable
class Onlooker(Protocol):
    """A companion that is shown the engine's state each time before it is asked to speak."""

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """It has looked; what it returns is told to whoever follows the run."""
        ...


@runtime_checkable
class Counting(Protocol):
    """A companion that counts from the beginning of a mission."""

    def restart(self, robot: RobotSpec) -> None:
        """Another mission begins with this robot, which is where it is; polarity may differ."""
        ...


class Firing(NamedTuple):
    """One entry of a script: in a wait that has this trigger, take it.

    Attributes:
        trigger: Name of the trigger, or ``within`` to let the time limit pass.
        after_s: How long after the wait was armed. None: at the trigger's own time if it has one,
            else before time ends the wait otherwise, at the latest ``FIRST_TRIGGER_AFTER_S`` later.
        phase: Only in this phase; empty for any.
    """

    trigger: str
    after_s: float | None = None
    phase: str = ""


class TriggerScript:
    """Fires triggers where nothing real can: as listed, else the first one of each wait.

    The first entry that fits a wait is used up by it.

    Args:
        program: The mission, whose waits it looks up.
        firings: What to fire, in order.

    Attributes:
        unused: Entries that no wait has used yet.
    """

    listening = False

    def __init__(self, program: Program, firings: Iterable[Firing] = ()) -> None:
        self.due_s = inf
        self.unused = list(firings)
        self._program = program
        self._armed = False
        self._trigger = ""

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Ask to look at a wait that has begun, and forget one that is over."""
        for effect in effects:
            if isinstance(effect, WaitArmed):
                self._armed, self.due_s = True, now_s
            elif isinstance(effect, TriggerFired | PhaseChange | Ended):
                self._armed, self.due_s = False, inf

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Plan the trigger of a wait that has just been armed."""
        wait = self._program.instructions[state.mission.pc]
        if self._armed and isinstance(wait, Wait):
            self._armed = False
            self._trigger, after_s = self._plan(wait)
            self.due_s = now_s + after_s
        return ()

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the planned trigger once it is due."""
        if now_s < self.due_s:
            return ()
        self.due_s = inf
        return (Skip(self._trigger),)

    def _plan(self, wait: Wait) -> tuple[str, float]:
        """Return the trigger to fire and how long after arming; infinite: let time pass."""
        names = [trigger.name for trigger in wait.triggers]
        for firing in self.unused:
            if firing.phase in ("", wait.phase) and firing.trigger in (*names, "within"):
                self.unused.remove(firing)
                if firing.trigger == "within":
                    return "", inf
                usual_s = _before_time(wait, firing.trigger)
                return firing.trigger, usual_s if firing.after_s is None else firing.after_s
        return (names[0], _before_time(wait, names[0])) if names else ("", inf)


def _before_time(wait: Wait, chosen: str) -> float:
    """Return when to fire the chosen trigger so that no other one comes first by time alone.

    One that time itself makes true comes at its time.
    """
    times = {each.name: each.after_s for each in wait.triggers if each.after_s is not None}
    own_s = times.pop(chosen, inf)
    limit_s = min([wait.within_s, *times.values()])
    return own_s if own_s < limit_s else min(FIRST_TRIGGER_AFTER_S, limit_s / 2)


class LoopWatch:
    """Ends a trace that comes back to a situation in which it has been before.

    Nothing but a script decides what happens in a trace. Once the same situation recurs and the
    script has nothing new for it, the mission would go on in the same way without end.

    Args:
        pending: Returns how many entries the script still holds.
    """

    listening = False

    def __init__(self, pending: Callable[[], int]) -> None:
        self.due_s = inf
        self._pending = pending
        self._seen: set[object] = set()
        self._repeated = ""

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Ask to look when the mission waits for something or asks something."""
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
        """Return the end of the run when the situation has recurred."""
        self.due_s = inf
        return (Abort(self._repeated),) if self._repeated else ()


LOOP = (
    "the trace has come back to a situation in which it has been before: from here the mission "
    "would repeat itself without end (name other triggers with --fire)"
)


def _asks(effect: Effect) -> bool:
    return isinstance(effect, Ask) and bool(effect.question)


class Holder:
    """Tells a backend at every turn what is to be held and what stopped, should this process die.

    Args:
        hold: What wants to know.
    """

    due_s = inf
    listening = False

    def __init__(self, hold: Callable[[tuple[float, ...], Collection[int]], None]) -> None:
        self._hold = hold
        self._run: MissionRun | None = None

    def follow(self, run: MissionRun) -> None:
        """It looks at this run."""
        self._run = run

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Pass on the safe array of this moment, and the slots that position loops drive."""
        values = self._run.safe_values() if self._run is not None else None
        if self._run is not None and values is not None:
            self._hold(values, self._run.seeking())

    def speak(self, now_s: float) -> Sequence[Event]:
        """Nothing."""
        return ()


class Messenger:
    """Passes on what a backend wants people to know while the mission itself stands still.

    Args:
        remark: What there is to be said now, once; empty: nothing.
    """

    listening = False

    def __init__(self, remark: Callable[[], str]) -> None:
        self._remark = remark
        self._text = ""

    @property
    def due_s(self) -> float:
        """At once when there is something."""
        self._text = self._text or self._remark()
        return -inf if self._text else inf

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """What happens is not its business."""

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """What the backend has to say."""
        text, self._text = self._text, ""
        return (Log("warning", text),)

    def speak(self, now_s: float) -> Sequence[Event]:
        """Nothing to the engine."""
        return ()


class Answered(Log):
    """A question got an answer; the message says which, and from whom."""

    __slots__ = ()


class FirstChoice:
    """Answers every question at once with the expected answer, where nobody is asked.

    Args:
        why: Why nobody is; kept beside each answer. Empty: answers are not kept.
        level: Of what is kept.
    """

    listening = False

    def __init__(self, why: str = "", level: Literal["info", "warning"] = "info") -> None:
        self._why = why
        self._level = level
        self.due_s = inf
        self._choice = ""

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """The first choice of a question is ready; a withdrawn question needs none."""
        for effect in effects:
            if isinstance(effect, Ask):
                asked = bool(effect.question and effect.choices)
                self._choice = effect.choices[0] if asked else ""
                self.due_s = now_s if asked else inf

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """What it is about to answer."""
        if not self._why:
            return ()
        return (Answered(self._level, f"answered '{self._choice}' ({self._why})"),)

    def speak(self, now_s: float) -> Sequence[Event]:
        """The answer."""
        self.due_s = inf
        return (Answer(self._choice),)
