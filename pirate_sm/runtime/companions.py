"""Who stands beside a mission and tells the engine something: a script, an operator."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import inf
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol, runtime_checkable

from pirate_sm.model.effects import (
    Ask,
    Effect,
    Ended,
    Log,
    PhaseChange,
    TriggerFired,
    WaitArmed,
)
from pirate_sm.model.events import Answer, Event, Skip

if TYPE_CHECKING:
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

    def restart(self) -> None:
        """Another mission begins, with the robot where it is."""
        ...


class Firing(NamedTuple):
    """One entry of a script: in a wait that has this trigger, take it.

    Attributes:
        trigger: Name of the trigger, or ``within`` to let the time limit pass.
        after_s: How long after the wait was armed.
        phase: Only in this phase; empty for any.
    """

    trigger: str
    after_s: float = FIRST_TRIGGER_AFTER_S
    phase: str = ""


class TriggerScript:
    """Fires triggers where nothing real can: as listed, else the first one of each wait.

    The first entry that fits a wait is used up by it.
    """

    listening = False

    def __init__(self, firings: Iterable[Firing] = ()) -> None:
        self.due_s = inf
        self.unused = list(firings)
        self._trigger = ""

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """The trigger of a wait that has begun is planned, that of one that is over is not."""
        for effect in effects:
            if isinstance(effect, WaitArmed):
                self._plan(effect, now_s)
            elif isinstance(effect, TriggerFired | PhaseChange | Ended):
                self.due_s = inf

    def speak(self, now_s: float) -> Sequence[Event]:
        """The planned trigger."""
        self.due_s = inf
        return (Skip(self._trigger),)

    def _plan(self, wait: WaitArmed, now_s: float) -> None:
        for firing in self.unused:
            if firing.phase in ("", wait.phase) and firing.trigger in (*wait.triggers, "within"):
                self.unused.remove(firing)
                self._trigger = firing.trigger
                self.due_s = inf if firing.trigger == "within" else now_s + firing.after_s
                return
        if wait.triggers:
            # A wait that is shorter than our usual second still sees its trigger.
            after_s = min(FIRST_TRIGGER_AFTER_S, (wait.deadline_s - now_s) / 2)
            self._trigger, self.due_s = wait.triggers[0], now_s + after_s


class Holder:
    """Tells a backend at every turn which array is the safe one now, should this process die.

    Args:
        hold: What wants to know.
    """

    due_s = inf
    listening = False

    def __init__(self, hold: Callable[[tuple[float, ...]], None]) -> None:
        self._hold = hold
        self._run: MissionRun | None = None

    def follow(self, run: MissionRun) -> None:
        """It looks at this run."""
        self._run = run

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """The safe array is that of this moment."""
        values = self._run.safe_values() if self._run is not None else None
        if values is not None:
            self._hold(values)

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
