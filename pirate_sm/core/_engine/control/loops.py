"""Control loops that compute duty cycles from signals, as a closed union.

Every loop has a ``slot``. ``heard`` returns the loop after a new frame of the board that measures
its signal; ``duty`` returns the duty cycle for the slot.
"""

from __future__ import annotations

from typing import TypeAlias

from pirate_sm.core._engine.control.circumstances import Circumstances
from pirate_sm.core._engine.control.position_loop import RunningPositionLoop
from pirate_sm.core._engine.control.torque_loop import RunningTorqueLoop
from pirate_sm.core._engine.control.velocity_loop import RunningVelocityLoop
from pirate_sm.core._engine.control.wheel_torque_loop import WheelTorqueLoop
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.command_spec import SlotSpec, Write
from pirate_sm.core._engine.sensing.board_spec import BoardSpec

Loop: TypeAlias = RunningPositionLoop | RunningVelocityLoop | RunningTorqueLoop | WheelTorqueLoop
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
            return _seeking(write, slot, numbers, running)
        case "turn":
            if slot.velocity is None:
                return None
            new = RunningVelocityLoop(write.slot, slot.velocity, write.value, write.assist_nm)
            same = isinstance(running, RunningVelocityLoop) and running[:4] == new[:4]
            return running if same else new
        case "bear":
            return _bearing(write, slot, numbers, running)
        case "set" | "keep" | "level":
            return None


def _seeking(write: Write, slot: SlotSpec, numbers: Numbers, running: Loop | None) -> Loop | None:
    """Return the position loop of a write; None for a slot without one.

    The running loop continues while its angle is the one wanted now to within its threshold: the
    loop sees no smaller difference, and a joint that moves the other one would chase its own
    angle. It also continues while the other joint's angle is unknown.
    """
    if slot.position is None:
        return None
    share = 1.0 if write.share_of < 0 else numbers[write.share_of]
    target_rad = write.value * share
    new = RunningPositionLoop(
        write.slot, slot.angle, slot.rate, slot.torque, slot.position, target_rad
    )
    if not isinstance(running, RunningPositionLoop):
        return new
    away_rad = abs(target_rad - running.target_rad)
    moves = away_rad > new.spec.threshold_rad
    return running._replace(target_rad=target_rad) if moves else running


def _bearing(write: Write, slot: SlotSpec, numbers: Numbers, running: Loop | None) -> Loop | None:
    if slot.held_torque is not None:
        loop = RunningTorqueLoop(write.slot, slot.held_torque, write.value, write.grip)
        same = isinstance(running, RunningTorqueLoop) and running.asks == loop.asks
        return running if same else loop.heard(Circumstances(numbers))
    if slot.wheel_torque is not None:
        wheel = WheelTorqueLoop(write.slot, slot.wheel_torque, write.value, write.assist_nm)
        return wheel.heard(Circumstances(numbers))
    return None


def signal_of(loop: Loop) -> int:
    """Return the number index of the signal by which the loop controls its slot."""
    match loop:
        case RunningPositionLoop():
            return loop.angle
        case RunningTorqueLoop():
            return loop.spec.torque
        case RunningVelocityLoop() | WheelTorqueLoop():
            return loop.spec.speed


def ends_with_command(loop: Loop) -> bool:
    """Return whether the loop ends with its command; others run until a state writes the slot."""
    return isinstance(loop, RunningPositionLoop)


def after_frame(board: BoardSpec, loops: Loops, seen: Circumstances) -> Loops:
    """Return the loops after a frame of the board; it tells those of other boards nothing.

    Args:
        board: The board that reported.
        loops: The running loops.
        seen: The signals with the frame in them, and what else loops go by.
    """
    after = tuple(
        [each.heard(seen) if signal_of(each) in board.number_set else each for each in loops]
    )
    return loops if after == loops else after


def quantised(value: float, resolution: float) -> float:
    """Return the value rounded to the resolution of the wire."""
    return round(value / resolution) * resolution
