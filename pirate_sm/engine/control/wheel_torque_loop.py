"""A wheel torque loop, which keeps the torque of a wheel by its motor's characteristic."""

from __future__ import annotations

from math import isnan
from typing import NamedTuple

from pirate_sm.engine.robot.command_spec import WheelTorqueSpec

Numbers = tuple[float, ...]


class WheelTorqueLoop(NamedTuple):
    """A running wheel torque loop: u = target / stall torque + speed / no-load speed.

    A geared motor gives the torque ``stall torque * (u - speed / no-load speed)``, so the loop
    makes up for the speed that the last frame showed.

    Attributes:
        slot: Whose duty it sets.
        target_nm: The torque that the motor shall give, behind its gears.
        speed_rad_s: The speed of the wheel at the last frame that showed it.
    """

    slot: int
    spec: WheelTorqueSpec
    target_nm: float
    speed_rad_s: float = 0.0

    @property
    def ends_with_command(self) -> bool:
        """Return that it runs until another state writes the slot."""
        return False

    @property
    def signal(self) -> int:
        """Return the number index of the signal that it needs."""
        return self.spec.speed

    def heard(self, numbers: Numbers) -> WheelTorqueLoop:
        """Return the loop after a fresh frame; it keeps the last speed while that is unknown."""
        speed = numbers[self.spec.speed]
        return self if isnan(speed) else self._replace(speed_rad_s=speed)

    def duty(self, numbers: Numbers, loss: float = 0.0) -> float:
        """Return the duty cycle, within its limits."""
        spec = self.spec
        duty = self.target_nm / spec.stall_torque_nm + self.speed_rad_s / spec.no_load_rad_s
        return min(max(duty, -1.0), 1.0)
