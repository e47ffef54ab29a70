"""The steps of the kinematic simulator, and how finely each is solved."""

from __future__ import annotations

from typing import NamedTuple

from pirate_sm.core.options import USUAL, Fidelity

STEP_S = 0.002


class Effort(NamedTuple):
    """What is done for the steps.

    Attributes:
        iterations: How often each step is solved again.
        look: For how many steps directions, and what touches what, are kept.
        pull: The iteration in which the springs of the joints first act, from 0. They are soft
            beside links and walls.
    """

    iterations: int
    look: int
    pull: int


EFFORTS: dict[Fidelity, Effort] = {USUAL: Effort(4, 1, 0), "fast": Effort(2, 4, 1)}
"""Two iterations are the fewest that may be had: with one, a bend from below takes 3.5 times as
long. What fast costs in accuracy is printed by `python -m benchmarks.fidelity`.
"""


def notice_of(fidelity: Fidelity) -> str:
    """Return what a person must know of a run with this fidelity; empty if nothing."""
    if fidelity == USUAL:
        return ""
    coarse, usual = EFFORTS[fidelity], EFFORTS[USUAL]
    return (
        f"{fidelity}: {coarse.iterations} of {usual.iterations} iterations in each step of the "
        f"simulator, a look at the walls in every {coarse.look}th; the documentation's page on it "
        "says what that costs"
    )
