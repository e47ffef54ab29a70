"""Fires triggers in a trace as a script lists them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf
from typing import NamedTuple

from pirate_sm.core.effects import Effect, Ended, Log, PhaseChange, TriggerFired, WaitArmed
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import Event, Skip
from pirate_sm.core.program import Program, Wait

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


class TriggerScript:
    """Fires triggers: as listed, otherwise the first trigger of each wait.

    A wait uses up the first entry that fits it.

    Args:
        program: The mission.
        firings: The entries, in order.

    Attributes:
        unused: Entries that no wait has used yet.
        forestalled: Entries whose wait ended for another reason before they were due.
    """

    listening = False

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
