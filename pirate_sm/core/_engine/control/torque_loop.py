"""A torque loop, which keeps a joint behind a self-locking worm at a torque by its duty.

The series spring is the sensor and the worm is the memory: at duty 0 it keeps the torque without a
current. A motor that winds the spring needs the duty that bears the torque, and one for the error.
"""

from __future__ import annotations

from math import copysign, isnan
from typing import NamedTuple

from pirate_sm.core._engine.control.circumstances import Circumstances
from pirate_sm.core._engine.control.grip import Gripping, after_frame, gripping
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.command_spec import GripSpec, TorqueSpec


class RunningTorqueLoop(NamedTuple):
    """A running torque loop.

    Attributes:
        slot: Whose duty it sets.
        asked_nm: The torque that its state asks for.
        grip: What the size of the torque follows from; None: it is what the state asks for.
        gripping: What is remembered of that.
        output: The duty cycle until the next frame.
        pushing: Whether that is a push, after which the loop waits for one frame.
    """

    slot: int
    spec: TorqueSpec
    asked_nm: float
    grip: GripSpec | None = None
    gripping: Gripping | None = None
    output: float = 0.0
    pushing: bool = False

    @property
    def asks(self) -> tuple[float, GripSpec | None]:
        """Return what its state asks for, whatever has been learned since."""
        return self.asked_nm, self.grip

    @property
    def target_nm(self) -> float:
        """Return the torque that the joint shall bear now."""
        if self.gripping is None:
            return self.asked_nm
        return copysign(self.gripping.torque_nm, self.asked_nm)

    @property
    def exhausted(self) -> bool:
        """Return whether friction may not bear the robot although the part presses all it may."""
        return self.gripping is not None and self.gripping.exhausted

    def heard(self, seen: Circumstances) -> RunningTorqueLoop:
        """Return the loop after a fresh frame of the joint's board.

        The duty is ``gain * error``, and ``torque / stall torque`` more while the motor winds the
        spring. In place of a duty that is too small to move the worm comes a push of one frame,
        then 0 until the frame after that shows what the push did. The duty is 0 where the error
        is small or the torque is unknown: the worm holds.
        """
        if self.grip is not None:
            least_nm = self.grip.at_most_nm - self.spec.within_nm
            presses = abs(seen.numbers[self.spec.torque]) >= least_nm
            before = self.gripping or gripping(self.grip)
            now = after_frame(self.grip, before, seen, presses=presses)
            return self._replace(gripping=now)._driven(seen.numbers)
        return self._driven(seen.numbers)

    def _driven(self, numbers: Numbers) -> RunningTorqueLoop:
        spec, torque = self.spec, numbers[self.spec.torque]
        error = self.target_nm - torque
        if isnan(error) or abs(error) <= spec.dead_nm or self.pushing:
            return self._replace(output=0.0, pushing=False)
        way = 1.0 if error > 0 else -1.0
        winds = way * torque >= 0
        wanted = abs(error) * spec.gain + (way * torque / spec.stall_torque_nm if winds else 0.0)
        size = min(max(wanted, spec.least_duty), spec.limit)
        return self._replace(output=way * size, pushing=wanted < spec.least_duty)

    def duty(self, numbers: Numbers, loss: float = 0.0) -> float:
        """Return the duty cycle; neither the signals nor lost reports matter between frames."""
        return self.output

    def settled(self, numbers: Numbers) -> bool:
        """Whether the joint bears its torque; an unknown torque is not it."""
        return abs(self.target_nm - numbers[self.spec.torque]) <= self.spec.within_nm
