"""A robot's files and the name of a port become a backend."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.backends.pico.backend import SerialBackend
from pirate_sm.backends.pico.guarded_port import GuardedPort
from pirate_sm.backends.pico.messages import read_messages
from pirate_sm.backends.pico.plan import Plan, plan_of, serial_of
from pirate_sm.engine.robot import RobotSpec
from pirate_sm.errors import UsageError
from pirate_sm.model.profile import Profile


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


def serial_backend(plan: Plan, url: str, baud: int | None) -> SerialBackend:
    """The robot on this port, which a guardian will own.

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
    rate = baud or plan.serial.baud
    port = GuardedPort(url, rate, plan.serial.heartbeat_within)
    return SerialBackend(plan, port, baud=rate)
