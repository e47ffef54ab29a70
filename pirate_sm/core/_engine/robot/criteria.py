"""Criteria of completed commands, with names resolved to indexes."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias


class AcceptedSpec(NamedTuple):
    """Done at acceptance."""


class LoadSpec(NamedTuple):
    """The torque that a joint must bear.

    Attributes:
        torque: Number index of the torque that it bears.
        slot: The slot of its motor.
        full_nm: The part of it that goes with the duty in force, at full duty.
        least_nm: The smallest that counts.
    """

    torque: int
    slot: int
    full_nm: float
    least_nm: float

    def needed_nm(self, setpoints: tuple[float, ...]) -> float:
        """Return the size of the torque by which it presses under these setpoints."""
        return max(self.full_nm * abs(setpoints[self.slot]), self.least_nm)


class StalledSpec(NamedTuple):
    """Joints stand still under torque; fields as in :class:`~pirate_sm.core.profile.Stalled`.

    Attributes:
        settled: What counts as well once it has held for longer; None: nothing.
    """

    rates: tuple[int, ...]
    loads: tuple[LoadSpec, ...]
    still: float
    for_s: float
    settled: StalledSpec | None = None


class ReachedSpec(NamedTuple):
    """Every position loop has reached its angle, or its joint is pushed and stands still.

    Attributes:
        loaded: Share of the stall torque at its duty that a pushed joint bears.
        least_nm: The smallest torque of a pushed joint.
        settled: What counts as well once it has held for longer; None: nothing.
        moved_rad: How far a joint must have turned before the wall can have stopped them.
    """

    still: float
    loaded: float
    for_s: float
    least_nm: float = 0.0
    settled: ReachedSpec | None = None
    moved_rad: float = 0.0


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


def settled_of(criterion: CriterionSpec) -> CriterionSpec | None:
    """Return what shows a command done as well, after a longer time; None where nothing does."""
    return criterion.settled if isinstance(criterion, StalledSpec | ReachedSpec) else None
