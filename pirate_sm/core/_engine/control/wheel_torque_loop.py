"""A wheel torque loop, which keeps the torque of a wheel by its motor's characteristic."""

from __future__ import annotations

from math import isnan, sin
from typing import NamedTuple

from pirate_sm.core._engine.control.circumstances import Circumstances
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.command_spec import WheelTorqueSpec


class WheelTorqueLoop(NamedTuple):
    """A running wheel torque loop: u = target / stall torque + speed / no-load speed.

    A geared motor gives the torque ``stall torque * (u - speed / no-load speed)``, so the loop
    makes up for the speed that the last frame showed.

    Attributes:
        slot: Whose duty it sets.
        target_nm: The torque that the motor shall give, behind its gears.
        assist_nm: Torque by which the wheel bears its share of the weight in an upright pipe; 0
            without gravity compensation.
        weight_nm: The same in this pipe.
        speed_rad_s: The speed of the wheel at the last frame that showed it.
    """

    slot: int
    spec: WheelTorqueSpec
    target_nm: float
    assist_nm: float = 0.0
    speed_rad_s: float = 0.0
    weight_nm: float = 0.0

    def heard(self, seen: Circumstances) -> WheelTorqueLoop:
        """Return the loop after a fresh frame; it keeps the last speed while that is unknown."""
        after = self
        if self.assist_nm and not isnan(seen.pitch_rad):
            after = after._replace(weight_nm=self.assist_nm * sin(seen.pitch_rad))
        speed = seen.numbers[self.spec.speed]
        return after if isnan(speed) else after._replace(speed_rad_s=speed)

    def duty(self, numbers: Numbers, loss: float = 0.0) -> float:
        """Return the duty cycle, within its limits."""
        spec = self.spec
        torque_nm = self.target_nm + self.weight_nm
        duty = torque_nm / spec.stall_torque_nm + self.speed_rad_s / spec.no_load_rad_s
        return min(max(duty, -1.0), 1.0)
