"""Lets a backend take frames for the engine, and look for a detector, while nothing happens."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pirate_sm.core.companion import Companion, Relieved
from pirate_sm.robot.backends.protocol import Gliding

if TYPE_CHECKING:
    from pirate_sm.core.engine import Engine, EngineState
    from pirate_sm.core.events import WordWatch
    from pirate_sm.core.sensing import Glide
    from pirate_sm.robot.backends.protocol import Backend


class QuietTime:
    """Lets time run without the engine, as long as nothing but signals changes.

    Args:
        engine: The engine.
        backend: The backend.
        companions: The companions. One whose looks others can make is relieved of them; time stays
            below the next call of the others.
    """

    def __init__(self, engine: Engine, backend: Backend, companions: Sequence[Companion]) -> None:
        self._engine = engine
        self._backend = backend if isinstance(backend, Gliding) else None
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
        watch = self._engine.watch(state) if backend is not None else None
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
