"""Makes the serial backend from a robot's files and the name of a port."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.core.errors import not_installed
from pirate_sm.core.models import Profile
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.backends.serial.firmware_tables import tables_of
from pirate_sm.robot.backends.serial.guardian.guard import Instructions
from pirate_sm.robot.backends.serial.guardian.guarded_port import GuardedPort
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan, plan_of
from pirate_sm.robot.rosserial.messages import read_messages, serial_of

STAY_S = 600.0
"""How long a guardian goes on without a runner by default: enough time to cut the power."""


def read_plan(folder: Path, profile: Profile, robot: RobotSpec) -> LinkPlan:
    """Return the robot's link plan, made from its profile and its message definitions.

    Args:
        folder: The robot's folder, with its message definitions.
        profile: The robot's profile.
        robot: The robot as the engine runs it.

    Raises:
        UsageError: The profile has no serial link, the definitions do not fit it, or a library is
            missing.
    """
    serial = serial_of(profile)
    messages = read_messages(folder / serial.messages, serial, len(profile.slots))
    plan = plan_of(profile, robot, messages)
    return plan._replace(tables=tables_of(profile, plan))


def guarded_port(plan: LinkPlan, url: str, baud: int | None, stay_s: float = STAY_S) -> GuardedPort:
    """Return a port, still closed, that a guardian will own.

    Args:
        plan: The robot's link plan.
        url: A device such as ``/dev/ttyACM0``, or any URL of pyserial.
        baud: Baud rate instead of the profile's.
        stay_s: How long the guardian goes on without a runner if the robot does not confirm its
            stop.

    Raises:
        UsageError: pyserial is missing, which the guardian needs.
    """
    try:
        import serial  # noqa: F401, PLC0415 - only the guardian uses it
    except ModuleNotFoundError:
        raise not_installed("the serial backend", "pyserial", "serial") from None
    link = plan.serial
    instructions = Instructions(link.heartbeat_within, plan.wanted, link.boot, stay_s)
    return GuardedPort(url, baud or link.baud, instructions)


def serial_backend(
    plan: LinkPlan, url: str, baud: int | None, stay_s: float = STAY_S
) -> SerialBackend:
    """Return the serial backend on this port, which a guardian will own; arguments as above.

    Raises:
        UsageError: pyserial is missing, which the guardian needs.
    """
    port = guarded_port(plan, url, baud, stay_s)
    return SerialBackend(plan, port, baud=baud or plan.serial.baud, tended=True)
