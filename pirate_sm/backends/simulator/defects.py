"""Known defects of real robots, switched on by name; what each acts on stands in the profile.

A defect changes the world, the counts of a frame, or the messages. The kinds are here, and a
profile's `simulation.defects` gives them names, targets and numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from pirate_sm.backends.simulator.world import World
from pirate_sm.errors import UsageError
from pirate_sm.model.events import FaultReport
from pirate_sm.model.fault_codes import BuiltInFault
from pirate_sm.model.simulation import Defect
from pirate_sm.spelling import nearest

Counts: TypeAlias = list[float]

_WANDER_EVERY_S = 0.5
_WANDER_DUTY = 0.3


class Effect:
    """One defect at work; a kind overrides what it changes.

    Args:
        defect: Its numbers.
        world: What it acts on.
        rng: Its own source of chance.
    """

    def __init__(self, defect: Defect, world: World, rng: np.random.Generator) -> None:
        self.defect = defect
        self.world = world
        self.rng = rng
        self._until = -math.inf
        self._next = defect.after + self._pause()

    def active(self, now: float) -> bool:
        """Whether an occurrence goes on.

        With `every` they come at random from `after` on; without, one begins at `after`. Without
        `lasting` one never ends.
        """
        if now < self._until:
            return True
        if now < self._next:
            return False
        defect = self.defect
        self._until = now + defect.lasting if defect.lasting > 0 else math.inf
        self._next = self._until + (self._pause() or math.inf)
        return True

    def _pause(self) -> float:
        """How long it is until the next occurrence; 0 for a defect that does not come again."""
        every = self.defect.every
        return float(self.rng.exponential(every)) if every > 0 else 0.0

    def begin(self) -> None:
        """The world is as the defect makes it from the start."""

    def step(self, now: float) -> FaultReport | None:
        """The defect has had its effect on the world at this time."""
        return None

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """What the board's frame says instead; None when it does not arrive.

        Args:
            now: Time.
            board: Id of the board.
            first: Row of the channel table of its first channel.
            counts: What it should say; may be changed.
        """
        return counts

    def delivery(self, now: float) -> tuple[bool, bool]:
        """Whether an array sent now arrives, and whether its echo does."""
        return True, True


class DeadWheel(Effect):
    """A wheel that its motor does not turn, that drags, and whose sensors show nothing."""

    def begin(self) -> None:
        """The wheels drag and their channels stand at zero."""
        for name in self.defect.wheels:
            wheel = self.world.machine.wheels[name]
            drag = self.defect.friction or self.world.machine.chain.wheels[wheel].dead_drag_nm
            self.world.disable_wheel(wheel, drag)
            self.world.mute_wheel(wheel)


class StiffJoint(Effect):
    """A joint with so much dry friction."""

    def begin(self) -> None:
        """The joint resists."""
        if self.defect.joint is not None:
            wheel = self.world.machine.joints[self.defect.joint]
            self.world.stiffen_joint(wheel, self.defect.friction)


class StuckSensor(Effect):
    """Channels that show a fixed count, or for want of one what they showed last."""

    def __init__(self, defect: Defect, world: World, rng: np.random.Generator) -> None:
        super().__init__(defect, world, rng)
        rows = world.machine.places
        self._rows: dict[int, float] = {rows[name]: math.nan for name in defect.signals}
        self._rows |= {rows[name]: value for name, value in defect.raw.items()}
        self._held: dict[int, float] = {}

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """The channels show what they are stuck at."""
        mine = [row for row in self._rows if first <= row < first + len(counts)]
        if not mine:
            return counts
        if not self.active(now):
            self._held.clear()
            return counts
        for row in mine:
            shown = self._rows[row]
            if math.isnan(shown):
                shown = self._held.setdefault(row, counts[row - first])
            counts[row - first] = shown
        return counts


class ZeroJump(Effect):
    """Channels whose zero moves by some counts."""

    def step(self, now: float) -> FaultReport | None:
        """The zero has moved once its time has come."""
        if self._next <= now:
            self._next = math.inf
            rows = [self.world.machine.places[name] for name in self.defect.raw]
            self.world.offset_channels(rows, self.defect.raw.values())
        return None


class SilentBay(Effect):
    """Nothing is published or echoed any more, and motors move on their own."""

    def __init__(self, defect: Defect, world: World, rng: np.random.Generator) -> None:
        super().__init__(defect, world, rng)
        self._wander = -math.inf

    def step(self, now: float) -> FaultReport | None:
        """A motor has been given a duty that nobody asked for."""
        if self.active(now) and now >= self._wander:
            self._wander = now + _WANDER_EVERY_S
            index = int(self.rng.integers(len(self.world.command)))
            self.world.command[index] = self.rng.uniform(-_WANDER_DUTY, _WANDER_DUTY)
        return None

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """No frame comes."""
        return None if self.active(now) else counts

    def delivery(self, now: float) -> tuple[bool, bool]:
        """Nothing arrives."""
        arrives = not self.active(now)
        return arrives, arrives


class LostMessages(Effect):
    """A share of messages is lost; of two in a row one always arrives (thesis 4-2-2)."""

    def __init__(self, defect: Defect, world: World, rng: np.random.Generator) -> None:
        super().__init__(defect, world, rng)
        self._lost = {"frame": False, "array": False, "echo": False}

    def _arrives(self, kind: str) -> bool:
        # After a loss one always arrives, so of the others more must be lost.
        share = self.defect.share / max(1.0 - self.defect.share, 0.5)
        self._lost[kind] = not self._lost[kind] and self.rng.random() < share
        return not self._lost[kind]

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """The frame comes or is lost."""
        return counts if self._arrives("frame") else None

    def delivery(self, now: float) -> tuple[bool, bool]:
        """The array or its echo may be lost."""
        arrives = self._arrives("array")
        return arrives, arrives and self._arrives("echo")


class StaleRepeats(Effect):
    """Boards that say the same again for a while."""

    def __init__(self, defect: Defect, world: World, rng: np.random.Generator) -> None:
        super().__init__(defect, world, rng)
        self._last: dict[int, Counts] = {}

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """The board says what it said last."""
        if self.defect.boards and board not in self.defect.boards:
            return counts
        if self.active(now) and board in self._last:
            return list(self._last[board])
        self._last[board] = list(counts)
        return counts


class FirmwareReset(Effect):
    """All setpoints are zero and counters that count from power-on begin again."""

    def step(self, now: float) -> FaultReport | None:
        """The boards have started again once its time has come."""
        if self._next > now:
            return None
        self._next = math.inf
        self.world.restart_boards()
        return BuiltInFault.FIRMWARE_RESET.report("the boards have started again")


KINDS: Mapping[str, Callable[[Defect, World, np.random.Generator], Effect]] = {
    "dead_wheel": DeadWheel,
    "stiff_joint": StiffJoint,
    "sensor_stuck": StuckSensor,
    "sensor_drop": StuckSensor,
    "sensor_spike": StuckSensor,
    "zero_jump": ZeroJump,
    "silent_bay": SilentBay,
    "lost_messages": LostMessages,
    "stale_repeats": StaleRepeats,
    "firmware_reset": FirmwareReset,
}


def make_effects(
    names: Sequence[str], defects: Mapping[str, Defect], world: World, seed: int
) -> tuple[Effect, ...]:
    """The named defects are at work in the world.

    Raises:
        UsageError: There is no defect of that name; suggests the nearest.
    """
    effects: list[Effect] = []
    for number, name in enumerate(names):
        if name not in defects:
            near = nearest(name, defects)
            hint = f"; did you mean '{near}'?" if near else ""
            raise UsageError(f"there is no defect '{name}'{hint}")
        defect = defects[name]
        effect = KINDS[defect.kind](defect, world, np.random.default_rng((seed, number)))
        effect.begin()
        effects.append(effect)
    return tuple(effects)
