"""Recordings are read again, also those of runs that were cut short.

``read_recording(path).steps()`` gives everything that the engine was given, in order, and what came
of it.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from hashlib import sha256
from pathlib import Path
from typing import Any, Final, Literal, NamedTuple

from mcap.records import Attachment, Chunk, Message

from pirate_sm.engine.robot_state import RobotState
from pirate_sm.errors import RecordingError
from pirate_sm.loading.folders import shown
from pirate_sm.model.effects import Effect
from pirate_sm.model.events import ALPHABET_VERSION, Event
from pirate_sm.recording.alphabet import IN, OUT, Abandoned, Started, Topic, Topics
from pirate_sm.recording.bodies import body_from_text
from pirate_sm.recording.header import FORMAT, PROFILE, RUN, RunHeader, header_from_json
from pirate_sm.recording.mcap_records import (
    Content,
    DamagedError,
    NotMcapError,
    messages_of,
    read_content,
)

LARGEST_FILE: Final = 1 << 30

_CUT_SHORT = "the recording ends early: what came in the last half second of the run may be missing"


class Step(NamedTuple):
    """Something that the engine was given, and what it gave back.

    Attributes:
        number: Its place in the recording, from 0.
        at_s: Time since the run began.
        event: What the engine was given; None for its start and where it was not asked.
        effects: What it gave back; those of the program around it where it was not asked.
        by: ``seen``: shown to the engine at its start, which comes after it. ``start``: the start
            itself. ``engine``: a step of it. ``runtime``: the engine was given up.
        body: Of a start: what an earlier mission had commanded the robot to.
        paused: Of a start: whether the operator had the robot first.
    """

    number: int
    at_s: float
    event: Event | None
    effects: tuple[Effect, ...]
    by: Literal["seen", "start", "engine", "runtime"]
    body: RobotState | None = None
    paused: bool = False


class Shown(NamedTuple):
    """A message that was made for viewers."""

    topic: str
    at_s: float
    content: dict[str, Any]


@dataclass(frozen=True)
class Recording:
    """A recording that has been looked through.

    Attributes:
        path: Of its file.
        header: What was run, with every text that it was made from.
        complete: Whether it was written to its end.
        notices: What a person should know although it can be read.
    """

    path: Path
    header: RunHeader
    complete: bool
    notices: tuple[str, ...]
    _chunks: tuple[Chunk, ...] = field(repr=False)

    def steps(self) -> Iterator[Step]:
        """Everything that the engine was given, in order, and what came of it.

        Raises:
            RecordingError: It is damaged.
        """
        topics = Topics(self.header.layout).by_name
        number, started = 0, False
        for messages in self._commits():
            rows = self._rows(messages, topics, number)
            number += len(rows)
            for step in rows:
                started = started or step.by == "start"
                yield step if started or step.by != "engine" else step._replace(by="seen")

    def shown(self, *topics: str) -> Iterator[Shown]:
        """What was made for viewers, in order: of these topics, or of all.

        Raises:
            RecordingError: It is damaged.
        """
        zero_ns = datetime.fromisoformat(self.header.began).timestamp() * 1e9
        for messages in self._commits():
            for topic, message in messages:
                if topic in topics if topics else not topic.startswith((IN, OUT)):
                    at_s = (message.log_time - round(zero_ns)) / 1e9
                    yield Shown(topic, at_s, json.loads(message.data))

    def _commits(self) -> Iterator[Sequence[tuple[str, Message]]]:
        """The messages of each commit, which holds whole steps."""
        topics: dict[int, str] = {}
        for chunk in self._chunks:
            try:
                yield messages_of(chunk, topics)
            except DamagedError as error:
                raise _damaged(self.path, str(error)) from None

    def _rows(
        self, messages: Sequence[tuple[str, Message]], topics: dict[str, Topic], first: int
    ) -> list[Step]:
        inputs: dict[int, tuple[float, Any]] = {}
        effects: dict[int, list[tuple[int, Effect]]] = defaultdict(list)
        for name, message in messages:
            topic = topics.get(name)
            if topic is None:
                continue
            try:
                for number, at_s, place, made in topic.decode(message.data):
                    if topic.is_input:
                        inputs[number] = (at_s, made)
                    else:
                        effects[number].append((place, made))
            except ValueError as error:
                raise _damaged(self.path, str(error)) from None
        if inputs.keys() != set(range(first, first + len(inputs))) or effects.keys() - inputs:
            raise _damaged(self.path, f"steps are missing after the first {first}")
        try:
            return [_step(number, *inputs[number], effects[number]) for number in sorted(inputs)]
        except ValueError as error:
            raise _damaged(self.path, str(error)) from None


def _step(number: int, at_s: float, made: Any, effects: list[tuple[int, Effect]]) -> Step:
    given = tuple(effect for _, effect in sorted(effects, key=lambda each: each[0]))
    if isinstance(made, Started):
        return Step(number, at_s, None, given, "start", body_from_text(made.body), made.paused)
    if isinstance(made, Abandoned):
        return Step(number, at_s, None, given, "runtime")
    return Step(number, at_s, made, given, "engine")


def read_recording(path: Path) -> Recording:
    """The recording in this file, as far as it goes.

    Raises:
        RecordingError: There is none, it is something else, or it is damaged.
    """
    try:
        content = read_content(_bytes(path))
    except NotMcapError:
        raise RecordingError(f"{shown(path)} is not a recording: it is not an MCAP file") from None
    except DamagedError as error:
        raise _damaged(path, str(error)) from None
    if content.profile not in (PROFILE, None):
        raise RecordingError(f"{shown(path)} is an MCAP file, but not a recording of a mission")
    header = _header(path, content)
    notices = () if content.complete else (_CUT_SHORT,)
    return Recording(path, header, content.complete, notices, content.chunks)


def _bytes(path: Path) -> bytes:
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise RecordingError(f"{shown(path)} is larger than any recording")
        return path.read_bytes()
    except OSError as error:
        raise RecordingError(f"{shown(path)} cannot be read: {error.strerror}") from None
    except ValueError:
        raise RecordingError(f"there is no file '{shown(path)}'") from None


def _header(path: Path, content: Content) -> RunHeader:
    attached = content.attachments
    if RUN not in attached:
        if content.complete:
            raise _damaged(path, f"{RUN} is missing")
        raise RecordingError(f"{shown(path)} was cut off before anything was recorded")
    data = attached[RUN].data
    _check_versions(path, data)
    try:
        header = header_from_json(data, _texts(attached))
    except KeyError:
        if content.complete or content.chunks:
            raise _damaged(path, "a text that the run was made from is missing") from None
        raise RecordingError(f"{shown(path)} was cut off before anything was recorded") from None
    except ValueError:
        raise _damaged(path, f"{RUN} does not say what it should") from None
    for file in header.files:
        if sha256(file.text.encode()).hexdigest() != file.sha256:
            raise _damaged(path, f"{file.name} is not the text that was run")
    return header


def _texts(attached: dict[str, Attachment]) -> dict[str, str]:
    return {name: each.data.decode(errors="replace") for name, each in attached.items()}


def _check_versions(path: Path, data: bytes) -> None:
    try:
        plain = json.loads(data)
        found = plain["format"], plain["alphabet"]
        version = str(plain["version"])
    except (ValueError, KeyError, TypeError):
        raise _damaged(path, f"{RUN} does not say what it should") from None
    if found != (FORMAT, ALPHABET_VERSION):
        raise RecordingError(
            f"{shown(path)} was recorded by version {version} "
            f"(format {found[0]}, alphabet {found[1]}), "
            f"which this version cannot read (format {FORMAT}, alphabet {ALPHABET_VERSION})"
        )


def _damaged(path: Path, how: str) -> RecordingError:
    return RecordingError(f"{shown(path)} is damaged: {how}")
