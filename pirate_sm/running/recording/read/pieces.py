"""The records in a recording, read piece by piece: header, steps of the engine, checkpoints."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from hashlib import sha256
from itertools import groupby
from pathlib import Path
from typing import Any, Literal, NamedTuple

from mcap.records import Attachment

from pirate_sm import __version__
from pirate_sm.core.effects import Effect, WaitArmed
from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import RecordingError
from pirate_sm.core.events import ALPHABET_VERSION, READABLE_ALPHABETS, Event
from pirate_sm.core.library import shown
from pirate_sm.core.resuming import Resumption
from pirate_sm.core.robot import RobotState
from pirate_sm.running.recording.format.engine_topics import (
    STATE,
    Abandoned,
    Started,
    Topic,
    Topics,
)
from pirate_sm.running.recording.format.header import (
    FORMAT,
    READABLE_FORMATS,
    RUN,
    RunHeader,
    header_from_json,
)
from pirate_sm.running.recording.format.json_values import (
    body_from_text,
    resumption_from_text,
    state_from_text,
)
from pirate_sm.running.recording.read.mcap_content import ChunkPlace, Chunks, Content, DamagedError

# --- the header -----------------------------------------------------------------------------------


def read_header(path: Path, content: Content) -> RunHeader:
    """Return the header of the recording, with every text.

    Raises:
        RecordingError: The header is damaged, missing or of another version.
    """
    attached = content.attachments
    if RUN not in attached:
        raise _lacking(path, content, f"{RUN} is missing")
    data = attached[RUN].data
    _check_versions(path, data)
    try:
        header = header_from_json(data, _texts(attached))
    except KeyError:
        raise _lacking(path, content, "a text that the run was made from is missing") from None
    except ValueError:
        raise damaged(path, f"{RUN} has unexpected content") from None
    for file in header.files:
        if sha256(file.text.encode()).hexdigest() != file.sha256:
            raise damaged(path, f"{file.name} is not the text that was run")
    return header


def _lacking(path: Path, content: Content, what: str) -> RecordingError:
    """Return the error for a part of the header that is not there: damaged, or not yet written."""
    if content.damage:
        return damaged(path, content.damage)
    if content.complete or content.pieces:
        return damaged(path, what)
    return RecordingError(f"{shown(path)} was interrupted before anything was recorded")


def _texts(attached: dict[str, Attachment]) -> dict[str, str]:
    return {name: each.data.decode(errors="replace") for name, each in attached.items()}


def _check_versions(path: Path, data: bytes) -> None:
    try:
        plain = json.loads(data)
        found = plain["format"], plain["alphabet"]
        version = str(plain["version"])
    except (ValueError, KeyError, TypeError):
        raise damaged(path, f"{RUN} has unexpected content") from None
    if found[0] not in READABLE_FORMATS or found[1] not in READABLE_ALPHABETS:
        raise RecordingError(
            f"{shown(path)} was recorded by version {version} "
            f"(format {found[0]}, alphabet {found[1]}), "
            f"which this version cannot read (format {FORMAT}, alphabet {ALPHABET_VERSION})"
        )


def damaged(path: Path, how: str) -> RecordingError:
    """Return the error for a damaged recording."""
    return RecordingError(f"{shown(path)} is damaged: {how}")


def unreadable(path: Path, error: OSError) -> RecordingError:
    """Return the error for a file that cannot be read."""
    return RecordingError(f"{shown(path)} cannot be read: {error.strerror}")


class DamagedInsideError(RecordingError):
    """Is raised if the beginning of a recording is usable, but not all that follows.

    Attributes:
        how: Description of the damage.
    """

    def __init__(self, path: Path, how: str) -> None:
        super().__init__(f"{shown(path)} is damaged: {how}; pirate repair saves what is whole")
        self.how = how


# --- records --------------------------------------------------------------------------------------


class RecordedStep(NamedTuple):
    """An input of the engine and its effects.

    Attributes:
        number: Its number in the recording, from 0.
        at_s: Its time by the engine's clock. The runs of a console's session share that clock: see
            :attr:`Recording.origin_s`.
        event: The input; None for the start and for actions past the engine.
        effects: The engine's effects; those of the program around it for actions past the engine.
        by: ``seen``: known to the engine before its start. ``start``: the start itself.
            ``engine``: a step of the engine. ``runtime``: an action past the engine.
        body: For a start: the robot state after an earlier mission.
        paused: For a start: whether the operator controlled the robot first.
        state: The engine's state after it, if it was recorded.
        resumed: For a start: with what a mission went on whose run was cut off.
    """

    number: int
    at_s: float
    event: Event | None
    effects: tuple[Effect, ...]
    by: Literal["seen", "start", "engine", "runtime"]
    body: RobotState | None = None
    paused: bool = False
    state: EngineState | None = None
    resumed: Resumption | None = None


class Gap(NamedTuple):
    """Steps in the middle of a repaired recording that were damaged, so that they are not in it.

    Attributes:
        step: Number of the first step after it.
        from_s: Time of the last step before it, since the run began; 0 if it is at the start.
        until_s: Time of the first step after it.
    """

    step: int
    from_s: float
    until_s: float


class StepEffects(NamedTuple):
    """The effects of the step with this number; ``at_s`` is the time since the run began."""

    number: int
    at_s: float
    effects: tuple[Effect, ...]


class Message(NamedTuple):
    """A message and its topic; ``time_ns`` is its time, ns since 1970."""

    topic: str
    time_ns: int
    data: bytes


class ViewerMessage(NamedTuple):
    """A message for viewers."""

    topic: str
    at_s: float
    content: dict[str, Any]


class Checkpoint(NamedTuple):
    """The engine's state in the middle of a run, from which a replay can begin.

    Attributes:
        step: The last step before this state.
        at_s: Time since the run began.
        state: The engine's state.
        place: Number of the piece of the file that contains it.
    """

    step: int
    at_s: float
    state: EngineState
    place: int = 0


def with_own_times(effects: tuple[Effect, ...], origin_s: float) -> tuple[Effect, ...]:
    """Return the effects with deadlines that count from the origin of a recording."""
    return tuple(
        it._replace(deadline_s=it.deadline_s - origin_s) if isinstance(it, WaitArmed) else it
        for it in effects
    )


# --- pieces ---------------------------------------------------------------------------------------


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
