"""A proportional position loop that drives a joint to an angle (thesis section 4-2-3)."""

from __future__ import annotations

from typing import NamedTuple

from pirate_sm.core._engine.control.circumstances import Circumstances
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.command_spec import PositionSpec


class RunningPositionLoop(NamedTuple):
    """A running position loop.

    Attributes:
        slot: The slot that it writes.
        angle: Number index of the controlled angle; ``rate`` is the index of its rate.
        torque: Number index of the torque at the joint.
        target_rad: The angle to reach.
    """

    slot: int
    angle: int
    rate: int
    torque: int
    spec: PositionSpec
    target_rad: float

    def heard(self, seen: Circumstances) -> RunningPositionLoop:
        """Return the loop after a fresh frame: it remembers nothing."""
        return self

    def arrived(self, numbers: Numbers) -> bool:
        """Return whether the angle is within the threshold; False while it is unknown."""
        return abs(self.target_rad - numbers[self.angle]) <= self.spec.threshold_rad

    def unmoved(self, numbers: Numbers, origin: Numbers, moved_rad: float) -> bool:
        """Return whether the joint has neither arrived nor turned so far; an unknown turn is 0."""
        moved = bool(origin) and abs(numbers[self.angle] - origin[self.angle]) >= moved_rad
        return moved_rad > 0 and not moved and not self.arrived(numbers)

    def harder(self) -> RunningPositionLoop:
        """Return the loop with the limit for a joint that has not moved."""
        limit = max(self.spec.limit, self.spec.unmoved_limit)
        return self._replace(spec=self.spec._replace(limit=limit))

    def duty(self, numbers: Numbers, loss: float = 0.0) -> float:
        """Return the duty cycle of the controller; 0 within the threshold or for an unknown angle.

        Args:
            numbers: Signals.
            loss: Share of reports that is lost. It reduces the gain: the array that stops the
                joint may come late, so the joint approaches its angle more slowly.
        """
        error = self.target_rad - numbers[self.angle]
        if not abs(error) > self.spec.threshold_rad:
            return 0.0
        size = min(
            max(abs(error) * self.spec.gain * (1 - loss), self.spec.least_duty), self.spec.limit
        )
        return size if error > 0 else -size

    def pushed_nm(self, duty: float, share: float, least_nm: float) -> float:
        """Return the torque that a pushed joint exceeds at this duty."""
        return max(least_nm, share * abs(duty) * self.spec.stall_torque_nm)
