"""A position loop, which brings a joint to an angle by its duty (thesis section 4-2-3)."""

from __future__ import annotations

from typing import NamedTuple

from pirate_sm.engine.control.circumstances import Circumstances
from pirate_sm.engine.robot.command_spec import PositionSpec

Numbers = tuple[float, ...]


class PositionLoop(NamedTuple):
    """A running position loop.

    Attributes:
        slot: Whose duty it sets.
        angle: Number index of the controlled angle; ``rate`` that of its rate.
        torque: Number index of the torque that its joint bears.
        target_rad: Where it shall come to.
    """

    slot: int
    angle: int
    rate: int
    torque: int
    spec: PositionSpec
    target_rad: float

    @property
    def ends_with_command(self) -> bool:
        """Return that it ends when its command does."""
        return True

    @property
    def signal(self) -> int:
        """Return the number index of the signal that it controls."""
        return self.angle

    def heard(self, seen: Circumstances) -> PositionLoop:
        """Return the loop after a fresh frame: it remembers nothing."""
        return self

    def arrived(self, numbers: Numbers) -> bool:
        """Whether the angle is inside the threshold; an unknown angle has not arrived."""
        return abs(self.target_rad - numbers[self.angle]) <= self.spec.threshold_rad

    def duty(self, numbers: Numbers, loss: float = 0.0) -> float:
        """Return the duty cycle of a proportional controller, 0 once arrived or when blind.

        Args:
            numbers: Signals.
            loss: Share of reports that is lost. The gain is smaller by it: where the array that
                stops the joint may come late, the joint comes to its angle more slowly.
        """
        error = self.target_rad - numbers[self.angle]
        if not abs(error) > self.spec.threshold_rad:
            return 0.0
        size = min(
            max(abs(error) * self.spec.gain * (1 - loss), self.spec.least_duty), self.spec.limit
        )
        return size if error > 0 else -size

    def pushes(self, numbers: Numbers, setpoints: Numbers, share: float) -> bool:
        """Whether the joint bears ``share`` of the torque that its duty gives at stall."""
        duty = setpoints[self.slot]
        borne = numbers[self.torque] * (1.0 if duty > 0 else -1.0)
        return duty != 0 and borne > share * abs(duty) * self.spec.stall_torque_nm
