"""Criteria by which sensors confirm declared states at the start, with names as indexes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import NamedTuple, TypeAlias

from pirate_sm.core._engine.robot.criteria import AcceptedSpec


class LoadedJoint(NamedTuple):
    """A joint of a held part: its slot, and the number indexes of its torque and rate.

    Attributes:
        needed_nm: The torque that it bears while its part holds.
        least_nm: The smallest torque with which it may, if it stands still for longer.
    """

    slot: int
    torque: int
    rate: int
    needed_nm: float
    least_nm: float


class HeldSpec(NamedTuple):
    """Criterion of a held part; limits as in :class:`pirate_sm.core._model.seen.HeldPart`.

    Attributes:
        settled_s: How long a part must stand still whose joints bear less than they should,
            but ``least_nm``; infinite where that does not count.
        diameter: Number index of the part's diameter; ``apex``: of its apex angle.
        open_rad: Apex angle from which the part counts as open to its end stop.
    """

    joints: tuple[LoadedJoint, ...]
    slack: float
    still: float
    diameter: int
    apex: int
    open_rad: float
    span: float
    span_off: float
    for_s: float
    settled_s: float = inf


class AnglesSpec(NamedTuple):
    """Angles are near their setpoints; ``targets`` are pairs of number index and angle."""

    targets: tuple[tuple[int, float], ...]
    within: float
    beyond: float
    for_s: float


class StandingSpec(NamedTuple):
    """Wheels stand still; ``speeds`` are number indexes."""

    speeds: tuple[int, ...]
    below: float
    for_s: float


class DrivenSpec(NamedTuple):
    """Wheels do not turn against their setpoints; pairs of number index and direction."""

    wheels: tuple[tuple[int, float], ...]
    above: float
    for_s: float


class ImpliedSpec(NamedTuple):
    """The state adds no condition of its own."""


SeenSpec: TypeAlias = AnglesSpec | StandingSpec | DrivenSpec | ImpliedSpec | AcceptedSpec


class DarkSpec(NamedTuple):
    """What may have changed while nobody recorded; limits as in :class:`~pirate_sm.core.profile`.

    Attributes:
        absolute: Places of the wheels whose angle is absolute.
        top_m_s: Largest speed of a driven wheel's rim.
    """

    absolute: frozenset[int] = frozenset()
    top_m_s: float = inf
    agree_m: float = 0.0
    tilt_rad: float = inf
    joint_rad: float = inf


@dataclass(frozen=True)
class Sight:
    """All criteria by which sensors confirm declared states at the start.

    Attributes:
        within_s: Longest duration of the comparison.
        parts: Per part; None where no sensor can show that it is held.
        states: Per region and state; no sensor can show a state that is missing here.
        dark: What is compared besides when a run that was cut off is resumed.
    """

    within_s: float = 0.0
    parts: tuple[HeldSpec | None, ...] = ()
    states: tuple[Mapping[str, SeenSpec], ...] = ()
    dark: DarkSpec = field(default_factory=DarkSpec)
