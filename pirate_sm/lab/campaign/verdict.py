"""Judges a run by the truth: whether it passed, was held, was safe, or said falsely so."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.core.campaign import TrueEnd
from pirate_sm.lab.campaign.watched_run import Outcome

GRIPPED_NM = 0.1
"""A part whose joints bear less than this does not hold."""

STAYS_M = 0.005
"""A robot that is carried farther in two seconds after its mission does not hold."""

SHORT_M = 0.015
"""So far a wheel may be short of the place that the detector's last word means."""

HUNG_S = 3600.0
"""A run that takes longer does not end by itself."""

FALSE = "said to have succeeded"

What: TypeAlias = Literal["passed", "failed", "false", "bug"]


class RunVerdict(NamedTuple):
    """How a run ended, by the truth.

    Attributes:
        what: ``passed``; ``failed``: the mission says so; ``false``: the mission says it has
            succeeded and the robot has not; ``bug``: this program raised an exception.
        why: Why it did not pass; empty if it did.
        held: Whether it passed, or failed with the robot held in the pipe.
        unsafe: The rules of safety that it broke; empty for none.
    """

    what: What
    why: str
    held: bool
    unsafe: str


def judge(outcome: Outcome, end: TrueEnd) -> RunVerdict:
    """Return how a run ended, by what is true of the robot.

    Args:
        outcome: The run.
        end: What must be true when its mission has succeeded.
    """
    unsafe = ", ".join(_broken(outcome))
    if outcome.outcome != "succeeded":
        held = holds(outcome)
        return RunVerdict("failed", outcome.message, held, unsafe)
    contradiction = _contradiction(outcome, end)
    if contradiction:
        return RunVerdict("false", f"{FALSE}, {contradiction}", False, unsafe)
    return RunVerdict("passed", "", True, unsafe)


def holds(outcome: Outcome) -> bool:
    """Return whether the robot stands in the pipe, with a clamp that bears."""
    gripped = _torque_nm(outcome) >= GRIPPED_NM
    stays = outcome.slid_m <= STAYS_M and not outcome.gone
    return outcome.held_at_end and gripped and outcome.stopped and stays


def _torque_nm(outcome: Outcome) -> float:
    return max(map(abs, outcome.torques), default=0.0)


def _contradiction(outcome: Outcome, end: TrueEnd) -> str:
    """Return what is true and contradicts a success; empty if nothing does."""
    arcs_m = outcome.arcs_m
    if outcome.gone:
        return "and the robot has left the pipe"
    if end.beyond is not None and (short := sum(arc <= end.beyond for arc in arcs_m)):
        return f"with {short} wheels not beyond {end.beyond * 1000:g} mm"
    if end.before is not None and (far := sum(arc >= end.before for arc in arcs_m)):
        return f"with {far} wheels not before {end.before * 1000:g} mm"
    if list(arcs_m) != sorted(arcs_m, reverse=True):
        return "with a part folded back on itself"
    if end.at_word and not outcome.short_m <= SHORT_M:
        return f"with a wheel {outcome.short_m * 1000:.0f} mm short of where the last word says"
    missing = _missing(outcome.states, end.states)
    return f"and {missing} of its states did not appear in order" if missing else ""


def _missing(states: Iterable[tuple[str, ...]], wanted: Sequence[tuple[str, ...]]) -> int:
    """Return how many states are left when those of a run have been walked through once."""
    left = list(wanted)
    for state in states:
        if left and state == left[0]:
            left.pop(0)
    return len(left)


def _broken(outcome: Outcome) -> Iterable[str]:
    """Yield the rules of safety that a run broke."""
    if outcome.time_s > HUNG_S:
        yield "did not end by itself"
    if not outcome.stopped:
        yield "wheels not stopped"
    if outcome.gone:
        yield "left the pipe"
    elif outcome.held_before and not outcome.held_at_end:
        yield "let go: no part is held at the end"
    elif outcome.held_before and _torque_nm(outcome) < GRIPPED_NM:
        yield "let go: no joint bears a torque at the end"
