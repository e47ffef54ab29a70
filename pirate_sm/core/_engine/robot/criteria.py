"""Criteria: what shows that a command is done, and the signs that show states and held parts.

A criterion is a list of demands, which the loader makes of the kinds that a profile has
(``core/_loading/robot/criteria.py``); nothing here knows these kinds. Under the active
setpoints and loops a demand becomes needs: bounds of single signals. A bound can be tested, be a
condition for frames that pass unseen, and be a limit in words.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from math import copysign, inf, isnan
from typing import Literal, NamedTuple, TypeAlias, TypeVar

from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.loops import Loops, RunningPositionLoop, RunningTorqueLoop
from pirate_sm.core._expressions import tree

# --- bounds of signals ------------------------------------------------------------------------


class Bound(NamedTuple):
    """What a criterion asks of one signal; of an unknown one nothing is true.

    Attributes:
        signal: Its number index.
        operator: How its size compares with ``limit``.
        limit: The number that its size is compared with.
        target: The value from which its size is the distance, whatever the side.
        way: 1.0 or -1.0: its size is its value in this direction instead.
        or_unknown: Whether an unknown signal counts too.
    """

    signal: int
    operator: Literal["<", "<=", ">"]
    limit: float
    target: float = 0.0
    way: float = 0.0
    or_unknown: bool = False

    def holds(self, numbers: Numbers) -> bool:
        """Return whether it is true of these numbers."""
        value = numbers[self.signal]
        size = value * self.way if self.way else abs(self.target - value)
        if self.operator == ">":
            return size > self.limit
        holds = size < self.limit if self.operator == "<" else size <= self.limit
        return holds or (self.or_unknown and isnan(value))

    @property
    def condition(self) -> tree.Node:
        """Return it as a condition."""
        signal: tree.Node = tree.Signal("", "number", self.signal)
        if self.way:
            size = signal if self.way > 0 else tree.Negate(signal)
        else:
            off = tree.Arithmetic("-", tree.Number(self.target), signal) if self.target else signal
            size = tree.Call("abs", (off,))
        bound = tree.Compare(self.operator, size, tree.Number(self.limit))
        return tree.Or((tree.Not(tree.Known(signal)), bound)) if self.or_unknown else bound

    @property
    def limits(self) -> tuple[float, float, bool]:
        """Return the least and the largest value, and whether these are of the magnitude."""
        if self.way:
            return (self.limit, inf, False) if self.way > 0 else (-inf, -self.limit, False)
        if self.operator == ">":
            return self.limit, inf, True
        return self.target - self.limit, self.target + self.limit, False


def near(signal: int, target: float, within: float) -> Bound:
    """Return the bound that a signal is at most this far from a value."""
    return Bound(signal, "<=", within, target)


def arrived(loop: RunningPositionLoop) -> Bound:
    """Return the bound that the loop's joint is at its angle."""
    return near(loop.angle, loop.target_rad, loop.spec.threshold_rad)


class Need(NamedTuple):
    """One of the things that a criterion needs, all of which must be true.

    It is itself a demand that depends on no setpoint.

    Attributes:
        ways: The ways in which it is true: in each all of its bounds hold.
        lacking: The bounds that it lacks where it is not true.
    """

    ways: tuple[tuple[Bound, ...], ...]
    lacking: tuple[Bound, ...]

    def holds(self, numbers: Numbers) -> bool:
        """Return whether it is true of these numbers."""
        for way in self.ways:  # loops, since this is asked with each frame
            for bound in way:
                if not bound.holds(numbers):
                    break
            else:
                return True
        return False

    @property
    def condition(self) -> tree.Node:
        """Return it as a condition."""
        return tree.Or(tuple(tree.And(tuple(each.condition for each in way)) for way in self.ways))

    def unheard(self, heard: frozenset[int]) -> tuple[int, ...]:
        """Return signals that keep it from ever being true, if no others are known than these."""
        missing = [
            tuple(each.signal for each in way if each.signal not in heard and not each.or_unknown)
            for way in self.ways
        ]
        return missing[0] if missing and all(missing) else ()

    def needs(self, _: Numbers, __: Loops) -> tuple[Need, ...]:
        """Return itself: it is the same under all setpoints."""
        return (self,)


def only(bound: Bound) -> Need:
    """Return the need that a bound holds."""
    return Need(((bound,),), (bound,))


def standing(speeds: tuple[int, ...], below: float) -> tuple[Need, ...]:
    """Return the needs that no wheel turns whose speed is known, and that of one it is."""
    slow = tuple(Bound(each, "<", below, or_unknown=True) for each in speeds)
    known = tuple((Bound(each, ">", -1.0),) for each in speeds)  # any number will do
    return Need(known, slow), *map(only, slow)


# --- demands that depend on the active setpoints and loops ------------------------------------


class TorqueBorne(NamedTuple):
    """A joint bears a torque; that of its torque loop, if it has one.

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

    def needs(self, setpoints: Numbers, loops: Loops) -> tuple[Need, ...]:
        """Return what is needed of the torque."""
        for loop in loops:
            if isinstance(loop, RunningTorqueLoop) and loop.spec.torque == self.torque:
                asked = near(self.torque, loop.target_nm, loop.spec.within_nm)
                return (only(asked),) if loop.target_nm else ()
        needed_nm = max(self.full_nm * abs(setpoints[self.slot]), self.least_nm)
        return (only(Bound(self.torque, ">", needed_nm)),)

    def weakened(self, least_nm: float) -> TorqueBorne:
        """Return the demand for this torque, whatever the duty is."""
        return self._replace(full_nm=0.0, least_nm=least_nm)


class JointsArrived(NamedTuple):
    """Every position loop has reached its angle, or its joint is pushed and stands still.

    Attributes:
        still: The speed below which a pushed joint stands still.
        loaded: Share of the stall torque at its duty that a pushed joint bears.
        moved_rad: How far a joint must have turned before the wall can have stopped them.
        least_nm: The smallest torque of a pushed joint.
    """

    still: float
    loaded: float
    moved_rad: float = 0.0
    least_nm: float = 0.0

    def needs(self, setpoints: Numbers, loops: Loops) -> tuple[Need, ...]:
        """Return what is needed of each joint."""
        seekers = (loop for loop in loops if isinstance(loop, RunningPositionLoop))
        return tuple(self._need(setpoints[loop.slot], loop) for loop in seekers)

    def _need(self, duty: float, loop: RunningPositionLoop) -> Need:
        there = arrived(loop)
        if duty == 0:
            return only(there)
        pushed_nm = loop.pushed_nm(duty, self.loaded, self.least_nm)
        pushed = Bound(loop.torque, ">", pushed_nm, way=copysign(1.0, duty))
        return Need(((there,), (Bound(loop.rate, "<", self.still), pushed)), (there,))

    def weakened(self, least_nm: float) -> JointsArrived:
        """Return the demand that a pushed joint bears this torque, whatever its duty is."""
        return self._replace(loaded=0.0, least_nm=least_nm)


class WheelTurning(NamedTuple):
    """A driven wheel turns; ``wheels`` are pairs of slot and number index of its speed."""

    wheels: tuple[tuple[int, int], ...]
    above: float

    def needs(self, setpoints: Numbers, _: Loops) -> tuple[Need, ...]:
        """Return the need that one of the driven wheels turns the way it is driven."""
        ways = [(speed, setpoints[slot]) for slot, speed in self.wheels if setpoints[slot]]
        bounds = tuple(
            Bound(speed, ">", self.above, way=copysign(1.0, way))
            for speed, way in ways or [(speed, 1.0) for _, speed in self.wheels]
        )
        return (Need(tuple((each,) for each in bounds) if ways else (), bounds),)


class AngleSet(NamedTuple):
    """The angle of a slot is at its setpoint.

    Attributes:
        slot: The slot.
        angle: Number index of the angle.
        within: The largest difference, rad.
        leaning: By how much the part that holds may turn sideways out of the pipe's axis, rad.
    """

    slot: int
    angle: int
    within: float
    leaning: float = 0.0

    def needs(self, setpoints: Numbers, _: Loops) -> tuple[Need, ...]:
        """Return the need that the angle is near the active setpoint."""
        return (only(near(self.angle, setpoints[self.slot], self.within)),)


Demand: TypeAlias = Need | TorqueBorne | JointsArrived | WheelTurning | AngleSet

_Kind = TypeVar("_Kind", bound=Demand)


# --- criteria ---------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class CriterionSpec:
    """What shows that a command is done; compared by identity, since it is looked up by it.

    Attributes:
        kind: The word of the profile for it.
        shown: What shows that a command is done, in words.
        lacking: What a command that is not done lacks, in words.
        demands: What must all be true; where nothing is, accepted setpoints are enough.
        for_s: For how long.
        settled: What counts as well once it has held for longer; None: nothing.
    """

    kind: str
    shown: str
    lacking: str
    demands: tuple[Demand, ...] = ()
    for_s: float = 0.0
    settled: CriterionSpec | None = None

    def asked(self, what: type[_Kind]) -> tuple[_Kind, ...]:
        """Return its demands of one kind."""
        return tuple([each for each in self.demands if isinstance(each, what)])

    def holds(self, numbers: Numbers, setpoints: Numbers, loops: Loops) -> bool:
        """Whether it is true of this moment."""
        return all(need.holds(numbers) for need in needs(self, setpoints, loops))

    def lacks(self, numbers: Numbers, setpoints: Numbers, loops: Loops) -> list[Bound]:
        """Return the bounds because of which it is not true."""
        unmet = (each for each in needs(self, setpoints, loops) if not each.holds(numbers))
        return [bound for need in unmet for bound in need.lacking]

    def condition(self, setpoints: Numbers, loops: Loops) -> tree.Node:
        """Return it as a condition on the signals."""
        parts = tuple(need.condition for need in needs(self, setpoints, loops))
        return tree.And(parts) if parts else tree.TruthValue(True)

    def must_hold_s(self, numbers: Numbers, seekers: tuple[RunningPositionLoop, ...]) -> float:
        """Return for how long it must have been true: joints that are at their angles stay."""
        there = self.asked(JointsArrived) and all(loop.arrived(numbers) for loop in seekers)
        return 0.0 if there else self.for_s


@lru_cache(maxsize=1024)  # asked for with each frame
def needs(criterion: CriterionSpec, setpoints: Numbers, loops: Loops) -> tuple[Need, ...]:
    """Return what a criterion needs under these setpoints; what is unknown never makes it true."""
    return tuple(need for demand in criterion.demands for need in demand.needs(setpoints, loops))


def needs_of_signals(criterion: CriterionSpec, slots: int) -> tuple[Need, ...]:
    """Return what a criterion needs of signals, while each of so many slots has a setpoint."""
    return needs(criterion, (1.0,) * slots, ())


# --- signs of states and held parts -----------------------------------------------------------


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
