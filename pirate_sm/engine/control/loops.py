"""The loops that set duties from signals: a closed union, and which of them a write begins.

Every loop has a ``slot``, the ``signal`` that it controls, and says whether it
``ends_with_command``; ``heard`` returns it after a fresh frame of its signal's board, with what it
remembers, and ``duty`` what its slot gets now.
"""

from __future__ import annotations

from typing import TypeAlias

from pirate_sm.engine.control.position_loop import PositionLoop
from pirate_sm.engine.control.velocity_loop import VelocityLoop
from pirate_sm.engine.robot.command_spec import SlotSpec, Write
from pirate_sm.engine.sensing.board_spec import BoardSpec

Numbers = tuple[float, ...]
Loop: TypeAlias = PositionLoop | VelocityLoop
Loops: TypeAlias = tuple[Loop, ...]


def begun(write: Write, slot: SlotSpec, numbers: Numbers, running: Loop | None) -> Loop | None:
    """Return the loop that a write names; None for a write that names none.

    Args:
        write: What a stage does to the slot.
        slot: The slot.
        numbers: Signals; a share of an angle is taken of the one that is measured now.
        running: The loop that runs on the slot. Where the write names the same, it goes on with
            what it remembers.
    """
    match write.how:
        case "seek":
            if slot.position is None:
                return None
            share = 1.0 if write.share_of < 0 else numbers[write.share_of]
            target_rad = write.value * share
            return PositionLoop(
                write.slot, slot.angle, slot.rate, slot.torque, slot.position, target_rad
            )
        case "turn":
            if slot.velocity is None:
                return None
            new = VelocityLoop(write.slot, slot.velocity, write.value)
            same = isinstance(running, VelocityLoop) and running._replace(integral=0.0) == new
            return running if same else new
        case "set" | "keep":
            return None


def after_frame(board: BoardSpec, loops: Loops, numbers: Numbers) -> Loops:
    """Return the loops after a frame of the board; it tells those of other boards nothing.

    Args:
        board: Whose frame it was.
        loops: The running loops.
        numbers: Signals with the frame in them.
    """
    after = tuple(
        [each.heard(numbers) if each.signal in board.number_set else each for each in loops]
    )
    return loops if after == loops else after


def quantised(value: float, resolution: float) -> float:
    """Return the nearest step of the wire."""
    return round(value / resolution) * resolution
