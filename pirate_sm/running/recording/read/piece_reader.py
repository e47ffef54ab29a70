"""Decodes the pieces of a recording's file one at a time: its steps, effects and states."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

from pirate_sm import __version__
from pirate_sm.core.effects import Effect
from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import RecordingError
from pirate_sm.core.events import ALPHABET_VERSION
from pirate_sm.core.files import shown
from pirate_sm.running.recording.format.engine_state_text import (
    body_from_text,
    resumption_from_text,
    state_from_text,
)
from pirate_sm.running.recording.format.engine_topics import (
    STATE,
    Abandoned,
    Started,
    Topic,
    Topics,
)
from pirate_sm.running.recording.format.header import RunHeader
from pirate_sm.running.recording.read.chunks import Chunks
from pirate_sm.running.recording.read.header_reader import DamagedInsideError
from pirate_sm.running.recording.read.mcap_records import ChunkPlace, DamagedError
from pirate_sm.running.recording.read.steps import Message, RecordedStep, StepEffects


class FirstInput(NamedTuple):
    """The first input of a piece.

    Attributes:
        number: The number of its step.
        at_s: Its time by the engine's clock; ``time_ns``: the same, ns since 1970.
    """

    number: int
    at_s: float
    time_ns: int


class PieceReader:
    """Reads the pieces of one file and decodes their messages.

    Every method raises a ``RecordingError`` if the file cannot be read or is damaged.

    Args:
        path: The file.
        header: The header of the recording.
        pieces: The places of the pieces in the file.
        topics: Names of topics that are known already, by their numbers.
    """

    def __init__(
        self,
        path: Path,
        header: RunHeader,
        pieces: list[ChunkPlace],
        topics: Mapping[int, str] | None = None,
    ) -> None:
        self._path = path
        self._chunks = Chunks(path, pieces, topics)
        self._topics = Topics(header.layout).by_name
        self._same_version = (header.version, header.alphabet) == (__version__, ALPHABET_VERSION)

    def messages(self, place: int) -> list[Message]:
        """Return the messages of the piece with this number, in the order of writing."""
        try:
            entries = self._chunks.entries(place)
        except DamagedError as error:
            raise DamagedInsideError(self._path, str(error)) from None
        except OSError as error:
            raise unreadable(self._path, error) from None
        names = self._chunks.topics.names
        return [Message(names[number], time_ns, data) for number, time_ns, data in entries]

    def first_input(self, messages: Sequence[Message]) -> FirstInput | None:
        """Return the first input of a piece; None without inputs."""
        found = [
            FirstInput(number, at_s, message.time_ns)
            for message in messages
            for number, at_s, _, _ in self._rows([message], inputs=True)
        ]
        return FirstInput(*map(min, zip(*found, strict=True))) if found else None

    def effects(self, messages: Sequence[Message], origin_s: float) -> Iterator[StepEffects]:
        """Yield the effects of each step in order, with times since ``origin_s``."""
        rows = sorted(self._rows(messages, inputs=False), key=lambda row: (row[0], row[2]))
        for number, same_step in groupby(rows, key=lambda row: row[0]):
            found = list(same_step)
            yield StepEffects(number, found[0][1] - origin_s, tuple(row[3] for row in found))

    def states(self, messages: Sequence[Message]) -> Iterator[tuple[int, float, EngineState]]:
        """Yield number, time and state of each step with a recorded engine state.

        Only the version that recorded a state can use it, because another version may number its
        states differently.
        """
        if not self._same_version:
            return
        for name, _, data in messages:
            if name == STATE.name:
                for number, at_s, _, made in self._decoded(STATE, data):
                    with suppress(ValueError):
                        yield number, at_s, state_from_text(made.state)

    def steps(self, messages: Sequence[Message], first: int | None) -> list[RecordedStep]:
        """Return the steps of a piece.

        Args:
            messages: Messages of the piece.
            first: The required number of its first step; None: any.
        """
        inputs = {number: (at_s, made) for number, at_s, _, made in self._rows(messages, True)}
        effects: dict[int, list[tuple[int, Effect]]] = defaultdict(list)
        for number, _, nth, made in self._rows(messages, inputs=False):
            effects[number].append((nth, made))
        if first is None:
            first = min(inputs, default=0)
        if inputs.keys() != set(range(first, first + len(inputs))) or effects.keys() - inputs:
            raise DamagedInsideError(self._path, f"steps are missing after the first {first}")
        states = {number: state for number, _, state in self.states(messages)}
        try:
            steps = [_step(number, *inputs[number], effects[number]) for number in sorted(inputs)]
        except ValueError as error:
            raise DamagedInsideError(self._path, str(error)) from None
        return [step._replace(state=states.get(step.number)) for step in steps] if states else steps

    def _rows(
        self, messages: Sequence[Message], inputs: bool
    ) -> Iterator[tuple[int, float, int, Any]]:
        """Yield step, time, index and content of each row of the inputs, or of the effects."""
        for name, _, data in messages:
            topic = self._topics.get(name)
            if topic is not None and topic.is_input == inputs:
                yield from self._decoded(topic, data)

    def _decoded(self, topic: Topic, data: bytes) -> Iterator[tuple[int, float, int, Any]]:
        try:
            yield from topic.decode(data)
        except ValueError as error:
            raise DamagedInsideError(self._path, str(error)) from None


def _step(number: int, at_s: float, made: Any, effects: list[tuple[int, Effect]]) -> RecordedStep:
    given = tuple(effect for _, effect in sorted(effects, key=lambda each: each[0]))
    if isinstance(made, Started):
        body, resumed = body_from_text(made.body), resumption_from_text(made.resumed)
        return RecordedStep(number, at_s, None, given, "start", body, made.paused, resumed=resumed)
    if isinstance(made, Abandoned):
        return RecordedStep(number, at_s, None, given, "runtime")
    return RecordedStep(number, at_s, made, given, "engine")


def unreadable(path: Path, error: OSError) -> RecordingError:
    """Return the error for a file that cannot be read."""
    return RecordingError(f"{shown(path)} cannot be read: {error.strerror}")
