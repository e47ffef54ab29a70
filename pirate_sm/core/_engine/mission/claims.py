"""What a mission claims by a distance, and whether the bound of the distance bears it."""

from __future__ import annotations

from math import ceil, inf, isnan

from pirate_sm.core._engine.mission.diverting import meet
from pirate_sm.core._engine.mission.program import DRIVEN, TriggerSpec
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.safety.faults import FoundFault
from pirate_sm.core._engine.sensing.distance import BASE_M
from pirate_sm.core._engine.state import OUTSIDE, Counted, EngineState
from pirate_sm.core._expressions.vocabulary import change_of
from pirate_sm.core._model.fault_codes import BuiltInFault

_LEAST_M, _SHARE = 0.020, 0.25
"""A success by a distance needs a bound of at most this share of what was driven for it, and never
less than the first [decided]. A mission asks for more by ``known within``."""


def counted(moment: Moment, state: EngineState) -> Counted:
    """Return the distance as it is now, from which later ones can count."""
    at, memory = moment.robot.odometry, state.sensing.distance
    odometry_m = state.sensing.numbers[at] if at >= 0 else 0.0
    late_m = max(0.0, memory.late_m - BASE_M)
    return Counted(odometry_m, memory.width_m, memory.rolled_m, late_m)


def claim_of(moment: Moment, state: EngineState, trigger: TriggerSpec) -> Counted | None:
    """Return from where the distance counts that the mission claims after this trigger has fired.

    None where it claims none: a word of the detector says anew where the robot is. What else a
    trigger has asked for leaves the claim of before.
    """
    robot, names = moment.robot, trigger.condition.names if trigger.condition else frozenset()
    odometry = robot.vocabulary.numbers[robot.odometry] if robot.odometry >= 0 else ""
    if change_of(odometry) in names:
        return state.mission.counts_from
    if odometry in names:
        return Counted()
    return None if OUTSIDE[0] in names else state.mission.claim


def met_unknown(moment: Moment, state: EngineState, within_m: float = inf) -> EngineState | None:
    """Return the state after the fault that the bound is too wide for what the mission claims.

    None where it is not, and where the mission continues in spite of the fault.

    Args:
        moment: The time, the robot and program, and the effects so far.
        state: The state.
        within_m: The bound that the mission asks for.
    """
    claim, bounded = state.mission.claim, state.sensing.distance.every_s > 0.0
    if claim is None or not bounded:  # a trace, or a recording of before
        return None
    way_m, bound_m, limit_m = _driven(moment, state, claim)
    limit_m = min(within_m, limit_m)
    if bound_m <= limit_m:
        return None
    message = f"the wheels show {way_m * 1000:.0f} mm, but the robot may be {bound_m * 1000:.0f} mm"
    message += f" from there; this must be known within {limit_m * 1000:.0f} mm"
    met = meet(moment, state, FoundFault.built_in(BuiltInFault.DISTANCE_UNKNOWN, message))
    return None if met.mission is state.mission else met


def with_measured(moment: Moment, state: EngineState, text: str, no_cause: str = "") -> str:
    """Return a text of the mission, with the last cause and what it has driven as measured.

    What was asked for is not what was measured: a brake that comes late adds to the way.
    """
    text = text.replace("{cause}", state.mission.cause or no_cause)
    if DRIVEN not in text:
        return text
    since = state.mission.claim or state.mission.counts_from
    way_m, bound_m, limit_m = _driven(moment, state, since)
    bounded = state.sensing.distance.every_s > 0.0
    driven = f"{way_m * 1000:z.0f} ± {ceil(bound_m * 1000)} mm" if bounded else ""
    if isnan(way_m) or (bounded and bound_m > limit_m):
        driven = "an unknown distance"
    return text.replace(DRIVEN, driven or f"{way_m * 1000:z.0f} mm")


def _driven(moment: Moment, state: EngineState, since: Counted) -> tuple[float, float, float]:
    """Return the distance driven since then, its bound, and the largest bound of a success, m."""
    now = counted(moment, state)
    limit_m = max(_LEAST_M, _SHARE * (now.rolled_m - since.rolled_m))
    bound_m = state.sensing.distance.bound_m - since.width_m + since.late_m
    return now.odometry_m - since.odometry_m, bound_m, limit_m
