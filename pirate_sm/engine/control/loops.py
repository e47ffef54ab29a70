"""Control loops that compute duty cycles from signals, as a closed union.

Every loop has a ``slot``, the ``signal`` that it controls, and the property ``ends_with_command``.
``heard`` returns the loop after a new frame of the signal's board; ``duty`` returns the duty cycle
for the slot.
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
    """Return the loop that a write starts or continues, None where it needs no loop.

    Args:
        write: What a stage does to the slot.
        slot: The slot that is written.
        numbers: Signals; an angle given as a share is computed from the angle measured now.
        running: The loop that runs on the slot. It continues, with its integral, if the write
            asks for the same loop.
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
    """Return the loops after a frame of the board; loops on signals of other boards are unchanged.

    Args:
        board: The board that reported.
        loops: The running loops.
        numbers: Signals, updated by the frame.
    """
    after = tuple(
        [each.heard(numbers) if each.signal in board.number_set else each for each in loops]
    )
    return loops if after == loops else after


def quantised(value: float, resolution: float) -> float:
    """Return the value rounded to the resolution of the wire."""
    return round(value / resolution) * resolution
