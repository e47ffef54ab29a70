"""How a run ended, and its exit code."""

from __future__ import annotations

from typing import NamedTuple

from pirate_sm.core.effects import Ended
from pirate_sm.running.runtime.stop_requests import OUTPUT_LOST, Stop

SUCCEEDED, FAILED, BACKEND, BUG, RECORDING_LOST, INTERRUPTED = 0, 1, 3, 4, 5, 130

LINK_FAMILIES = ("backend", "link", "runner")
"""Families of fault codes about the link to the robot, not the robot itself."""


class Result(NamedTuple):
    """The end of a run.

    Attributes:
        ended: The effect that ended the run.
        exit_code: 0 succeeded, 1 mission failed (also by a fault of the robot), 3 backend or link
            fault, 4 an internal error, 129, 130, 141 and 143 stopped from outside.
        now_s: Mission time, s.
        error: The exception that ended the run, if any.
    """

    ended: Ended
    exit_code: int
    now_s: float
    error: BaseException | None = None


def exit_code(ended: Ended, fault: str, stop: Stop | None, output_lost: bool) -> int:
    """Return the exit code of a run that the engine has ended.

    Args:
        ended: How it ended.
        fault: Code of the last fault without a handler; empty if none.
        stop: The request to stop, if any.
        output_lost: Whether its output could not be written.
    """
    if ended.outcome == "interrupted":
        return stop.exit_code if stop else FAILED  # a trace that would never end
    if ended.outcome == "fault":
        return BACKEND if fault.partition(".")[0] in LINK_FAMILIES else FAILED
    if ended.outcome == "failed":
        return FAILED
    return OUTPUT_LOST if output_lost else SUCCEEDED
