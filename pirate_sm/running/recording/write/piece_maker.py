"""Collects the events of a run, and turns them into messages and pieces of the file.

At full speed gathering is most of what a recording costs the run. So a frame of a board leaves no
object behind that Python's garbage collector would have to look at: its numbers are added to one
list for each board.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain
from typing import Any, NamedTuple, Protocol, TypeAlias

from pirate_sm.core.effects import Effect
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import FrameBlock, SensorFrame
from pirate_sm.core.sensing import Glide
from pirate_sm.robot.detectors.vision_detector import CameraView
from pirate_sm.running.recording.format.engine_topics import (
    STATE,
    UNLOGGED,
    Input,
    PlacesSample,
    Remembered,
    Topic,
    Topics,
    Unlogged,
)
from pirate_sm.running.recording.format.json_values import state_to_text
from pirate_sm.running.recording.viewers.viewer_messages import ViewerSnapshot
from pirate_sm.running.recording.write.recording_file import RecordingFile

# --- notes ----------------------------------------------------------------------------------------


class Caused(NamedTuple):
    """The effects of one step."""

    step: int
    at_s: float
    effects: Sequence[Effect]


class Sample(NamedTuple):
    """The state of a run at one time."""

    at_s: float
    snapshot: ViewerSnapshot


class PlacesOfTrail(NamedTuple):
    """Samples of steps that were taken together.

    Attributes:
        times_s: Their times, s.
        noted: Where the robot was, as the trail has noted it.
        samples: Makes samples of this and of others like it.
    """

    times_s: Sequence[float]
    noted: bytes
    samples: Callable[[Sequence[PlacesOfTrail]], Iterator[PlacesSample]]


class Pictured(NamedTuple):
    """A sample of a run that a camera watches."""

    sample: PlacesSample
    camera: CameraView


class NumberedFrames(NamedTuple):
    """Frames that were taken together, with other steps among them.

    Attributes:
        first: Number of the first step.
        frames: The frames.
        others: Numbers of the steps among them that are not frames.
    """

    first: int
    frames: FrameBlock
    others: Sequence[int]

    @property
    def end(self) -> int:
        """Return the number of the step after the last one."""
        return self.first + len(self.frames) + len(self.others)


Told: TypeAlias = Caused | Sample | PlacesSample | PlacesOfTrail | Pictured


class Gathered:
    """What a run has noted, step by step.

    Args:
        first: Number of the first step.
        channels: Number of channels of each board, by its id.

    Attributes:
        step: Number of the next step.
        frames: For each board the frames that fit it, one after the other in one list: number of
            the step, time in s, then a value for each channel.
        blocks: Frames that were taken together.
        inputs: All other inputs, each with its step and its time in s.
        told: The effects of steps and the samples of the run, in their order.
        states: States of the engine, each with the step before it and its time in s.
        unlogged: Steps whose command was submitted before they were on the disk: each with its
            time and how long the run had waited, s.
        until_s: Time of the last step, s; None before the first step of the run.
    """

    __slots__ = (
        *("step", "frames", "blocks", "inputs", "told", "states", "unlogged", "until_s"),
        *("_first", "_channels"),
    )

    def __init__(
        self, first: int, channels: Mapping[int, int], until_s: float | None = None
    ) -> None:
        self.step = self._first = first
        self.frames: dict[int, list[float]] = {board: [] for board in channels}
        self.blocks: list[NumberedFrames] = []
        self.inputs: list[tuple[int, float, Input]] = []
        self.told: list[Told] = []
        self.states: list[tuple[int, float, EngineState]] = []
        self.unlogged: list[tuple[int, float, float]] = []
        self.until_s = until_s
        self._channels = channels

    @property
    def steps(self) -> int:
        """Number of steps that were noted."""
        return self.step - self._first

    def next(self) -> Gathered:
        """Return an empty one for the steps that follow."""
        return Gathered(self.step, self._channels, self.until_s)

    def add(self, event: Input, at_s: float, effects: Sequence[Effect]) -> int:
        """Note a step; return the number of the next one."""
        step = self.step
        self.until_s = at_s
        if type(event) is SensorFrame and self._channels.get(event[0]) == len(event[1]):
            self.frames[event[0]] += (step, at_s, *event[1])
        else:
            self.inputs.append((step, at_s, event))
        if effects:
            self.told.append(Caused(step, at_s, effects))
        self.step = step = step + 1
        return step

    def add_glide(self, glide: Glide) -> int:
        """Note steps that were taken together; return the number of the next one."""
        first, times_s, others = self.step, glide.frames.times_s, list[int]()
        for at_s, event, effects in glide.steps:
            step = first + bisect_right(times_s, at_s) + len(others)
            if type(event) is SensorFrame:  # one of the frames
                step -= 1
            else:
                self.inputs.append((step, at_s, event))
                others.append(step)
            if effects:
                self.told.append(Caused(step, at_s, effects))
            self.until_s = at_s
        if times_s:
            self.blocks.append(NumberedFrames(first, glide.frames, others))
            self.until_s = max(times_s[-1], self.until_s or 0.0)
        self.step = first + len(times_s) + len(others)
        return self.step

    def remember(self, at_s: float, state: EngineState) -> None:
        """Note the engine's state after the last step."""
        self.states.append((self.step - 1, at_s, state))


# --- pieces ---------------------------------------------------------------------------------------


Batch: TypeAlias = tuple[Topic, float, bytes]
"""The topic of a board, the time of the first frame in s, and the frames as JSON."""


def batches_of_frames(topics: Topics, frames: Mapping[int, Sequence[Any]]) -> Iterator[Batch]:
    """Yield a batch for each board that has frames.

    Args:
        topics: The topics of the robot.
        frames: See :class:`Gathered`.
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
    """Writes what a recording holds in addition to the engine's topics."""

    def tell(self, file: RecordingFile, told: Sequence[Told]) -> None:
        """Add messages about these effects and samples to the file; never raise."""


class PieceMaker:
    """Turns what was gathered into messages, and messages into pieces of the file.

    Two threads must not use it at the same time.

    Args:
        file: Receives the messages.
        topics: Topics of the engine's inputs and effects.
        beside: Writes what the file holds in addition to these topics.

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
