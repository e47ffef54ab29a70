"""Which lines of a mission's file began when, and where the run was to pause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pirate_sm.core import effects as fx
from pirate_sm.core.documents import Place
from pirate_sm.core.engine import EngineState
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Enter, Finish, Question
from pirate_sm.running.runtime.breakpoints import breakables
from pirate_sm.views.report.contents import Stepping


class SteppingNotes:
    """Notes when each command, wait, question, phase and end of a mission began.

    Args:
        loaded: The mission.
        files: Names of its files in the run, in their order: they are elsewhere now.
    """

    def __init__(self, loaded: LoadedMission, files: Sequence[str] = ()) -> None:
        now = loaded.documents
        named = (replace(each, name=name) for each, name in zip(now, files, strict=False))
        documents = (*named, *now[len(files) :])
        own, program = documents[0].name, loaded.program
        self._program = program
        self._lines = {
            (each.place.file, each.place.line): each.line if each.place.file == own else 0
            for each in breakables(replace(loaded, documents=documents))
        }
        pairs = tuple(zip(program.instructions, program.phase_of, strict=True))
        self._phases = {phase: it.place for it, phase in pairs if isinstance(it, Enter)}
        self._ends = {it.end: it.place for it, _ in pairs if isinstance(it, Finish)}
        self._begun: list[tuple[float, int]] = []
        self._set: list[tuple[float, tuple[int, ...]]] = []
        self._places: tuple[str, ...] = ()

    def take(self, at_s: float, effects: Sequence[fx.Effect], state: EngineState | None) -> None:
        """Take in a step of the run, and the engine's state after it."""
        for effect in effects:
            line = self._line(self._begins(effect, state))
            if line is not None and (at_s, line) not in self._begun[-1:]:
                self._begun.append((at_s, line))
        if state is not None and state.mission.breakpoints != self._places:
            self._places = state.mission.breakpoints
            lines = {self._line(each) for each in self._places}
            self._set.append((at_s, tuple(sorted(each for each in lines if each))))

    def contents(self) -> Stepping:
        """Return what was noted so far."""
        own = tuple(sorted({line for line in self._lines.values() if line}))
        return Stepping(own, tuple(self._begun), tuple(self._set))

    def _begins(self, effect: fx.Effect, state: EngineState | None) -> str:
        """Return the place of the instruction that this effect shows to begin; empty if none."""
        match effect:
            case fx.CommandStatus(status="sent" | "skipped" | "refused", place=place):
                return place
            case fx.WaitArmed(place=place):
                return place
            case fx.PhaseChange(phase):
                return self._phases.get(phase, "")
            case fx.Ended(end=end):
                return self._ends.get(end, "")
            case fx.Ask(question) if question and state is not None:
                it = self._program.instructions[state.mission.pc]
                return it.place if isinstance(it, Question) else ""
            case _:
                return ""

    def _line(self, place: str) -> int | None:
        """Return its line in the mission's own file, 0 in another one, None if it is in no file."""
        if place.count(":") < 2:
            return None
        found = Place.read(place)
        return self._lines.get((found.file, found.line), 0)
