"""A velocity loop that keeps a wheel at a speed."""

from __future__ import annotations

from math import isnan, sin
from typing import NamedTuple

from pirate_sm.core._engine.control.circumstances import Circumstances
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.command_spec import VelocitySpec


class RunningVelocityLoop(NamedTuple):
    """A running velocity loop: u = target / no-load speed + integral.

    The speed of a geared motor follows its duty within one frame, so the plant is nearly static.
    The loop therefore has no proportional term; each new frame corrects the integral.

    Attributes:
        slot: Whose duty it sets.
        target_rad_s: The speed that the wheel shall have.
        assist_nm: Torque by which the wheel bears its share of the weight in an upright pipe; 0
            without gravity compensation.
        integral: What has been learned to be missing, as a duty cycle.
        weight: The duty cycle that bears the wheel's share of the weight in this pipe.
    """

    slot: int
    spec: VelocitySpec
    target_rad_s: float
    assist_nm: float = 0.0
    integral: float = 0.0
    weight: float = 0.0

    def heard(self, seen: Circumstances) -> RunningVelocityLoop:
        """Return the loop after a fresh frame of the wheel's board.

        The integral grows by ``gain`` times the error. It does not change while the speed is
        unknown, and it stops at the limit of the duty (anti-windup).
        """
        loop = self
        if self.assist_nm and not isnan(seen.pitch_rad):
            weight_nm = self.assist_nm * sin(seen.pitch_rad)
            loop = self._replace(weight=weight_nm / self.spec.stall_nm)
        return loop._corrected(seen.numbers[self.spec.speed])

    def _corrected(self, speed: float) -> RunningVelocityLoop:
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
        """Return the duty cycle at which the motor has its speed under the weight alone."""
        return self.target_rad_s / self.spec.no_load_rad_s + self.weight

    def _limited(self, duty: float) -> float:
        return min(max(duty, -self.spec.limit), self.spec.limit)
