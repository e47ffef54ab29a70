"""The criteria of commands, in words."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees
from typing import assert_never

from pirate_sm.core.profile import Profile
from pirate_sm.core.profile import criteria as kinds
from pirate_sm.core.spelling import listed
from pirate_sm.core.units import ANGLE, Quantity, format_quantity


def done_when(profile: Profile, criterion: kinds.Criterion) -> str:
    """Return how a command with this criterion is found to be done, in words."""
    match criterion:
        case kinds.Accepted():
            return "its setpoints are accepted: no sensor shows more"
        case kinds.Stalled():
            return (
                f"{_joints(criterion.joints)} still, slower than {_rate(criterion.still)}, and "
                f"{_bearing(criterion)} more than {_load(criterion)}{_lasting(criterion.for_s)}"
                f"{_settled(criterion)}"
            )
        case kinds.Reached():
            return f"every joint has come to its angle{_or_stopped(criterion)}"
        case kinds.Turning():
            fast = f"{(criterion.share or 0.0) * 100:g} % of its motor's speed without load"
            fast = fast if criterion.above is None else f"{criterion.above:g} rad/s"
            return f"a driven wheel turns the way it is driven, faster than {fast}"
        case kinds.Stopped():
            return (
                f"no wheel that can be heard turns faster than {criterion.below:g} rad/s"
                f"{_lasting(criterion.for_s)}"
            )
        case kinds.Aligned():
            rolls = {slot.name: slot.roll or slot.name for slot in profile.slots}
            names = listed(rolls[name] for name in criterion.slots)
            return f"{names} is within {angle(criterion.within)} of its setpoint"
        case kinds.Below():
            return (
                f"{listed(criterion.signals)} are within {_quantity(criterion.limit)} of zero"
                f"{_lasting(criterion.for_s)}"
            )
    assert_never(criterion)


def angle(value_rad: float) -> str:
    """Return an angle in degrees."""
    return f"{round(degrees(value_rad), 3):g}°"


def seconds(value_s: float) -> str:
    """Return a time in seconds."""
    return f"{value_s:g} s"


def _joints(names: Sequence[str]) -> str:
    return f"{listed(names)} stand{'s' if len(names) == 1 else ''}"


def _bearing(criterion: kinds.Stalled) -> str:
    if criterion.loaded == criterion.joints:
        return "bears" if len(criterion.joints) == 1 else "each bear"
    return f"{listed(criterion.loaded)} {'bears' if len(criterion.loaded) == 1 else 'each bear'}"


def _load(criterion: kinds.Stalled) -> str:
    if criterion.share is None:
        return f"{criterion.torque:g} Nm"
    return f"{criterion.share * 100:g} % of what its motor gives at its duty"


def _settled(criterion: kinds.Stalled | kinds.Reached) -> str:
    if criterion.settled is None or criterion.at_least is None:
        return ""
    holds = " and what holds the robot there" if isinstance(criterion, kinds.Stalled) else ""
    return f", or more than {criterion.at_least:g} Nm{holds}{_lasting(criterion.settled)}"


def _or_stopped(criterion: kinds.Reached) -> str:
    if criterion.or_still is None:
        return _lasting(criterion.for_s)
    turned = f", once one of them has turned by {degrees(criterion.moved):.3g}°"
    moved = turned if criterion.moved else ""
    return (
        f", or is stopped by the wall: pushed with {criterion.loaded * 100:g} % of its stall torque"
        f" and slower than {_rate(criterion.or_still)}{_lasting(criterion.for_s)}"
        f"{_settled(criterion)}"
        f"{moved}"
    )


def _lasting(for_s: float) -> str:
    return f", for {seconds(for_s)}" if for_s else ""


def _rate(value: float) -> str:
    return f"{angle(value)}/s"


def _quantity(quantity: Quantity) -> str:
    if quantity.dimension == ANGLE:
        return angle(quantity.value)
    return format_quantity(quantity.value, quantity.dimension)
