"""Explains in one sentence why a connection fails, and what to do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from pirate_sm.robot.backends.serial.link.conversation import Conversation

NO_SENSORS = "the robot's controller answers but no board sends any value"

_TEXT_SHARE = 0.9
_SHOWN = 40


def unanswered(
    port: str, baud: int, conversation: Conversation, sample: bytes, usual_baud: int | None = None
) -> str:
    """Return why the required topics have not been introduced.

    Args:
        port: Name of the port.
        baud: Baud rate of the line.
        conversation: The conversation so far.
        sample: The last bytes received.
        usual_baud: The baud rate in the robot's profile.
    """
    if conversation.frames:
        return _incomplete(port, conversation)
    if usual_baud not in {None, baud} and not sample:
        return (
            f"nothing answers on {port} at {baud} baud: the robot's profile says that its firmware "
            f"speaks {usual_baud}"
        )
    if not sample:
        return (
            f"nothing answers on {port} at {baud} baud: is this the robot's port, is it switched "
            "on, does its firmware speak rosserial at this speed?"
        )
    printable = sum(32 <= byte < 127 or byte in b"\r\n\t" for byte in sample)
    if printable >= _TEXT_SHARE * len(sample):
        shown = " ".join(sample.decode("ascii", "replace").split())[:_SHOWN]
        return f"{port} does not speak rosserial, it sends '{shown}': another device?"
    return (
        f"{port} sends bytes that make no sense at {baud} baud: the firmware uses another speed "
        "(option baud), or it is another device"
    )


def _incomplete(port: str, conversation: Conversation) -> str:
    missing = ", ".join(
        f"{each.name} ({each.type}, which it {each.direction})" for each in conversation.missing
    )
    offered = sorted(
        f"{info.name} ({info.type}, which it {info.direction})"
        for info in conversation.offered.values()
    )
    there = ", ".join(offered) if offered else "no topic at all"
    return (
        f"the device on {port} speaks rosserial but does not announce {missing}. It offers "
        f"{there}: put its names and types into section 'serial' of the robot's profile"
    )


def no_sensors(advice: str) -> str:
    """Return the message that no board reports; ``advice`` is the profile's, or empty."""
    return f"{NO_SENSORS}: {sensors_off(advice)}"


def sensors_off(advice: str) -> str:
    """Return what a person can do when no board reports; ``advice`` may be empty."""
    return advice or "are the sensors switched on, are the boards powered?"


def mute(modules: Mapping[int, str], silent: Iterable[int]) -> str:
    """Return which boards do not report."""
    names = ", ".join(f"{board} ({modules[board]})" for board in sorted(silent))
    return f"no values come from board {names}"
