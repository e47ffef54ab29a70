"""Between a backend and a run: frames while nothing happens, the safe array, remarks, slides."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from math import inf

from pirate_sm.core.companion import Companion, CompanionBase, Relieved
from pirate_sm.core.effects import Effect, Log
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.events import BuiltInFault, Event, FaultReport, WordWatch
from pirate_sm.core.robot import confirmed_parts
from pirate_sm.core.sensing import Glide, Lookout
from pirate_sm.robot.backends.protocol import Backend, Gliding

# --- companions -----------------------------------------------------------------------------------


_LOOK_S, _SLID_M = 0.6, 0.1
"""A loose robot that straightens moves its wheels apart. One whose wheels have all moved the same
way by more than this has slid. Its own sensors show a fall in less time [decided]."""


class Holder(CompanionBase):
    """Passes the safe array to the backend at every turn, to be sent should this process die.

    Args:
        hold: Receives the current safe array and the slots that position loops drive.
    """

    due_s = inf

    def __init__(self, hold: Callable[[tuple[float, ...], Collection[int]], None]) -> None:
        self._hold = hold
        self._engine: Engine | None = None
        self._state: Callable[[], EngineState | None] = lambda: None

    def follow(self, engine: Engine, state: Callable[[], EngineState | None]) -> None:
        """Follow this run from now on."""
        self._engine, self._state = engine, state

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Pass on the current safe array, and the slots that position loops drive."""
        state = self._state()
        if self._engine is not None and state is not None:
            self._hold(self._engine.safe_values(state), self._engine.seeking(state))


class Messenger(CompanionBase):
    """Passes the backend's remarks on to people while the mission itself is stopped.

    Args:
        remark: Returns each remark of the backend once; empty if there is none.
    """

    def __init__(self, remark: Callable[[], str]) -> None:
        self._remark = remark
        self._text = ""

    @property
    def due_s(self) -> float:
        """Now, if there is a remark; else infinite."""
        self._text = self._text or self._remark()
        return -inf if self._text else inf

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Return the backend's remark."""
        text, self._text = self._text, ""
        return (Log("warning", text),)


class SlideWatch(CompanionBase):
    """Reports that a simulated robot has slid while no part held it and no wheel was driven.

    Perhaps no sensor shows it: the wheels do not turn, and friction lets the robot weigh nearly
    what it does at rest.

    Args:
        arcs_m: Returns the true position of each wheel along the pipe, m.
        fault: Returns what else the surroundings have to report, looked for all the time; None for
            a backend that reports it itself.
    """

    def __init__(
        self,
        arcs_m: Callable[[], Sequence[float]],
        fault: Callable[[], FaultReport | None] | None = None,
    ) -> None:
        self._arcs_m, self._fault = arcs_m, fault
        self._from_m: Sequence[float] = ()
        self._idle_s = inf if fault is None else _LOOK_S
        self.due_s = 0.0

    def follow(self, engine: Engine, state: Callable[[], EngineState | None]) -> None:
        """Follow this run from now on."""
        self._engine, self._state = engine, state

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Look from where the robot is loose, and once more when it is held or driven again."""
        if self._is_loose() != bool(self._from_m):
            self.due_s = now_s
            self._from_m = self._from_m or self._arcs_m()

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the fault of a robot that has slid, and those of the surroundings."""
        ways_m = [now - then for now, then in zip(self._arcs_m(), self._from_m, strict=False)]
        slid_m = max(min(ways_m), -max(ways_m)) if ways_m else 0.0
        loose = self._is_loose()
        self.due_s = now_s + (_LOOK_S if loose else self._idle_s)
        found = [self._fault()] if self._fault is not None else []
        if slid_m > _SLID_M:
            message = f"it has slid {slid_m:.2g} m while no part held it and no wheel was driven"
            found.append(BuiltInFault.ROBOT_SLID.report(message))
        if not loose or slid_m > _SLID_M:
            self._from_m = self._arcs_m() if loose else ()
        return [fault for fault in found if fault is not None]

    def _is_loose(self) -> bool:
        state = self._state()
        if state is None or confirmed_parts(self._engine.robot, state.robot):
            return False
        return not any(state.robot.values[slot] for slot in self._engine.robot.safe_zero)


# --- quiet time -----------------------------------------------------------------------------------


class QuietTime:
    """Lets time run without the engine, as long as nothing but signals changes.

    Args:
        engine: The engine.
        backend: The backend.
        companions: The companions. One whose looks others can make is relieved of them; time stays
            below the next call of the others.
    """

    def __init__(self, engine: Engine, backend: Backend, companions: Sequence[Companion]) -> None:
        self._backend = backend if isinstance(backend, Gliding) else None
        self._lookout = Lookout(engine) if self._backend is not None else None
        relieved = [each for each in companions if isinstance(each, Relieved)]
        self._relieved = relieved[0] if len(relieved) == 1 else None
        self._companions = tuple(companions)

    def run(self, state: EngineState, until_s: float) -> Glide | None:
        """Let time run.

        Args:
            state: The engine's state.
            until_s: Mission time that is not reached.

        Returns:
            What has passed, with the companion relieved of its looks; None if nothing has.
        """
        backend = self._backend
        watch = None if self._lookout is None else self._lookout.watch(state)
        if backend is None or watch is None:
            return None
        words = self._words(backend, state)
        for companion in self._companions:
            if words is None or companion is not self._relieved:
                until_s = min(until_s, companion.due_s)
        passed = backend.glide(watch, until_s, words)
        if passed is not None and words is not None and self._relieved is not None:
            self._relieved.relieve(passed.looks, passed.due_s, passed.said_s)
        return passed

    def _words(self, backend: Gliding, state: EngineState) -> WordWatch | None:
        """Return what the relieved detector knows; None if the backend cannot look for it."""
        words = self._relieved.word_watch(state) if self._relieved is not None else None
        return words if words is not None and words.places_m == backend.places_m else None
