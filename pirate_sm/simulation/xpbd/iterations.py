"""The steps of the kinematic simulator, and how often each is solved again."""

from __future__ import annotations

from pirate_sm.model.fidelity import USUAL, Fidelity

STEP_S = 0.002

ITERATIONS: dict[Fidelity, int] = {USUAL: 4, "fast": 2}
"""Iterations of each step.

Two of them are the coarsest that may be had: steps of 4 ms leave the end of a climb 12 mm off, and
with two iterations they fail in a bend [measured with a prototype of the planar kernel]. What two
cost in steps of 2 ms is printed by `python -m benchmarks.fidelity`.
"""


def notice_of(fidelity: Fidelity) -> str:
    """Return what a person must know of a run with this fidelity; empty if nothing."""
    if fidelity == USUAL:
        return ""
    return (
        f"{fidelity}: {ITERATIONS[fidelity]} of {ITERATIONS[USUAL]} iterations in each step of the "
        "simulator; the documentation's page on it says what that costs"
    )
