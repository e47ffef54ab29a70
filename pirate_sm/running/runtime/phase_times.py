"""How long phases took in earlier runs, and what this says about a run that is under way.

All bands are bounds by order statistics, which assume no distribution: of ``n`` earlier times and
one more of the same kind, each order is equally likely. So the next time lies between the k-th
smallest and the k-th largest with probability (n + 1 - 2 k) / (n + 1).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from functools import cached_property
from math import inf
from typing import NamedTuple, TypeAlias

from pirate_sm.core.companion import CompanionBase
from pirate_sm.core.effects import Effect, Ended, Log, PhaseChange, WaitArmed
from pirate_sm.core.engine import EngineState
from pirate_sm.core.robot import RobotSpec

_IN_20, _IN_100 = 20, 100
"""A band leaves out one time in twenty on each side, so it holds 90 %; a phase is slow where one
in a hundred took longer [decided]."""

LEAST_RUNS = _IN_20 - 1
"""With fewer runs not even the least and the largest time are a band of 90 %."""

_WITHIN_S = 0.02
"""Times count as equal within a cycle of the robot's bus and the rounding of the file [decided]."""

_LOOK_S = 0.5
"""How often a run is looked at; so late it may be noticed that a phase is slow [decided]."""

WORTH_SAYING_S = 1.0
"""Phases that never take so long are not mentioned [decided]."""

Visit: TypeAlias = tuple[str, float]
"""A phase, and how long a run was in it, s."""


class PhaseKey(NamedTuple):
    """A phase, and how many times the run has entered it."""

    phase: str
    nth: int

    @property
    def words(self) -> str:
        """Return it in words."""
        return self.phase if self.nth == 1 else f"{self.phase} (time {self.nth})"


class PhaseStay(NamedTuple):
    """A phase of a run, when it was entered and when it was left, s."""

    key: PhaseKey
    since_s: float
    until_s: float


class PhaseVisits:
    """The phases that a run has entered, in order, from its effects.

    Attributes:
        passed: Those that it has left.
        key: The one that it is in; None before the first and after the end.
        since_s: When it entered that one.
        ended: How the run ended; None before.
    """

    def __init__(self) -> None:
        self.passed: list[PhaseStay] = []
        self.key: PhaseKey | None = None
        self.since_s = 0.0
        self.ended: Ended | None = None
        self._entered = Counter[str]()

    def see(self, effects: Iterable[Effect], now_s: float) -> bool:
        """Take in the effects of a step; return whether a phase was entered or left."""
        before = sum(self._entered.values()), self.key
        for effect in effects:
            match effect:
                case PhaseChange(phase):
                    self._enter(phase, now_s)
                case WaitArmed(phase) if self.key is None or self.key.phase != phase:
                    self._enter(phase, now_s)  # back from a mission that it called
                case Ended():
                    self._leave(now_s)
                    self.ended = effect
                case _:
                    pass
        return before != (sum(self._entered.values()), self.key)

    def _enter(self, phase: str, now_s: float) -> None:
        self._leave(now_s)
        self._entered[phase] += 1
        self.key, self.since_s = PhaseKey(phase, self._entered[phase]), now_s

    def _leave(self, now_s: float) -> None:
        if self.key is not None:
            self.passed.append(PhaseStay(self.key, self.since_s, now_s))
        self.key = None

    @property
    def visits(self) -> list[Visit]:
        """Return those that it has left, with how long it was in them."""
        return [(key.phase, until_s - since_s) for key, since_s, until_s in self.passed]

    def until(self, now_s: float) -> tuple[PhaseStay, ...]:
        """Return all that it has entered; it is in the current one until now."""
        current = () if self.key is None else (PhaseStay(self.key, self.since_s, now_s),)
        return (*self.passed, *current)


class Band(NamedTuple):
    """Between which times the next one lies with a probability of at least 90 %.

    Attributes:
        runs: How many earlier times it is made of.
    """

    low_s: float
    high_s: float
    runs: int

    @property
    def words(self) -> str:
        """Return it in words."""
        return f"{self.low_s:.1f} to {self.high_s:.1f} s"


def rank_of_bounds(runs: int) -> int:
    """Return which smallest and which largest of earlier values bound the next one; 0: too few."""
    return (runs + 1) // _IN_20


def band_of(times_s: Iterable[float]) -> Band | None:
    """Return the band of the next time after these; None if they are fewer than ``LEAST_RUNS``."""
    ordered = sorted(times_s)
    runs = len(ordered)
    rank = rank_of_bounds(runs)
    return Band(ordered[rank - 1], ordered[-rank], runs) if rank else None


class SlowLimit(NamedTuple):
    """The time that a phase exceeds in at most one run of a hundred, or of ``runs`` + 1.

    Attributes:
        faster: How many of the runs did not take longer.
    """

    limit_s: float
    faster: int
    runs: int


class _Earlier(NamedTuple):
    """A phase in an earlier run: how long it took, and how long the run went on after it."""

    took_s: float
    rest_s: float


class EarlierRuns:
    """What earlier runs say about the times of the next one.

    It knows no clock: how long the run has been where is an argument.

    Args:
        runs: The phases of each run that succeeded, in order, with their times.
        backend: What they ran on.
    """

    def __init__(self, runs: Sequence[Sequence[Visit]], backend: str) -> None:
        self.runs, self._backend = runs, backend
        self.whole = band_of(sum(took_s for _, took_s in run) for run in runs)

    @cached_property
    def _passages(self) -> dict[PhaseKey, list[_Earlier]]:
        found: dict[PhaseKey, list[_Earlier]] = {}
        for run in self.runs:
            entered, rest_s = Counter[str](), sum(took_s for _, took_s in run)
            for phase, took_s in run:
                entered[phase] += 1
                rest_s -= took_s
                key = PhaseKey(phase, entered[phase])
                found.setdefault(key, []).append(_Earlier(took_s, rest_s))
        return found

    @property
    def keys(self) -> tuple[PhaseKey, ...]:
        """Return all phases of the runs, in the order in which they were first entered."""
        return tuple(self._passages)

    @property
    def notice(self) -> str:
        """Return in words how long the whole run takes."""
        if self.whole is None:
            few = self.of(len(self.runs))
            return f"forecast: only {few}, and {LEAST_RUNS} are needed: nothing is compared"
        of = f"90 % of {self.of(self.whole.runs)}"
        return f"forecast: {self.whole.words} from the first phase to the end ({of})"

    def of(self, runs: int) -> str:
        """Return a number of runs in words."""
        return f"{runs:,} run{'s' if runs != 1 else ''} on {self._backend}"

    def times_s(self, key: PhaseKey) -> list[float]:
        """Return how long the phase took in each run that entered it, in ascending order."""
        return sorted(each.took_s for each in self._passages.get(key, ()))

    def matters(self, key: PhaseKey) -> bool:
        """Return whether the phase takes any time worth mentioning."""
        return max(self.times_s(key), default=inf) >= WORTH_SAYING_S

    def usual(self, key: PhaseKey) -> Band | None:
        """Return how long the phase takes; None if too few runs have entered it."""
        return band_of(self.times_s(key))

    def slow(self, key: PhaseKey) -> SlowLimit | None:
        """Return from when on the phase is slow; None if too few runs have entered it."""
        times_s = self.times_s(key)
        runs = len(times_s)
        if runs < LEAST_RUNS:
            return None
        faster = runs + 1 - max(1, (runs + 1) // _IN_100)
        return SlowLimit(times_s[faster - 1], faster, runs)

    def remaining(self, key: PhaseKey, spent_s: float) -> Band | None:
        """Return how long the run will still take; None if too few were in the phase for so long.

        Whole runs are compared, so phases that are slow together count together.

        Args:
            key: The current phase.
            spent_s: How long the run has been in it.
        """
        return band_of(
            each.took_s - spent_s + each.rest_s
            for each in self._passages.get(key, ())
            if each.took_s >= spent_s - _WITHIN_S
        )

    def usual_words(self, key: PhaseKey) -> str:
        """Return how long the phase takes, in words; empty where it takes no time."""
        usual = self.usual(key)
        if not self.matters(key):
            return ""
        if usual is None:
            runs = len(self.times_s(key))
            return f"too few runs for {key.words}: {runs} of {len(self.runs)} entered it"
        return f"{key.words} usually takes {usual.words} (90 % of {self.of(usual.runs)})"

    def slow_words(self, key: PhaseKey, spent_s: float) -> str:
        """Return in words that the phase is slower than usual; empty if it is not."""
        slow, usual = self.slow(key), self.usual(key)
        if slow is None or usual is None or spent_s <= slow.limit_s + _WITHIN_S:
            return ""
        share = f"{slow.faster} of " if slow.faster < slow.runs else "all "
        return (
            f"{key.words} is slower than in {share}{self.of(slow.runs)}: more than "
            f"{slow.limit_s:.1f} s, usually {usual.words}"
        )

    def remaining_words(self, key: PhaseKey, spent_s: float) -> str:
        """Return in words how long the run will still take, if that is known."""
        left = self.remaining(key, spent_s)
        return "time left unknown" if left is None else f"{left.words} left if it succeeds"


class ForecastWatch(CompanionBase):
    """Says how long each phase usually takes as it begins, and warns as soon as it is slow.

    While the mission is paused, the time in its phase does not count; a phase begins again after.

    Args:
        forecast: What earlier runs say.
    """

    def __init__(self, forecast: EarlierRuns) -> None:
        self.forecast = forecast
        self._begin()

    def _begin(self) -> None:
        self._visits, self._said, self._paused, self.due_s = PhaseVisits(), "", False, inf

    def restart(self, robot: RobotSpec) -> None:
        """Begin again for another run."""
        self._begin()

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Note which phase the run is in."""
        if self._visits.see(effects, now_s):
            self._said, self.due_s = "", now_s if self._visits.key else inf

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Return what is to be said now."""
        visits, self._paused = self._visits, state.mission.paused
        key, self.due_s = visits.key, now_s + _LOOK_S
        if self._paused:
            visits.since_s = now_s
        if key is None or self._paused:
            return ()
        if not self._said:
            self._said = "usual"
            usual, left = self.forecast.usual_words(key), self.left(now_s)
            return (Log("info", f"{usual}; {left}"),) if usual else ()
        slow = self.forecast.slow_words(key, now_s - visits.since_s)
        if not slow or self._said == "slow":
            return ()
        self._said = "slow"
        return (Log("warning", slow),)

    def left(self, now_s: float) -> str:
        """Return in words how long the run will still take; empty while that means nothing."""
        key = self._visits.key
        if key is None or self._paused:
            return ""
        return self.forecast.remaining_words(key, now_s - self._visits.since_s)
