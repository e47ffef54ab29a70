"""Reads recordings, including those that were cut short.

``read_recording(path).steps()`` yields every input of the engine in order, with its effects. Only
one piece of the file is in memory at a time, so a recording may be of any length. If it has
checkpoints (:meth:`Recording.checkpoint`), reading can begin in the middle.
"""

from __future__ import annotations

import json
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import datetime
from functools import cached_property
from hashlib import file_digest
from math import inf
from pathlib import Path
from typing import Any

from pirate_sm.core.effects import Ended
from pirate_sm.core.errors import RecordingError
from pirate_sm.core.library import shown
from pirate_sm.core.on_disk import opened
from pirate_sm.running.recording.format.engine_topics import ENGINE
from pirate_sm.running.recording.format.header import PROFILE, REPAIRED, RunHeader
from pirate_sm.running.recording.read.mcap_content import (
    Content,
    NotMcapError,
    newest_checkpoints,
    read_content,
)
from pirate_sm.running.recording.read.pieces import (
    Checkpoint,
    DamagedInsideError,
    FirstInput,
    Gap,
    Message,
    PieceReader,
    RecordedStep,
    StepEffects,
    ViewerMessage,
    read_header,
    unreadable,
    with_own_times,
)

NS_PER_S = 1_000_000_000

_NO_INDEX = (
    "all that was recorded is there, but the index at the end of the file, which other programs "
    "look for, is missing or damaged: pirate repair restores it"
)


def _no_progress(share: float) -> None:
    """Do nothing with the progress."""


def _no_more() -> bool:
    """Return that nothing more comes."""
    return False


@dataclass(frozen=True)
class Recording:
    """A recording whose header has been read.

    Methods that read more of the file raise a ``RecordingError`` if it cannot be read or is
    damaged.

    Attributes:
        path: Path of the file.
        header: The set-up of the run, with every text that it was made from.
        content: The places of everything in the file.
        watch: Receives the share of the recording that has been read, from 0 to 1.
        more: Is called when all pieces have been read; returns whether there are more by now.
    """

    path: Path
    header: RunHeader
    content: Content = field(repr=False)
    watch: Callable[[float], None] = field(default=_no_progress, repr=False)
    more: Callable[[], bool] = field(default=_no_more, repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        # Another process reads the file itself: what this one has read stays here.
        return Recording, (self.path, self.header, self.content, self.watch)

    @property
    def complete(self) -> bool:
        """Whether the run itself wrote the recording to its end."""
        return self.content.complete and REPAIRED not in self.content.metadata

    @property
    def repaired(self) -> Mapping[str, str]:
        """Return what a repair has noted; empty without one that has left something out."""
        return self.content.metadata.get(REPAIRED, {})

    @property
    def lost(self) -> str:
        """Return the damage for which a repair has left something out; empty if there was none."""
        return self.repaired.get("damage", "")

    @property
    def lost_end(self) -> bool:
        """Whether a repair has left out damaged steps that no others follow."""
        return self.repaired.get("end") == "damaged"

    @cached_property
    def gaps(self) -> tuple[Gap, ...]:
        """Return where a repair has left out damaged steps that others follow, in order."""
        try:
            found = json.loads(self.repaired.get("gaps", "[]"))
            return tuple(Gap(int(step), float(one), float(other)) for step, one, other in found)
        except (ValueError, TypeError):
            return ()

    @cached_property
    def notices(self) -> tuple[str, ...]:
        """Return notices about a recording that is incomplete or has no index."""
        if self.complete:
            return () if self.content.indexed else (_NO_INDEX,)
        found, at = [_gap_notice(gap) for gap in self.gaps], f"at {self.until_s:.3f} s"
        if not self.until_s:
            found.append("the recording ends early, as the run began")
        elif not self._ended:
            found.append(f"the recording ends early, {at}: nothing after that is in it")
        elif not self.gaps:
            found.append(f"the end of the file is lost, but the run had ended, {at}")
        return tuple(found)

    @cached_property
    def origin_s(self) -> float:
        """Return when the run began by the engine's clock; 0 for an empty recording.

        All times of a recording except those of its steps count from then.
        """
        first = self._first_input
        if first is None or not first.number:
            return first.at_s if first else 0.0
        return round(first.at_s - self._time_s(first.time_ns), 9)

    @cached_property
    def _first_input(self) -> FirstInput | None:
        """Return the first input in a whole piece; its number is not 0 if those before are lost."""
        for place in range(len(self.content.pieces)):
            with suppress(DamagedInsideError):
                if first := self._reader.first_input(self._reader.messages(place)):
                    return first
        return None

    @cached_property
    def until_s(self) -> float:
        """Return the time of the last step, s; 0 without steps."""
        return self._last_steps[-1].at_s - self.origin_s if self._last_steps else 0.0

    @property
    def last_step(self) -> RecordedStep:
        """Return the last step.

        Raises:
            RecordingError: There is none.
        """
        if not self._last_steps:
            raise RecordingError(f"{shown(self.path)} holds no step")
        return self._last_steps[-1]

    @cached_property
    def _ended(self) -> bool:
        """Whether the recording contains the end of the run."""
        last = (effect for step in self._last_steps for effect in step.effects)
        return any(isinstance(effect, Ended) for effect in last)

    @cached_property
    def _last_steps(self) -> list[RecordedStep]:
        """Return the steps of the last piece that has any."""
        pieces = reversed(range(len(self.content.pieces)))
        found = (self._reader.steps(self._reader.messages(place), None) for place in pieces)
        return next(filter(None, found), [])

    @cached_property
    def sha256(self) -> str:
        """Return the hash of the file, hexadecimal."""
        try:
            with opened(self.path) as file:
                return file_digest(file, "sha256").hexdigest()
        except OSError as error:
            raise unreadable(self.path, error) from None

    @cached_property
    def starts_s(self) -> list[float]:
        """Return when each piece of the file begins, s since the run began."""
        return [self._time_s(piece.start_ns) for piece in self.content.pieces]

    def checkpoint(self, at_s: float) -> Checkpoint | None:
        """Return the last usable checkpoint up to this time; None if there is none.

        Only the version that recorded a checkpoint can use it, because another version may number
        its states differently.
        """
        for place in reversed(range(bisect_right(self.starts_s, at_s))):
            found = [each for each in self._checkpoints(place) if each.at_s <= at_s]
            if found:
                return found[-1]
        return None

    def checkpoints(self, after: Checkpoint | None = None) -> Iterator[Checkpoint]:
        """Yield every usable checkpoint, in order.

        Args:
            after: Only later checkpoints than this one; None: all.
        """
        for place in range(after.place if after else 0, len(self.content.pieces)):
            for each in self._checkpoints(place):
                if after is None or each.step > after.step:
                    yield each

    def steps(self, after: Checkpoint | None = None) -> Iterator[RecordedStep]:
        """Yield every input of the engine, in order, with its effects.

        Args:
            after: Where to begin; None: at the beginning.
        """
        started = after is not None
        for rows in self.commits(after):
            for step in rows:
                started = started or step.by == "start" or step.state is not None
                yield step if started or step.by != "engine" else step._replace(by="seen")

    def commits(self, after: Checkpoint | None = None) -> Iterator[list[RecordedStep]]:
        """Yield the steps of each piece; inputs before the start count as steps of the engine.

        Args:
            after: Where to begin; None: at the beginning.
        """
        first, number = (after.place, after.step + 1) if after is not None else (0, 0)
        for place, messages in self._pieces(first):
            expected = number if place > first or after is None else None
            if self.gaps and expected is not None:
                begins = self._reader.first_input(messages)
                if begins and any(each.step == begins.number for each in self.gaps):
                    expected = number = max(begins.number, number)
            rows = self._reader.steps(messages, expected)
            steps = [step for step in rows if step.number >= number]
            number += len(steps)
            yield steps

    def steps_in(self, place: int) -> list[RecordedStep]:
        """Return the steps of the piece with this number, whatever is before it."""
        return self._reader.steps(self._reader.messages(place), None)

    def effects(self) -> Iterator[StepEffects]:
        """Yield the effects of all steps, in order; this is faster than reading the steps."""
        for _, messages in self._pieces(0):
            for each in self._reader.effects(messages, self.origin_s):
                yield each._replace(effects=with_own_times(each.effects, self.origin_s))

    def shown(self, *topics: str, since_s: float = -inf) -> Iterator[ViewerMessage]:
        """Yield messages other than the engine's: of these topics, or all for viewers, in order.

        Args:
            topics: Their names.
            since_s: Messages before this time may be left out.
        """
        for topic, time_ns, data in self.messages(*topics, since_s=since_s):
            yield ViewerMessage(topic, self._time_s(time_ns), json.loads(data))

    def messages(self, *topics: str, since_s: float = -inf) -> Iterator[Message]:
        """Yield messages as they were written; arguments as for :meth:`shown`."""
        for _, messages in self._pieces(max(bisect_right(self.starts_s, since_s) - 2, 0)):
            for message in messages:
                topic = message.topic
                if topic in topics if topics else not topic.startswith(ENGINE):
                    yield message

    @cached_property
    def _reader(self) -> PieceReader:
        content = self.content
        return PieceReader(self.path, self.header, content.pieces, content.topics)

    @cached_property
    def _zero_ns(self) -> int:
        """Return the time at which the run began, ns since 1970.

        In old recordings, messages of later runs of a session counted from the session's first run.
        So the header's time is used only if the file has no piece, or its first steps are lost.
        """
        first = self._first_input
        if self.content.pieces and not (first and first.number):
            return self.content.pieces[0].start_ns
        return round(datetime.fromisoformat(self.header.began).timestamp() * NS_PER_S)

    def _time_s(self, time_ns: int) -> float:
        return (time_ns - self._zero_ns) / NS_PER_S

    def _checkpoints(self, place: int) -> Iterator[Checkpoint]:
        """Yield the checkpoints in a piece that this version of the engine can use."""
        for step, at_s, state in self._reader.states(self._reader.messages(place)):
            yield Checkpoint(step, at_s - self.origin_s, state, place)

    def _pieces(self, first: int) -> Iterator[tuple[int, list[Message]]]:
        """Yield number and messages of each piece, which contains whole steps."""
        place = first
        while place < len(self.content.pieces) or self.more():
            self.watch(self.content.pieces[place].at / self.content.size)
            yield place, self._reader.messages(place)
            place += 1
        self.watch(1.0)


def _gap_notice(gap: Gap) -> str:
    return (
        f"nothing is known from {gap.from_s:.3f} s to {gap.until_s:.3f} s, where the recording was "
        "damaged; after that odometry, speed and slip are unknown, up to the next checkpoint"
    )


def read_end_of_recording(path: Path) -> Recording:
    """Return the recording with its first piece, and its last ones from the last checkpoint on.

    So the end of a long recording is read without the rest. A recording without a checkpoint that
    this version can use is whole.

    Raises:
        RecordingError: As for :func:`read_recording`.
    """
    try:
        with opened(path) as file:
            for since in newest_checkpoints(file):
                found = _recording(path, read_content(file, since), _no_progress)
                if found.checkpoint(inf) is not None:
                    return found
    except (NotMcapError, OSError, RecordingError):
        pass  # the reading of the whole file says what is wrong
    return read_recording(path)


def read_recording(
    path: Path, watch: Callable[[float], None] = _no_progress, *, damaged: bool = False
) -> Recording:
    """Return the recording in this file, up to where it is cut off.

    Args:
        path: The file.
        watch: Receives the share that has been read, whenever the file is read.
        damaged: Whether to accept a damaged recording, which then ends where the damage begins.

    Raises:
        RecordingError: There is no such file, it is not a recording, or its header is damaged.
    """
    try:
        with opened(path) as file:
            content = read_content(file)
    except NotMcapError:
        raise RecordingError(f"{shown(path)} is not a recording: it is not an MCAP file") from None
    except OSError as error:
        raise unreadable(path, error) from None
    except ValueError:
        raise RecordingError(f"there is no file '{shown(path)}'") from None
    return _recording(path, content, watch, damaged=damaged)


def _recording(
    path: Path, content: Content, watch: Callable[[float], None], *, damaged: bool = False
) -> Recording:
    if content.profile not in (PROFILE, None):
        raise RecordingError(f"{shown(path)} is an MCAP file, but not a recording of a mission")
    recording = Recording(path, read_header(path, content), content, watch)
    if content.damage and not damaged:
        raise DamagedInsideError(path, content.damage)
    return recording
