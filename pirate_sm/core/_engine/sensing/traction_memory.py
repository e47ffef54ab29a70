"""What is remembered of the wheels' traction from frame to frame."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

from pirate_sm.core._engine.sensing.slip import Stretch
from pirate_sm.core._engine.sensing.traction_spec import TractionSpec


class Slipping(NamedTuple):
    """What is remembered of a wheel that slips.

    Attributes:
        since_s: Since when it slips the way that it is driven; infinite while it does not.
        seen_s: When it was last seen to do so.
        force_normal: Sum of force times normal force, N^2.
        normal_squared: Sum of the squared normal force, N^2.
    """

    since_s: float = inf
    seen_s: float = -inf
    force_normal: float = 0.0
    normal_squared: float = 0.0


class Traction(NamedTuple):
    """What is remembered of the wheels' traction.

    Attributes:
        slipping: Per wheel.
        rims: Per wheel the speeds of its rim lately, from frame to frame.
        readings: The speeds of the body that were measured outside lately.
    """

    slipping: tuple[Slipping, ...] = ()
    rims: tuple[tuple[Stretch, ...], ...] = ()
    readings: tuple[Stretch, ...] = ()


def nothing_estimated(spec: TractionSpec | None) -> Traction:
    """Return what is known before the first frame."""
    if spec is None:
        return Traction()
    return Traction((Slipping(),) * len(spec.wheels), ((),) * len(spec.wheels))
