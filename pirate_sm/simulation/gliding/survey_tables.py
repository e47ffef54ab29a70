"""The survey of the pipe as arrays for compiled code, and back."""

from __future__ import annotations

from math import inf

import numpy as np

from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import Surveyed, Watch, environment
from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.gliding import surveying

_SEGMENTS = {
    "": surveying.UNKNOWN,
    environment.OUT: surveying.OUT,
    environment.STRAIGHT: surveying.STRAIGHT,
    environment.JOINT: surveying.JOINT,
}


class SurveyTables:
    """The tables of a robot and of its survey.

    Args:
        robot: The robot.
    """

    def __init__(self, robot: RobotSpec) -> None:
        self._body = _body_tables(robot)
        self._held: Ints = np.zeros((3, 0), dtype=np.int64)
        samples = environment.SAMPLES
        self._surveys: Floats = np.zeros((2, col.SURVEY_ENTRIES + (3 + 1) * samples))
        self._surveyed = self._surveys[0]
        self._forces: Floats = self._surveyed[col.SURVEY_ENTRIES : -samples].reshape(-1, 3)
        self._of: Watch | None = None
        self._last: Surveyed | None = None

    @property
    def arrays(self) -> tuple[Floats | Ints, ...]:
        """Return the arrays, in the order of the arguments of `surveying.survey`."""
        return *self._body, self._held, self._surveys

    def take(self, watch: Watch) -> None:
        """Take in what the survey remembers; what has come from here is there already."""
        surveyed, before = watch.surveyed, self._of
        if before is None or watch.held is not before.held:
            self._held = np.tile(np.array(watch.held, dtype=np.int64), (3, 1))
        if surveyed is not self._last:
            self._take(surveyed)
        # A report from outside replaces the robot's own for a time, which the engine sees to.
        counts = surveyed.outside_until_s == -inf
        self._surveyed[col.E_DUE_S] = surveyed.due_s if counts else inf
        self._surveyed[col.E_IN_BEND] = watch.in_bend
        self._surveyed[col.E_WORD] = watch.word is not None
        self._surveyed[col.E_MADE] = 0.0
        self._of = watch

    def _take(self, surveyed: Surveyed) -> None:
        reported, count = surveyed.reported, len(surveyed.forces)
        self._surveyed[: col.E_WORD] = (
            *(surveyed.due_s, surveyed.part, surveyed.in_bend, surveyed.felt_s),
            *(surveyed.straight_m, count, _SEGMENTS.get(reported.segment, -2)),
            *(reported.roll_rad, reported.pitch_rad, reported.diameter_m),
        )
        if count:
            self._forces[:count] = surveyed.forces
        self._last = surveyed

    def given(self) -> Surveyed:
        """Return what the survey remembers now."""
        assert self._last is not None  # it has been taken in before
        found = self._surveyed.tolist()
        if found[col.E_MADE] == 0.0:
            return self._last
        forces = self._forces[: int(found[col.E_FORCES])].tolist()
        self._last = self._last._replace(
            forces=tuple([(ahead, side, up) for ahead, side, up in forces]),
            felt_s=found[col.E_FELT_S],
            part=int(found[col.E_PART]),
            in_bend=bool(found[col.E_IN_BEND]),
            due_s=found[col.E_DUE_S],
            straight_m=found[col.E_STRAIGHT_M],
        )
        return self._last


def _body_tables(robot: RobotSpec) -> tuple[Floats, Floats, Floats]:
    """Return the chain of the robot, its parts, and its numbers, see `columns.py`."""
    body, imu = robot.body, robot.body.imu
    chain = zip(body.joints, body.sides, (*body.lengths_m, 0.0), strict=True)
    parts = [
        (vee.angle, vee.diameter, vee.end_stop_rad, vee.wheels[0], vee.wheels[-1])
        for vee in body.parts
    ]
    felt = (-1, 0, 0, 0, -1) if imu is None else (imu.link, *imu.axes, imu.roll)
    return (
        np.array(list(chain), dtype=np.float64).reshape(-1, 3),
        np.array(parts, dtype=np.float64).reshape(-1, 5),
        np.array((body.wheel_radius_m, *felt, robot.link.stale_after_s), dtype=np.float64),
    )
