"""The signs by which sensors confirm or contradict states and held parts, with names as indexes.

The loader makes them of the profile's ``seen`` (``core/_loading/robot/seen_states.py``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Literal, NamedTuple

from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.done_criteria import Bound, Need

OF_WHEELS = ("stopped", "turning")
"""The kinds of states that show whether wheels stand or are driven."""


class Sign(NamedTuple):
    """What one signal shows of a state.

    Attributes:
        bound: What nothing contradicts that keeps to it, or is unknown.
        unit: The unit in which it is shown.
        otherwise: What is said after a value that contradicts the state.
        limit: The limits, in tables.
    """

    bound: Bound
    unit: Literal["deg", "rad/s"]
    otherwise: str
    limit: str

    def contradicts(self, numbers: Numbers) -> bool:
        """Return whether the signal contradicts the state."""
        return not self.bound.holds(numbers)


class SeenSpec(NamedTuple):
    """How a state shows itself.

    Attributes:
        kind: The word of the profile for it.
        needs: What confirms it; None: no sensor does.
        signs: What contradicts it.
        for_s: How long either must last.
    """

    kind: str
    needs: tuple[Need, ...] | None = None
    signs: tuple[Sign, ...] = ()
    for_s: float = 0.0


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
    """Criterion of a held part; limits as in ``HeldPart`` of the profile.

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


class DarkSpec(NamedTuple):
    """What may have changed while nothing was recorded; limits as in the profile.

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
