"""Criteria of completed commands, with names resolved to indexes."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias


class AcceptedSpec(NamedTuple):
    """Done at acceptance."""


class StalledSpec(NamedTuple):
    """Joints stand still under torque; fields as in :class:`pirate_sm.model.criteria.Stalled`."""

    rates: tuple[int, ...]
    torques: tuple[int, ...]
    torque: float
    still: float
    for_s: float


class ReachedSpec(NamedTuple):
    """Every position loop has reached its angle, or its joint is pushed and stands still."""

    still: float
    loaded: float
    for_s: float


class TurningSpec(NamedTuple):
    """A driven wheel turns; ``wheels`` are pairs of slot and number index of its speed."""

    wheels: tuple[tuple[int, int], ...]
    above: float


class StoppedSpec(NamedTuple):
    """No reporting wheel turns; ``parts`` holds the number indexes of each part's speeds."""

    parts: tuple[tuple[int, ...], ...]
    below: float
    for_s: float


class AlignedSpec(NamedTuple):
    """Angles are at their setpoints; pairs of slot and number index.

    Attributes:
        slots: The pairs.
        within: The largest difference, rad.
        leaning: By how much the part that holds may turn sideways out of the pipe's axis, rad.
    """

    slots: tuple[tuple[int, int], ...]
    within: float
    leaning: float = 0.0


class BelowSpec(NamedTuple):
    """Signals are near zero."""

    signals: tuple[int, ...]
    limit: float
    for_s: float


CriterionSpec: TypeAlias = (
    AcceptedSpec | StalledSpec | ReachedSpec | TurningSpec | StoppedSpec | AlignedSpec | BelowSpec
)
