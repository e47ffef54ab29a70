"""The engine's signals as arrays for compiled code, and back."""

from __future__ import annotations

from math import inf

import numpy as np

from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import (
    Glided,
    MotorRequest,
    Sensing,
    Surveyed,
    Watch,
    nothing_known,
    sensing_after,
    signal_table,
)
from pirate_sm.simulation.arrays import Floats


class SignalTables:
    """The signals of one engine.

    Args:
        robot: The robot.

    Attributes:
        signals: The cells, see ``Layout`` in ``core/_engine/signals/table.py``.
    """

    def __init__(self, robot: RobotSpec) -> None:
        table = signal_table(robot)
        at = self._layout = table.layout
        self.signals: Floats = np.array(table.cells(nothing_known(robot)))
        ends = at.heard, at.shares, at.angles, at.motion, at.loss
        parts = np.split(self.signals, ends)
        self._numbers, self._heard_s, self._shares, self._angles, self._motion = parts[:5]
        self._of: Sensing | None = None

    def take(self, watch: Watch, asked: MotorRequest) -> None:
        """Take the signals in; what has come from here is there already.

        Args:
            watch: With the signals and the setpoints.
            asked: What the motors have been asked when the next frame comes.
        """
        sensing, before, at = watch.sensing, self._of, self._layout
        if before is None or sensing.numbers is not before.numbers:
            self._numbers[:] = sensing.numbers
        if before is None or sensing.heard_s is not before.heard_s:
            self._heard_s[:] = sensing.heard_s
        if before is None or sensing.shares is not before.shares:
            self._shares[:] = sensing.shares
        if before is None or sensing.angles is not before.angles:
            self._angles[:] = sensing.angles
        if before is None or sensing.motion is not before.motion:
            self._motion[:] = sensing.motion
        self.signals[at.loss : at.out] = (
            *(sensing.loss, *watch.setpoints, *watch.latest),
            *(asked.since_s if asked.setpoints else inf, asked.driving),
        )
        self._of = sensing

    def given(
        self,
        asked: MotorRequest,
        checked_s: float,
        wake_s: float,
        word_s: float,
        surveyed: Surveyed,
    ) -> Glided:
        """Return the signals as the engine has them.

        Args:
            asked: What the motors have been asked.
            checked_s: When silent boards were looked for.
            wake_s: When the engine asks to be called.
            word_s: Until when the detector's word is valid.
            surveyed: What the survey remembers.
        """
        assert self._of is not None  # they have been taken in before
        after = Glided(
            tuple(self._numbers.tolist()),
            tuple(self._heard_s.tolist()),
            tuple(self._shares.tolist()),
            tuple(self._angles.tolist()),
            *(asked, float(self.signals[self._layout.loss]), tuple(self._motion.tolist())),
            *(checked_s, wake_s, word_s),
            surveyed,
        )
        self._of = sensing_after(self._of, after)
        return after
