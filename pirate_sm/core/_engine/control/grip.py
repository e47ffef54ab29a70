"""How hard a clamped part must press for friction to bear the robot (thesis eq. 3-16 to 3-25)."""

from __future__ import annotations

from math import cos, isnan, nan, sin
from typing import NamedTuple

from pirate_sm.core._engine.control.circumstances import Circumstances
from pirate_sm.core._engine.robot.command_spec import GripSpec
from pirate_sm.core._geometry.clamping import HELD_SAFETY

LEAST_MARGIN = HELD_SAFETY
"""With less than this factor between what friction can bear and the weight the grip is exhausted,
while the part presses as hard as it may [decided]."""

LEAST_FRICTION = 1e-3
"""Less than any wall has: an estimate of zero asks for more torque than there is."""


class Gripping(NamedTuple):
    """What is remembered of the grip of a part.

    Attributes:
        torque_nm: Size of the torque that is asked of the apex.
        friction: The friction that was last known; NaN before it ever was.
        since_s: When the torque was last set.
        exhausted: Whether friction may not bear the robot although the part presses all it may.
    """

    torque_nm: float
    friction: float = nan
    since_s: float = nan
    exhausted: bool = False


def gripping(spec: GripSpec) -> Gripping:
    """Return the grip at first: as hard as it may be, until friction and tilt are known."""
    return Gripping(spec.at_most_nm, spec.friction)


def after_frame(
    spec: GripSpec, before: Gripping, seen: Circumstances, *, presses: bool = False
) -> Gripping:
    """Return the grip after a fresh frame.

    It is raised at once, also when a wheel slips, and lowered slowly.

    Args:
        spec: How hard the part presses.
        before: The grip before the frame.
        seen: The signals with the frame in them.
        presses: Whether the apex bears all that it may.
    """
    numbers = seen.numbers
    known = [numbers[index] for index in spec.estimates if not isnan(numbers[index])]
    friction = min(known, default=before.friction) if isnan(spec.friction) else spec.friction
    needed_nm = torque_nm(spec, friction, numbers[spec.angle], seen.pitch_rad)
    wanted_nm = spec.at_most_nm if isnan(needed_nm) else min(needed_nm, spec.at_most_nm)
    if any(abs(numbers[index]) > spec.alarm_m_s for index in spec.slip_speeds):
        wanted_nm = spec.at_most_nm
    elapsed_s = 0.0 if isnan(before.since_s) else seen.now_s - before.since_s
    lowered_nm = before.torque_nm - spec.lower_nm_s * elapsed_s
    size_nm = max(wanted_nm, spec.at_least_nm, lowered_nm)
    exhausted = needed_nm * LEAST_MARGIN / spec.safety > spec.at_most_nm
    return Gripping(size_nm, friction, seen.now_s, exhausted or (presses and _carried(spec, seen)))


def _carried(spec: GripSpec, seen: Circumstances) -> bool:
    """Return whether all wheels of the part are carried downhill, beyond what they roll.

    However little is known of the friction, it does not bear the robot then. While the tilt is
    unknown it is enough that the robot moves beyond what they roll.
    """
    numbers, downhill = seen.numbers, sin(seen.pitch_rad)
    slips = [numbers[index] for index in spec.slip_speeds]
    return bool(slips) and all(
        abs(slip) > spec.alarm_m_s and slip * numbers[spec.speed] < 0 and not downhill * slip <= 0
        for slip in slips
    )


def torque_nm(spec: GripSpec, friction: float, angle_rad: float, pitch_rad: float) -> float:
    """Return the size of the torque at the apex that holds the robot; NaN where it is unknown.

    A part's wheels press with N_d = safety * m g |sin| / (wheels * friction) beside the share of
    the weight that lies across the pipe; an apex with torque tau presses its wheels by 2 tau
    divided by the length of a leg along the pipe (eq. 3-16 and 3-25).
    """
    reach_m = spec.leg_m * cos(angle_rad / 2)
    along_n = spec.safety * spec.weight_n * abs(sin(pitch_rad)) / spec.wheels
    across_n = spec.weight_n * abs(cos(pitch_rad)) / spec.wheels
    return spec.share * 0.5 * reach_m * (across_n + along_n / max(friction, LEAST_FRICTION))
