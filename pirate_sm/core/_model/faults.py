"""The built-in faults, which every robot can have.

The list has their codes, origins and meanings, and whether missions may handle them; there is no
other list. A robot's own faults are rules in its profile, see
:class:`pirate_sm.core._model.robot.profile.FaultRule`.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from math import nan
from typing import Final, Literal, NamedTuple, TypeAlias

from pirate_sm.core._model.events import FaultReport

Origin: TypeAlias = Literal["sensors", "link", "camera", "surroundings", "program"]


class _About(NamedTuple):
    code: str
    origin: Origin
    catchable: bool
    meaning: str


class BuiltInFault(Enum):
    """A fault that any robot can have.

    Attributes:
        code: The name that missions and views use.
        origin: What the fault is seen by.
        catchable: Whether a mission may handle it (rule 10).
        meaning: What is wrong.
    """

    SENSOR_SILENT = _About(
        "sensor.silent", "sensors", True, "a board does not report, or a sensor has no value"
    )
    SENSOR_STUCK = _About(
        "sensor.stuck",
        "sensors",
        True,
        "a sensor shows the same value although its motor must turn",
    )
    SENSOR_SPIKING = _About(
        "sensor.spiking", "sensors", True, "a sensor often shows an impossible value for a moment"
    )
    SENSOR_RANGE = _About(
        "sensor.range", "sensors", True, "a sensor shows a value outside its range, and keeps to it"
    )
    SENSOR_JUMPED = _About(
        "sensor.jumped", "sensors", True, "a joint's angle has changed faster than it can"
    )
    MOTION_UNASKED = _About(
        "motion.unasked", "sensors", True, "something moves although no motor is driven"
    )
    LINK_SILENT = _About("link.silent", "link", False, "no board reports any more")
    LINK_LOST = _About(
        "link.lost", "link", False, "the port has disappeared and not come back within its time"
    )
    LINK_INTERRUPTED = _About("link.interrupted", "link", True, "the port was gone and is back")
    LINK_NO_ECHO = _About("link.no_echo", "link", False, "setpoints could not be confirmed")
    LINK_MISMATCH = _About(
        "link.mismatch", "link", False, "after a reset the firmware means something else by a topic"
    )
    RUNNER_STALLED = _About(
        "runner.stalled",
        "program",
        False,
        "the guardian has acted because this program stood still",
    )
    FIRMWARE_RESET = _About(
        "firmware.reset", "link", True, "the controller has started again in the middle of the run"
    )
    BACKEND_FAILED = _About(
        "backend.failed", "program", False, "the backend has refused setpoints or has failed itself"
    )
    PLACE_CONTRADICTED = _About(
        "place.contradicted",
        "sensors",
        True,
        "a bend would be said to be passed, and the robot's shape does not fit the pipe there",
    )
    PIPE_IMPASSABLE = _About(
        "pipe.impassable", "surroundings", True, "the simulated robot is in front of an obstacle"
    )
    ROBOT_LEFT_PIPE = _About(
        "robot.left_pipe", "surroundings", False, "the simulated robot is outside of its pipe"
    )
    ROBOT_SLID = _About(
        "robot.slid",
        "surroundings",
        False,
        "the simulated robot has slid while no part held it and no wheel was driven",
    )
    VISION_SILENT = _About("vision.silent", "camera", True, "the camera sends no pictures")
    VISION_FROZEN = _About("vision.frozen", "camera", True, "the camera repeats one picture")
    VISION_DARK = _About("vision.dark", "camera", True, "the camera's pictures show no contrast")
    VISION_MOVED = _About(
        "vision.moved", "camera", True, "the camera or the setup is not where it was surveyed"
    )
    VISION_BLIND = _About(
        "vision.blind", "camera", True, "the camera sees nothing of the robot while it drives"
    )
    GRIP_EXHAUSTED = _About(
        "grip.exhausted",
        "sensors",
        True,
        "a part presses as hard as it may, and friction may not bear the robot",
    )
    DISTANCE_UNKNOWN = _About(
        "distance.unknown",
        "sensors",
        True,
        "the robot may be farther from the distance that its wheels show than the mission allows",
    )
    RULE_VIOLATED = _About(
        "rule.violated", "program", False, "a safety rule of the robot is broken, or would be"
    )
    START_CONTRADICTED = _About(
        "start.contradicted", "sensors", False, "the robot does not stand as the mission says"
    )
    STATE_CONTRADICTED = _About(
        "state.contradicted",
        "sensors",
        False,
        "after its controller was away, the robot is not as it was known",
    )
    PANEL_LOST = _About(
        "panel.lost",
        "link",
        True,
        "the control panel is disconnected, and there is no operator at a keyboard",
    )
    MISSION_RUNAWAY = _About(
        "mission.runaway", "program", False, "phases follow each other faster than sensors report"
    )

    def __init__(self, code: str, origin: Origin, catchable: bool, meaning: str) -> None:
        self.code, self.origin, self.catchable, self.meaning = code, origin, catchable, meaning

    def report(self, message: str, away_s: float = nan, *, of: tuple[str, ...] = ()) -> FaultReport:
        """Return a report of this fault, with how long the controller was away and whose it is."""
        return FaultReport(self.code, message, away_s, of)


UNSEEN: Final = frozenset(
    fault.code
    for fault in (
        BuiltInFault.SENSOR_SILENT,
        BuiltInFault.SENSOR_STUCK,
        BuiltInFault.SENSOR_RANGE,
        BuiltInFault.SENSOR_JUMPED,
    )
)
"""Faults after which what the sensor measures is unknown, so that nothing proves it any more."""

BUILT_IN_FAULTS: Final[Mapping[str, BuiltInFault]] = {each.code: each for each in BuiltInFault}
