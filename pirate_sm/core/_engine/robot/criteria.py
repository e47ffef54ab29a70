"""What shows that something is so: criteria of commands and of declared states, and evidence.

Names in criteria are resolved to indexes. Evidence is the source, the time and the connection. That
of a signal of a board is the board's last report; nothing is stored for it. Only what outlives a
report has evidence of its own. The age is computed when somebody asks for it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, isnan, nan
from typing import Literal, NamedTuple, TypeAlias

# --- commands that are done -------------------------------------------------------------------


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


# --- declared states --------------------------------------------------------------------------


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


# --- evidence ---------------------------------------------------------------------------------


Source: TypeAlias = Literal["sensor", "echo", "person", "assumption", "nothing"]
"""What has shown something. An echo shows that an array has arrived, never what it has moved."""


SHOWN: Mapping[Source, str] = {
    "sensor": "shown by sensors",
    "echo": "setpoints confirmed",
    "person": "declared",
    "assumption": "assumed",
    "nothing": "shown by nothing",
}
"""How each source has shown something, for people."""


class Evidence(NamedTuple):
    """The evidence of one state, signal or place.

    Attributes:
        at_s: When it was shown, by the engine's clock; NaN if nothing has shown it.
        connection: In which connection, see :attr:`.Sensing.connection`.
    """

    source: Source
    at_s: float
    connection: int

    def age_s(self, now_s: float) -> float:
        """Return how old it is, s; NaN if nothing has shown it."""
        return now_s - self.at_s

    def in_words(self, now_s: float) -> str:
        """Return it for people, with its age."""
        ago = "" if isnan(self.at_s) else f" {self.age_s(now_s):.1f} s ago"
        return f"{SHOWN[self.source]}{ago}"


NOTHING = Evidence("nothing", nan, 0)
"""Nothing has shown it."""
