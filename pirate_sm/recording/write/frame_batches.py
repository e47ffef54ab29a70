"""Makes one message for each board of the frames that a run has noted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import Any, TypeAlias

from pirate_sm.recording.format.engine_topics import Topic, Topics
from pirate_sm.recording.write.gathered import NumberedFrames

Batch: TypeAlias = tuple[Topic, float, bytes]
"""The topic of a board, the time of the first frame in s, and the frames as JSON."""


def batches_of_frames(topics: Topics, frames: Mapping[int, Sequence[Any]]) -> Iterator[Batch]:
    """Yield a batch for each board that has frames.

    Args:
        topics: The topics of the robot.
        frames: See :class:`pirate_sm.recording.write.gathered.Gathered`.
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
