"""A robot's files and the name of a port become a backend."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.backends.pico.backend import SerialBackend
from pirate_sm.backends.pico.guard_notes import Instructions
from pirate_sm.backends.pico.guarded_port import GuardedPort
from pirate_sm.backends.pico.messages import read_messages
from pirate_sm.backends.pico.plan import Plan, plan_of, serial_of
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.errors import UsageError
from pirate_sm.model.profile import Profile

STAY_S = 600.0
"""How long a guardian goes on without a runner if nobody says: time to come and cut the power."""


def read_plan(folder: Path, profile: Profile, robot: RobotSpec) -> Plan:
    """The robot on its wire.

    Args:
        folder: The robot's, with its message texts.
        profile: The robot.
        robot: The same, as the engine runs it.

    Raises:
        UsageError: It has no serial link, or its texts do not fit; or a library is missing.
    """
    serial = serial_of(profile)
    messages = read_messages(folder / serial.messages, serial, len(profile.slots))
    return plan_of(profile, robot, messages)


def guarded_port(plan: Plan, url: str, baud: int | None, stay_s: float = STAY_S) -> GuardedPort:
    """Return the port, not open yet, which a guardian will own.

    Args:
        plan: The robot on its wire.
        url: A device such as ``/dev/ttyACM0``, or any URL of pyserial.
        baud: In place of the robot's own rate.
        stay_s: How long the guardian goes on without us if the robot does not confirm its stop.

    Raises:
        UsageError: pyserial is missing, which the guardian needs.
    """
    try:
        import serial  # noqa: F401, PLC0415 - only the guardian uses it
    except ModuleNotFoundError:
        raise UsageError(
            "the serial backend needs pyserial, which is not installed: "
            "pip install 'pirate-sm[serial]'"
        ) from None
    link = plan.serial
    instructions = Instructions(link.heartbeat_within, plan.wanted, link.boot, stay_s)
    return GuardedPort(url, baud or link.baud, instructions)


def serial_backend(plan: Plan, url: str, baud: int | None, stay_s: float = STAY_S) -> SerialBackend:
    """Return the robot on this port, which a guardian will own; arguments as above.

    Raises:
        UsageError: pyserial is missing, which the guardian needs.
    """
    port = guarded_port(plan, url, baud, stay_s)
    return SerialBackend(plan, port, baud=baud or plan.serial.baud)
