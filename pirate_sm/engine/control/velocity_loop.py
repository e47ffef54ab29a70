"""A velocity loop that keeps a wheel at a speed."""

from __future__ import annotations

from math import isnan
from typing import NamedTuple

from pirate_sm.engine.robot.command_spec import VelocitySpec

Numbers = tuple[float, ...]


class VelocityLoop(NamedTuple):
    """A running velocity loop: u = target / no-load speed + integral.

    The speed of a geared motor follows its duty within one frame, so the plant is nearly static.
    The loop therefore has no proportional term; each new frame corrects the integral.

    Attributes:
        slot: The slot that it writes.
        target_rad_s: The speed to keep.
        integral: The correction learned so far, as a duty cycle.
    """

    slot: int
    spec: VelocitySpec
    target_rad_s: float
    integral: float = 0.0

    @property
    def ends_with_command(self) -> bool:
        """Return False: the loop runs until another state writes the slot."""
        return False

    @property
    def signal(self) -> int:
        """Return the number index of the controlled signal."""
        return self.spec.speed

    def heard(self, numbers: Numbers) -> VelocityLoop:
        """Return the loop after a new frame of the wheel's board.

        The integral grows by ``gain`` times the error. It does not change while the speed is
        unknown, and it stops at the limit of the duty (anti-windup).
        """
        speed = numbers[self.spec.speed]
        if isnan(speed):
            return self
        error = (self.target_rad_s - speed) / self.spec.no_load_rad_s
        wanted = self._limited(self._expected + self.integral + self.spec.gain * error)
        return self._replace(integral=wanted - self._expected)

    def duty(self, numbers: Numbers, loss: float = 0.0) -> float:
        """Return the duty cycle; it changes with new frames only and ignores its arguments."""
        return self._limited(self._expected + self.integral)

    @property
    def _expected(self) -> float:
        """Return the feedforward: the duty cycle for the target speed without load."""
        return self.target_rad_s / self.spec.no_load_rad_s

    def _limited(self, duty: float) -> float:
        return min(max(duty, -self.spec.limit), self.spec.limit)
