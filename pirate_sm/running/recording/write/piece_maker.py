"""Makes messages of what a run has noted, and pieces of the file of the messages."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import Any, NamedTuple, Protocol, TypeAlias

from pirate_sm.running.recording.format.engine_state_text import state_to_text
from pirate_sm.running.recording.format.engine_topics import (
    STATE,
    UNLOGGED,
    Remembered,
    Topic,
    Topics,
    Unlogged,
)
from pirate_sm.running.recording.write.gathered import Caused, Gathered, NumberedFrames, Told
from pirate_sm.running.recording.write.recording_file import RecordingFile

Batch: TypeAlias = tuple[Topic, float, bytes]
"""The topic of a board, the time of the first frame in s, and the frames as JSON."""


def batches_of_frames(topics: Topics, frames: Mapping[int, Sequence[Any]]) -> Iterator[Batch]:
    """Yield a batch for each board that has frames.

    Args:
        topics: The topics of the robot.
        frames: See :class:`pirate_sm.running.recording.write.gathered.Gathered`.
    """
    for board, flat in frames.items():
        if flat:
            topic = topics.of_frames(board)
            width = len(topic.names) + 2
            steps, times_s, *channels = (flat[column::width] for column in range(width))
            yield topic, times_s[0], topic.encode_frames(steps, times_s, channels)


def batches_of_blocks(topics: Topics, blocks: Sequence[NumberedFrames]) -> Iterator[Batch]:
    """Yield a batch for each board that has frames in these blocks.

    Args:
        topics: The topics of the robot.
        blocks: The blocks.
    """
    if not blocks:
        return
    import numpy as np  # noqa: PLC0415 - only a compiled simulator hands over blocks

    begin = blocks[0].first
    is_frame = np.zeros(blocks[-1].end - begin, np.bool_)  # of each step from the first one on
    for it in blocks:
        is_frame[it.first - begin : it.end - begin] = True
    others = np.fromiter(chain.from_iterable(it.others for it in blocks), np.int64)
    is_frame[others - begin] = False
    steps = is_frame.nonzero()[0] + begin
    times_s = np.fromiter(chain.from_iterable(it.frames.times_s for it in blocks), np.float64)
    boards = np.fromiter(chain.from_iterable(it.frames.boards for it in blocks), np.int64)
    values = np.concatenate([it.frames.values for it in blocks])
    for board in sorted(set(boards.tolist())):  # np.unique imports numpy.ma
        mine, topic = boards == board, topics.of_frames(board)
        at_s = times_s[mine].tolist()
        channels = values[mine, : len(topic.names)].T.tolist()
        yield topic, at_s[0], topic.encode_frames(steps[mine].tolist(), at_s, channels)


class WrittenPiece(NamedTuple):
    """Bytes to write at once.

    Attributes:
        until_s: Time of the last step in them; ``step`` is the number of the step after it.
    """

    data: bytes
    until_s: float | None
    step: int


class SideWriter(Protocol):
    """Writes what a recording holds beside the engine's topics."""

    def tell(self, file: RecordingFile, told: Sequence[Told]) -> None:
        """Add messages about these effects and samples to the file; never raise."""


class PieceMaker:
    """Turns what was gathered into messages, and messages into pieces of the file.

    Two threads must not use it at the same time.

    Args:
        file: Receives the messages.
        topics: Topics of the engine's inputs and effects.
        beside: Writes what the file holds beside these topics.

    Attributes:
        steps: Number of steps of the engine in the next piece.
    """

    def __init__(self, file: RecordingFile, topics: Topics, beside: SideWriter | None) -> None:
        self.steps = 0
        self._file = file
        self._topics = topics
        self._beside = beside
        self._until_s: float | None = None
        self._step = 0

    def take(self, gathered: Gathered) -> None:
        """Add what was gathered to the next piece, in one batch for each topic."""
        self.steps += gathered.steps
        self._until_s, self._step = gathered.until_s, gathered.step
        topics, rows = self._topics, defaultdict[Topic, list[tuple[Any, ...]]](list)
        for row in gathered.inputs:
            rows[topics.of_input(row[2])].append(row)
        for each in gathered.told:
            if isinstance(each, Caused):
                for place, effect in enumerate(each.effects):
                    rows[topics.of_effect(effect)].append((each.step, each.at_s, place, effect))
        self._take_notes(gathered, rows)
        for topic, some in rows.items():
            self._put(topic, some[0][1], topic.encode(some))
        for topic, at_s, data in batches_of_frames(topics, gathered.frames):
            self._put(topic, at_s, data)
        for topic, at_s, data in batches_of_blocks(topics, gathered.blocks):
            self._put(topic, at_s, data)
        if self._beside is not None:
            self._beside.tell(self._file, gathered.told)

    def cut(self) -> WrittenPiece:
        """Return everything since the last cut as bytes; empty if there is nothing."""
        self.steps = 0
        return WrittenPiece(self._file.cut(), self._until_s, self._step)

    def _take_notes(self, gathered: Gathered, rows: dict[Topic, list[tuple[Any, ...]]]) -> None:
        """Add the rows that are neither inputs nor effects."""
        for step, at_s, state in gathered.states:
            rows[STATE].append((step, at_s, Remembered(state_to_text(state))))
            self._file.mark()
        for step, at_s, waited_s in gathered.unlogged:
            rows[UNLOGGED].append((step, at_s, Unlogged(waited_s)))

    def _put(self, topic: Topic, at_s: float, data: bytes) -> None:
        self._file.add(topic.name, at_s, data, topic.schema_json, topic.schema_name)
