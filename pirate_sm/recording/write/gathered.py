"""Gathers what a run has noted until it is made into messages.

At full speed this is most of what a recording costs the run. So a frame of a board leaves no object
behind that Python's garbage collector would have to look at: its numbers are added to one list for
each board.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

from pirate_sm.detectors.vision_detector import CameraView
from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import Effect
from pirate_sm.model.events import SensorFrame
from pirate_sm.model.frame_block import FrameBlock
from pirate_sm.recording.format.engine_topics import Input
from pirate_sm.recording.format.samples import PlacesSample
from pirate_sm.recording.viewers.viewer_messages import ViewerSnapshot


class Caused(NamedTuple):
    """The effects of one step."""

    step: int
    at_s: float
    effects: Sequence[Effect]


class Sample(NamedTuple):
    """The state of a run at one time."""

    at_s: float
    snapshot: ViewerSnapshot


class Pictured(NamedTuple):
    """A sample of a run that a camera watches."""

    sample: PlacesSample
    camera: CameraView


Told: TypeAlias = Caused | Sample | PlacesSample | Pictured


class Gathered:
    """What a run has noted, step by step.

    Args:
        first: Number of the first step.
        channels: Number of channels of each board, by its id.

    Attributes:
        step: Number of the next step.
        frames: For each board the frames that fit it, one after the other in one list: number of
            the step, time in s, then a value for each channel.
        blocks: Blocks of frames, each with the number of its first step.
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
        self.blocks: list[tuple[int, FrameBlock]] = []
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

    def add_block(self, block: FrameBlock) -> int:
        """Note the steps of a block; return the number of the next one."""
        self.blocks.append((self.step, block))
        self.step += len(block)
        self.until_s = block.times_s[-1]
        return self.step

    def remember(self, at_s: float, state: EngineState) -> None:
        """Note the engine's state after the last step."""
        self.states.append((self.step - 1, at_s, state))
