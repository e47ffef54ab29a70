"""Shared by `pirate doctor` and `pirate calibrate`: a robot, a port, and a way to stop."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.cli.stop_checks import stopper
from pirate_sm.core.errors import UsageError
from pirate_sm.core.files import library
from pirate_sm.core.loading import LoadedRobot, load_robot
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot.backends.serial.assembly import STAY_S, guarded_port, read_plan
from pirate_sm.robot.diagnosis.facts import ExpectedRobot
from pirate_sm.robot.diagnosis.listening import Listening
from pirate_sm.running.runtime.ending import StopRequests


def find_loaded(name: str | None) -> LoadedRobot:
    """Return the robot with this name or path; by default the first shipped one.

    Raises:
        LoadError: Its files cannot be used.
        UsageError: There is no such robot.
    """
    folder = library.find_robot(name, Path.cwd()) if name else library.robots()[0]
    return load_robot(folder)


def named_port(port: str | None) -> str:
    """Return the port of the options.

    Raises:
        UsageError: There is none.
    """
    if port is None:
        raise UsageError("name the port, --port /dev/ttyACM0, or set `port` (pirate config path)")
    return port


def subject_of(loaded: LoadedRobot, robot: RobotSpec) -> ExpectedRobot:
    """Return the robot with its plan of the serial link.

    Raises:
        UsageError: The robot has no serial link, its messages do not fit, or a library is missing.
    """
    return ExpectedRobot(loaded.profile, robot, read_plan(loaded.folder, loaded.profile, robot))


def connection(
    subject: ExpectedRobot,
    url: str,
    baud: int | None,
    requests: StopRequests,
    stay_s: float | None = None,
) -> Listening:
    """Return a connection to the robot, not opened yet; a guardian will own the port."""
    rate = baud or subject.plan.serial.baud
    port = guarded_port(subject.plan, url, baud, STAY_S if stay_s is None else stay_s)
    return Listening(subject, port, rate, stopper(requests))
