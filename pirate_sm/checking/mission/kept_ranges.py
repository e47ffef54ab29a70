"""Ranges of signals that commands and controls in force keep during a wait."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Set
from math import degrees, inf, radians

from pirate_sm.checking.actuation_in_force import Actuated, InForce
from pirate_sm.checking.exploring.signal_ranges import Range
from pirate_sm.core.robot import SlotSpec, Write

STILL_M_S = 0.01
"""Largest speed against its drive that is noise [decided]."""

ANGLE_OFF_RAD = radians(15)
"""How far a joint may be off the angle that its board was asked for [decided]."""

WOUND = 4.0
"""Largest torque in a loop's joint, as a share of what the loop keeps [decided]: in a simulated
bend others have wound springs to twice their own motor's torque."""

Limit = tuple[str, Range, str]
"""A signal, its range, and the reason."""


def about(most: float) -> Range:
    """Return the range of what is at most so large, to either side."""
    return Range(-most, most)


def kept_ranges(
    force: InForce, at: Collection[Actuated], ways: set[int], speed: str, names: Set[str]
) -> Iterator[Limit]:
    """Yield the ranges of the speed, of angles that boards keep, and of torques under loops.

    Args:
        force: What is in force.
        at: In which configurations and under which controls the wait begins.
        ways: Which ways the robot drives in these.
        speed: The signal of the robot's speed; empty without one.
        names: The signals whose ranges are wanted.
    """
    for way, side in ((1, Range(-STILL_M_S, inf)), (-1, Range(-inf, STILL_M_S))):
        if ways == {way}:
            yield speed, side, f"the robot drives {'forward' if way > 0 else 'back'} in this wait"
    numbers = force.robot.vocabulary.numbers
    for number, slot in enumerate(force.robot.slots):
        if not any(each >= 0 and numbers[each] in names for each in (slot.angle, slot.torque)):
            continue
        writes = [write for each in at if (write := force.last_of(each, number)) is not None]
        if len(writes) < len(at):
            continue
        if (angle := _angle(slot, force, at, number)) is not None:
            yield numbers[slot.angle], *angle
        if slot.torque >= 0 and all(write.how == "bear" for write in writes):
            loops = (w for each in at for w in force.last_writes(each) if w.how == "bear")
            most = max(map(_borne_nm, loops))  # joints of one part wind each other
            yield numbers[slot.torque], about(most * WOUND), f"a loop keeps {most:.3g} Nm at most"


def _angle(
    slot: SlotSpec, force: InForce, at: Collection[Actuated], number: int
) -> tuple[Range, str] | None:
    """Return the range of an angle that a board has brought to other angles than 0."""
    if slot.unit != "angle" or slot.angle < 0:
        return None
    asked = set[float]()
    for write in {write for each in at for write in force.may_follow(each, number)}:
        if write is None or write.how != "set" or write.share_of >= 0:
            return None
        asked.add(write.value)
    if asked == {0.0}:
        return None
    span = Range(min(*asked, 0.0) - ANGLE_OFF_RAD, max(*asked, 0.0) + ANGLE_OFF_RAD)
    said = " or ".join(f"{degrees(each):.4g} deg" for each in sorted(asked))
    return span, f"a command has brought it to {said}"


def _borne_nm(write: Write) -> float:
    """Return the largest torque that a loop is asked for, Nm."""
    return abs(write.value) if write.grip is None else write.grip.at_most_nm
