"""Makes messages of a run's notes, and pieces of the file of the messages."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any, NamedTuple

from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import Effect
from pirate_sm.recording.format.engine_state_text import state_to_text
from pirate_sm.recording.format.engine_topics import STATE, Input, Remembered, Topic, Topics
from pirate_sm.recording.write.recording_file import RecordingFile
from pirate_sm.recording.write.side_channel import Sample, SideChannel

_BATCH_S = 2.0
"""The longest mission time in one message, s."""


class StepNote(NamedTuple):
    """An input of the engine and its effects, as noted by the run."""

    event: Input
    at_s: float
    effects: Sequence[Effect]


class StateNote(NamedTuple):
    """The engine's state after the previous note."""

    at_s: float
    state: EngineState


class WrittenPiece(NamedTuple):
    """Bytes to write at once; ``until_s`` is the time of the last note in them."""

    data: bytes
    until_s: float | None


class PieceMaker:
    """Turns notes into messages, and messages into pieces of the file.

    Two threads must not use it at the same time.

    Args:
        file: Receives the messages.
        topics: Topics of the engine's inputs and effects.
        side: Makes the messages for viewers.

    Attributes:
        steps: Number of steps of the engine in the next piece.
    """

    def __init__(self, file: RecordingFile, topics: Topics, side: SideChannel | None) -> None:
        self.steps = 0
        self._file = file
        self._topics = topics
        self._side = side
        self._step = 0
        self._since_s = 0.0
        self._until_s: float | None = None
        self._rows: dict[Topic, list[tuple[Any, ...]]] = defaultdict(list)

    def take(self, note: StepNote | Sample | StateNote) -> None:
        """Add the note to the next piece."""
        match note:
            case StepNote():
                self._add(note)
            case StateNote(at_s, state):
                row = (self._step - 1, at_s, Remembered(state_to_text(state)))
                self._rows[STATE].append(row)
            case Sample() if self._side is not None:
                self._side.show(self._file, note)
            case Sample():
                pass

    def cut(self) -> WrittenPiece:
        """Return everything since the last cut as bytes; empty if there is nothing."""
        self._batch()
        self.steps = 0
        return WrittenPiece(self._file.cut(), self._until_s)

    def _add(self, note: StepNote) -> None:
        if note.at_s >= self._since_s + _BATCH_S:
            self._batch()
            self._since_s = note.at_s
        step, at_s, rows, topics = self._step, note.at_s, self._rows, self._topics
        self._until_s = at_s
        self._step = step + 1
        self.steps += 1
        rows[topics.of_input(note.event)].append((step, at_s, note.event))
        for place, effect in enumerate(note.effects):
            row = (step, at_s, place, effect)
            rows[topics.of_effect(effect)].append(row)
        if note.effects and self._side is not None:
            self._side.show_effects(self._file, note.at_s, note.effects)

    def _batch(self) -> None:
        """Make messages of the rows gathered so far."""
        for topic, rows in self._rows.items():
            data = topic.encode(rows)
            self._file.add(topic.name, rows[0][1], data, topic.schema, topic.schema_name)
        self._rows.clear()
