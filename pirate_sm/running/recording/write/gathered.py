"""Gathers what a run has noted until it is made into messages.

At full speed this is most of what a recording costs the run. So a frame of a board leaves no object
behind that Python's garbage collector would have to look at: its numbers are added to one list for
each board.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple, TypeAlias

from pirate_sm.core.effects import Effect
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import FrameBlock, SensorFrame
from pirate_sm.core.sensing import Glide
from pirate_sm.robot.detectors.vision_detector import CameraView
from pirate_sm.running.recording.format.engine_topics import Input
from pirate_sm.running.recording.format.samples import PlacesSample
from pirate_sm.running.recording.viewers.viewer_messages import ViewerSnapshot


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
    """Samples of steps that were taken at once.

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
    """Frames that were taken at once, with other steps among them.

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
        blocks: Frames that were taken at once.
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
        """Note steps that were taken at once; return the number of the next one."""
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
