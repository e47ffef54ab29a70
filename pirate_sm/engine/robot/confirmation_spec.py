"""How a robot shows itself to its sensors before anything moves, with names resolved to indexes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from pirate_sm.engine.robot.criteria import AcceptedSpec


class LoadedJoint(NamedTuple):
    """A joint of a held part: its slot, number indexes of its torque and its rate."""

    slot: int
    torque: int
    rate: int


class HeldSpec(NamedTuple):
    """How a held part shows itself; limits as in :class:`pirate_sm.model.seen.HeldPart`.

    Attributes:
        diameter: Number index of the diameter that the part shows; ``apex`` of its apex angle.
        open_rad: From this angle of the apex on the part has opened to its end stop.
    """

    joints: tuple[LoadedJoint, ...]
    torque: float
    slack: float
    still: float
    diameter: int
    apex: int
    open_rad: float
    span: float
    span_off: float
    for_s: float


class AnglesSpec(NamedTuple):
    """Angles near their setpoints; ``targets`` are pairs of number index and angle."""

    targets: tuple[tuple[int, float], ...]
    within: float
    beyond: float
    for_s: float


class StandingSpec(NamedTuple):
    """Wheels that stand; ``speeds`` are number indexes."""

    speeds: tuple[int, ...]
    below: float
    for_s: float


class DrivenSpec(NamedTuple):
    """Wheels that do not turn against their setpoints; pairs of number index and direction."""

    wheels: tuple[tuple[int, float], ...]
    above: float
    for_s: float


class ImpliedSpec(NamedTuple):
    """Nothing that could be wrong."""


SeenSpec: TypeAlias = AnglesSpec | StandingSpec | DrivenSpec | ImpliedSpec | AcceptedSpec


@dataclass(frozen=True)
class Sight:
    """How the robot shows itself to its sensors before anything moves.

    Attributes:
        within_s: How long that is looked at, at most.
        parts: Per part, None where nothing shows that it is held.
        states: Per region and state; what is missing no sensor shows.
    """

    within_s: float = 0.0
    parts: tuple[HeldSpec | None, ...] = ()
    states: tuple[Mapping[str, SeenSpec], ...] = ()
