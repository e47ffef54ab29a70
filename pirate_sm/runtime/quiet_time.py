"""Lets a backend take frames for the engine, and look for a detector, while nothing happens."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

from pirate_sm.backends.protocol import Gliding
from pirate_sm.companion import Companion, Relieved
from pirate_sm.model.events import SensorFrame
from pirate_sm.model.frame_block import FrameBlock
from pirate_sm.model.trail import Trail

if TYPE_CHECKING:
    from pirate_sm.backends.protocol import Backend
    from pirate_sm.engine.engine import Engine
    from pirate_sm.engine.gliding.glided import Glide, Step
    from pirate_sm.engine.state import EngineState
    from pirate_sm.model.word_watch import WordWatch


@runtime_checkable
class BlockTap(Protocol):
    """A tap that can receive many steps of the engine at once.

    Attributes:
        stepwise: Whether it looks at the run after each step, so that it cannot use blocks.
        due_s: When it looks at the engine next; the step that reaches this time is given to it
            alone.
    """

    stepwise: bool

    @property
    def due_s(self) -> float:
        """Return when it looks at the engine next."""

    def take_trail(self, trail: Trail) -> None:
        """Receive where the robot was at the steps that follow, which were taken at once."""

    def take_block(self, block: FrameBlock) -> None:
        """Receive steps without effects, all at once."""


def block_tap(tap: object) -> BlockTap | None:
    """Return the tap if it can use blocks."""
    return tap if isinstance(tap, BlockTap) and not tap.stepwise else None


class Part(NamedTuple):
    """A part of a glide: frames, and the other step after them.

    Attributes:
        frames: The frames, often none.
        step: What happened then; None after the last frames.
    """

    frames: FrameBlock
    step: Step | None


def parts_of(glide: Glide) -> Iterator[Part]:
    """Yield the frames and other steps of a glide in the order of time.

    A step of a frame takes the place of this frame.
    """
    frames, begin = glide.frames, 0
    for step in glide.steps:
        end = bisect_right(frames.times_s, step[0])
        own = 1 if isinstance(step[1], SensorFrame) else 0
        yield Part(_between(frames, begin, end - own), step)
        begin = end
    yield Part(_between(frames, begin, len(frames)), None)


def _between(block: FrameBlock, begin: int, end: int) -> FrameBlock:
    if end - begin == len(block):
        return block
    values: Any = block.values
    return FrameBlock(
        block.times_s[begin:end], block.boards[begin:end], values[begin:end], block.widths
    )


class QuietTime:
    """Lets time run without the engine, as long as nothing but signals changes.

    Args:
        engine: The engine.
        backend: The backend.
        companions: The companions. One whose looks others can make is relieved of them; time stays
            below the next call of the others.
    """

    def __init__(self, engine: Engine, backend: Backend, companions: Sequence[Companion]) -> None:
        self._engine = engine
        self._backend = backend if isinstance(backend, Gliding) else None
        relieved = [each for each in companions if isinstance(each, Relieved)]
        self._relieved = relieved[0] if len(relieved) == 1 else None
        self._companions = tuple(companions)

    def run(self, state: EngineState, until_s: float) -> Glide | None:
        """Let time run.

        Args:
            state: The engine's state.
            until_s: Mission time that is not reached.

        Returns:
            What has passed, with the companion relieved of its looks; None if nothing has.
        """
        backend = self._backend
        watch = self._engine.watch(state) if backend is not None else None
        if backend is None or watch is None:
            return None
        words = self._words(backend, state)
        for companion in self._companions:
            if words is None or companion is not self._relieved:
                until_s = min(until_s, companion.due_s)
        passed = backend.glide(watch, until_s, words)
        if passed is not None and words is not None and self._relieved is not None:
            self._relieved.relieve(passed.looks, passed.due_s, passed.said_s)
        return passed

    def _words(self, backend: Gliding, state: EngineState) -> WordWatch | None:
        """Return what the relieved detector knows; None if the backend cannot look for it."""
        words = self._relieved.word_watch(state) if self._relieved is not None else None
        return words if words is not None and words.places_m == backend.places_m else None
