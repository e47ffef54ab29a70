"""Known defects of real robots, switched on by name; what each acts on stands in the profile.

A defect changes the motors and sensors, the counts of a frame, or the messages, in the simulator
and behind the emulated bay alike. The kinds are here, and a profile's `simulation.defects` gives
them names, targets and numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from pirate_sm.errors import UsageError
from pirate_sm.model.simulation import Defect
from pirate_sm.simulation.acting_defect import Counts, Effect, Incident, Sudden
from pirate_sm.simulation.electronics import Electronics
from pirate_sm.simulation.loss import Loss
from pirate_sm.spelling import meant

AtWork: TypeAlias = tuple[Defect, np.random.Generator]
"""A defect and its own source of chance."""

_WANDER_EVERY_S = 0.5
_WANDER_DUTY = 0.3


class DeadWheel(Effect):
    """A wheel that its motor does not turn, that drags, and whose sensors show nothing."""

    def begin(self) -> None:
        """Let the wheels drag and their channels stand at zero."""
        chain = self.robot.chain
        for name in self.defect.wheels:
            wheel = chain.wheel_index[name]
            drag = self.defect.friction or chain.wheels[wheel].dead_drag_nm
            self.robot.physics.disable_wheel(wheel, drag)
            self.robot.mute_wheel(wheel)


class StiffJoint(Effect):
    """A joint with so much dry friction."""

    def begin(self) -> None:
        """Let the joint resist."""
        if self.defect.joint is not None:
            wheel = self.robot.chain.joint_index[self.defect.joint]
            self.robot.physics.stiffen_joint(wheel, self.defect.friction)


class StuckSensor(Effect):
    """Channels that show a fixed count, or for want of one what they showed last."""

    def begin(self) -> None:
        """Find the channels."""
        rows, defect = self.robot.rows, self.defect
        self._rows: dict[int, float] = {rows[name]: math.nan for name in defect.signals}
        self._rows |= {rows[name]: value for name, value in defect.raw.items()}
        self._held: dict[int, float] = {}

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """Let the channels show what they are stuck at."""
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


class ZeroJump(Sudden):
    """Channels whose zero moves by some counts."""

    def strike(self, now: float) -> None:
        """Move the zeros."""
        for signal, counts in self.defect.raw.items():
            self.robot.shift(signal, counts)


class SilentBay(Effect):
    """Nothing is published or echoed any more, and motors move on their own."""

    _wander = -math.inf

    def step(self, now: float) -> Incident | None:
        """Give a motor a duty that nobody asked for, now and then."""
        if self.active(now) and now >= self._wander:
            self._wander = now + _WANDER_EVERY_S
            duties = self.robot.physics.duties
            index = int(self.rng.integers(len(duties)))
            duties[index] = self.rng.uniform(-_WANDER_DUTY, _WANDER_DUTY)
        return None

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """Let no frame come."""
        return None if self.active(now) else counts

    def delivery(self, now: float) -> tuple[bool, bool]:
        """Let nothing arrive."""
        arrives = not self.active(now)
        return arrives, arrives


class LostMessages(Effect):
    """A share of messages is lost; of two in a row one always arrives (thesis 4-2-2)."""

    def begin(self) -> None:
        """Begin with nothing lost."""
        self._loss = Loss(self.defect.share, True, self.rng)

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """Let the frame come, or lose it."""
        return counts if self._loss.arrives("frame") else None

    def delivery(self, now: float) -> tuple[bool, bool]:
        """Lose the array or its echo now and then."""
        arrives = self._loss.arrives("array")
        return arrives, arrives and self._loss.arrives("echo")


class StaleRepeats(Effect):
    """Boards that say the same again for a while."""

    def begin(self) -> None:
        """Begin with nothing said."""
        self._last: dict[int, Counts] = {}

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """Return what the board said last."""
        if self.defect.boards and board not in self.defect.boards:
            return counts
        if self.active(now) and board in self._last:
            return list(self._last[board])
        self._last[board] = list(counts)
        return counts


class FirmwareReset(Sudden):
    """All setpoints are zero and counters that count from power-on begin again."""

    def strike(self, now: float) -> Incident:
        """Start the boards again."""
        self.robot.restart()
        return Incident("boards_restarted")


class ControllerReset(Sudden):
    """The controller of the link starts again by itself; once it is set up, setpoints are zero."""

    def strike(self, now: float) -> Incident:
        """Say that it does, and that it takes `lasting`."""
        return Incident("controller_restarted", now + self.defect.lasting)


class ControllerHang(Sudden):
    """For a while the controller of the link neither hears nor says anything; motors go on."""

    _until = -math.inf

    def strike(self, now: float) -> Incident:
        """Begin the silence, which has no end unless `lasting` gives one."""
        self._until = now + (self.defect.lasting or math.inf)
        return Incident("controller_hangs", self._until)

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """Let no frame come."""
        return counts if now >= self._until else None

    def delivery(self, now: float) -> tuple[bool, bool]:
        """Let nothing arrive."""
        return now >= self._until, now >= self._until


class StrayMotion(Sudden):
    """A motor that nobody asked moves."""

    def strike(self, now: float) -> Incident:
        """Give one motor a duty."""
        self.robot.twitch(self.rng)
        return Incident("motor_moves")


KINDS: Mapping[str, Callable[[Defect, Electronics, np.random.Generator], Effect]] = {
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
    "controller_reset": ControllerReset,
    "controller_hang": ControllerHang,
    "stray_motion": StrayMotion,
}


def named(names: Sequence[str], defects: Mapping[str, Defect], seed: int) -> list[AtWork]:
    """Return the defects of these names, each with its own source of chance.

    Raises:
        UsageError: There is no defect of that name; suggests the nearest.
    """
    found: list[AtWork] = []
    for number, name in enumerate(names):
        if name not in defects:
            raise UsageError(f"there is no defect '{name}'; {meant(name, defects)}")
        found.append((defects[name], np.random.default_rng((seed, number))))
    return found


def put_to_work(defects: Sequence[AtWork], robot: Electronics) -> tuple[Effect, ...]:
    """Give the robot these defects; return them at work."""
    effects = tuple(KINDS[defect.kind](defect, robot, rng) for defect, rng in defects)
    for effect in effects:
        effect.begin()
    return effects
