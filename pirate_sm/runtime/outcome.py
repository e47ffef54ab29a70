"""How a run ended, and its exit code."""

from __future__ import annotations

from typing import NamedTuple

from pirate_sm.model.effects import Ended
from pirate_sm.runtime.stop_requests import OUTPUT_LOST, Stop

SUCCEEDED, FAILED, BACKEND, BUG, INTERRUPTED = 0, 1, 3, 4, 130

LINK_FAMILIES = ("backend", "link", "runner")
"""Families of fault codes that tell of the way to the robot and not of the robot itself."""


class Result(NamedTuple):
    """The end of a run.

    Attributes:
        ended: The last effect.
        exit_code: 0 succeeded, 1 mission failed (a fault of the robot ends it so too), 3 backend
            or link fault, 4 a fault in this program, 129, 130, 141 and 143 stopped from outside.
        now_s: Mission time.
        error: What broke, if something did.
    """

    ended: Ended
    exit_code: int
    now_s: float
    error: BaseException | None = None


def exit_code(ended: Ended, fault: str, stop: Stop | None, output_lost: bool) -> int:
    """Return the exit code of a run that came to its end through the engine.

    Args:
        ended: How it ended.
        fault: Code of the last fault that nothing handled; empty without one.
        stop: What asked it to stop.
        output_lost: Whether its words reached nobody.
    """
    if ended.outcome == "interrupted":
        return stop.exit_code if stop else FAILED  # a trace that would never end
    if ended.outcome == "fault":
        return BACKEND if fault.partition(".")[0] in LINK_FAMILIES else FAILED
    if ended.outcome == "failed":
        return FAILED
    return OUTPUT_LOST if output_lost else SUCCEEDED
