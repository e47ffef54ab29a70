"""Whether a mission that says it has succeeded has, with any defects in any pipe: `make belief`.

    python -m benchmarks.belief [--runs 3000] [--seed 0] [--mission climb] [--number 17]
                                [--robot tyre.rolling_resistance=0.02]

Every run draws its pipe from the seed (steps of the bore, patches, slopes, friction 0.05 to 0.9),
and none, one or two defects of the robot with numbers and a time of their own; see
`belief_cases.py`. The simulator's truth judges it:

- A claim by distance is false where the robot's estimate, the way that its words name, or the place
  where it says that it is back, is farther than 20 mm from the truth and farther than the bound
  that is printed with it. Truth counts from where the robot first drove.
- A claim by a word is false where the wheel of the word is more than 15 mm short of where the word
  says, or a wheel is still in the fitting.
- A robot that has left the pipe has not succeeded.

With nothing wrong (no defect, friction of at least 0.3, no step) runs succeed, and the bound is at
most 10 mm and 2 % of the way. Each false claim is listed with the command that repeats it; the
pipes are kept in `runs/belief`.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import chain
from math import inf, isnan, nan
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import NamedTuple, cast

from benchmarks.belief_cases import WAYS, Case, case_of
from pirate_sm.core.effects import Effect, Log, Setpoints
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.errors import PirateError
from pirate_sm.core.events import Event
from pirate_sm.lab.campaign.campaign_model import TrueEnd
from pirate_sm.lab.campaign.plan import command_of
from pirate_sm.lab.campaign.watched_run import Outcome, finished, judge
from pirate_sm.running.wiring import Prepared, load, prepare
from pirate_sm.simulation.simulated_robot import FullTruth

NEAR_M, PAST_M = 0.020, 0.030
"""How far a claim may be from the truth without a bound; how far beyond the middle of a bend every
wheel must be."""

ESTIMATE, BOUND = "odometry", "odometry_bound"
COVERED, SUCCEEDS = 0.99, 0.99
FOLDER = Path("runs/belief")


class Claim(NamedTuple):
    """What the robot says of its way at one moment, and the truth then, m.

    Attributes:
        estimate_m: The odometry.
        bound_m: How far it may be from the truth, by its own account; NaN: it does not say.
        truth_m: How far the robot has moved since it first drove.
        said_m: What its words say that it has driven; None: they do not say.
    """

    estimate_m: float = nan
    bound_m: float = nan
    truth_m: float = nan
    said_m: float | None = None

    def allows(self, said_m: float) -> bool:
        """Return whether a way that is claimed now is within 20 mm or the bound."""
        limit_m = NEAR_M if isnan(self.bound_m) else max(NEAR_M, self.bound_m)
        return abs(said_m - self.truth_m) <= limit_m

    def reaches(self, asked_m: float) -> bool:
        """Return whether it is where it was to be, or beyond that if it names its way."""
        return self.allows(asked_m) or (self.said_m is not None and self.truth_m > asked_m)


class Witness:
    """A companion that compares the robot's estimate with the truth whenever a claim is made."""

    due_s, listening = inf, False

    def __init__(self, truth: Callable[[], FullTruth]) -> None:
        self._truth = truth
        self._origin_m = nan
        self.logged: list[Claim] = []

    def follow(self, engine: Engine, state: Callable[[], EngineState | None]) -> None:
        """Read the run's state from here from now on."""
        self._engine, self._state = engine, state

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Note where the robot first drives, and what is logged on its way."""
        for effect in effects:
            if isinstance(effect, Setpoints) and isnan(self._origin_m):
                if self._engine.robot.travel(effect.values):
                    self._origin_m = self._truth().distance_m
            elif isinstance(effect, Log) and effect.message.startswith("Holding at"):
                self.logged.append(self.claim(effect.message))

    def speak(self, now_s: float) -> Sequence[Event]:
        """Say nothing."""
        return ()

    def claim(self, words: str) -> Claim:
        """Return what the robot says now, and in these words."""
        said = re.search(r"(-?\d+) ± \d+ mm", words)
        state, names = self._state(), self._engine.robot.vocabulary.numbers
        known = dict(zip(names, state.sensing.numbers if state else (), strict=False))
        truth_m = self._truth().distance_m - self._origin_m
        said_m = int(said[1]) / 1000 if said else None
        return Claim(known.get(ESTIMATE, nan), known.get(BOUND, nan), truth_m, said_m)


class Judged(NamedTuple):
    """A run and what is thought of it.

    Attributes:
        verdict: ``claimed`` truly, ``false``, ``failed`` truly, ``refused`` at once, or ``bug``.
        why: What is wrong, else how it ended.
        claim: What it said of its way at the end.
        covered: Whether the bound holds the truth, of each claim with one.
        wide: Whether nothing was wrong and the bound is wider than it may be.
    """

    case: Case
    verdict: str
    why: str
    claim: Claim = Claim()
    covered: tuple[bool, ...] = ()
    wide: bool = False


def judged(case: Case) -> Judged:
    """Run a case and judge it."""
    try:
        prepared = prepare(case.order, load(case.order))
        witness = Witness(cast("Callable[[], FullTruth]", prepared.truth))
        watched = replace(prepared, companions=(*prepared.companions, witness))
        outcome = finished(watched, perf_counter(), slides=False)
    except PirateError as error:
        return Judged(case, "refused", str(error).replace("\n", " "))
    except Exception as error:  # an internal error is a finding, too
        return Judged(case, "bug", repr(error))
    said = f"{outcome.outcome}: {outcome.message}"
    claim = witness.claim(outcome.message)
    claims = [*witness.logged, *([claim] if outcome.outcome == "succeeded" else ())]
    covered = tuple(
        abs(each.estimate_m - each.truth_m) <= each.bound_m
        for each in claims
        if case.way.ends == "distance" and not isnan(each.bound_m)
    )
    wrong = _wrong(case, outcome, claims, prepared)
    verdict = "false" if wrong else "claimed" if outcome.outcome == "succeeded" else "failed"
    by_distance = case.way.ends == "distance" and case.trouble == "nothing"
    wide = by_distance and claim.bound_m > 0.010 + 0.02 * case.path_m
    return Judged(case, verdict, f"{wrong} ({said})" if wrong else said, claim, covered, wide)


def _wrong(case: Case, outcome: Outcome, claims: Sequence[Claim], prepared: Prepared) -> str:
    """Return what a run says falsely; empty if nothing."""
    succeeded = outcome.outcome == "succeeded"
    if case.way.ends == "distance":
        for each in claims:
            if not each.allows(each.estimate_m):
                return _said(each.estimate_m, each)
            if each.said_m is not None and not each.allows(each.said_m):
                return _said(each.said_m, each)
        if succeeded and case.asked_m is not None and not claims[-1].reaches(case.asked_m):
            return _said(case.asked_m, claims[-1])
    by_word = case.way.ends == "word"
    verdict = judge(outcome, TrueEnd(at_word=by_word))
    if not succeeded or verdict.what == "false":
        return verdict.why if succeeded else ""
    if by_word:
        behind_m = _behind_m(outcome, prepared)
        if behind_m < PAST_M:
            where = "beyond" if behind_m >= 0 else "before"
            return f"a wheel is {abs(behind_m) * 1000:.0f} mm {where} the middle of the bend"
    return ""


def _said(said_m: float, claim: Claim) -> str:
    bound = "" if isnan(claim.bound_m) else f" ± {claim.bound_m * 1000:.0f}"
    return f"says {said_m * 1000:.0f}{bound} mm at {claim.truth_m * 1000:.0f} mm"


def _behind_m(outcome: Outcome, prepared: Prepared) -> float:
    """Return how far beyond the middle of the bend the last wheel is, the way it was driven."""
    assert prepared.places is not None  # as the run has seen
    travel = -1 if "backward" in prepared.order.mission else 1
    crossings = [travel * crossing for crossing, _ in prepared.places.bends]
    last_m = min(travel * arc for arc in outcome.arcs_m)
    return last_m - min(crossings, default=nan)


def main() -> int:
    """Print what came of each mission; return 1 when a bar is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first run")
    missions = sorted({way.mission for way in WAYS})
    parser.add_argument("--mission", action="append", choices=missions, help="all by default")
    parser.add_argument("--number", type=int, help="judge this run alone")
    parser.add_argument("--robot", action="append", default=[], help="a number of all robots")
    parser.add_argument("--backend", choices=("sim", "physics"), default="sim")
    parser.add_argument("--workers", type=int, help="processes; all processors by default")
    wishes = parser.parse_args()
    numbers: Sequence[int] = range(wishes.first, wishes.first + wishes.runs)
    if wishes.number is not None:
        numbers = (wishes.number,)
    case = partial(
        case_of,
        wishes.seed,
        folder=FOLDER,
        missions=tuple(wishes.mission or ()),
        backend=wishes.backend,
        robot=dict(each.split("=", 1) for each in wishes.robot),
    )
    first = judged(case(numbers[0]))  # compiles the simulator once, before the others need it
    with ProcessPoolExecutor(wishes.workers, mp_context=get_context("spawn")) as pool:
        rest = pool.map(judged, map(case, numbers[1:]), chunksize=4)
        found = list(_shown(chain([first], rest)))
    return 1 if _summed(found) else 0


def _shown(found: Iterable[Judged]) -> Iterator[Judged]:
    """Yield what was found; print the false claims as they come."""
    for each in found:
        if each.verdict in ("false", "bug", "refused"):
            print(f"{each.verdict.upper()} {each.case.number} [{each.case.trouble}]: {each.why}")
            print(f"    {command_of(each.case.order, each.case.order.seed)}", flush=True)
        yield each


def _summed(found: Sequence[Judged]) -> bool:
    """Print tables, and whether the bars are reached; return whether one is missed."""
    _table("mission", found, lambda each: each.case.way.mission)
    _table("what is wrong", found, lambda each: each.case.trouble)
    false = [each for each in found if each.verdict in ("false", "bug")]
    refused = sum(each.verdict == "refused" for each in found)
    plain = [each for each in found if each.case.trouble == "nothing"]
    good = sum(each.verdict == "claimed" for each in plain)
    covered = [held for each in found for held in each.covered]
    held, wide = sum(covered), sum(each.wide for each in plain)
    print(f"{len(found)} runs: {len(false)} claim falsely, {refused} were refused at once")
    print(f"with nothing wrong {good} of {len(plain)} succeed; {wide} bounds are too wide")
    print(f"{held} of {len(covered)} bounds hold the truth")
    for each in found:
        amiss = each.verdict != "claimed" and each.case.trouble == "nothing"
        if amiss or each.wide or not all(each.covered):
            said = _said(each.claim.estimate_m, each.claim)
            print(f"    {each.case.number} {each.why}{'' if amiss else f': {said}'}")
            print(f"        {command_of(each.case.order, each.case.order.seed)}")
    missed = good < SUCCEEDS * len(plain) or held < COVERED * len(covered)
    return bool(false) or bool(wide) or missed


def _table(title: str, found: Sequence[Judged], name_of: Callable[[Judged], str]) -> None:
    """Print a table of what came of the runs, by something that they have in common."""
    print(f"| {title} | runs | claimed | failed | false | farthest off | bound, median |")
    print("|---|---|---|---|---|---|---|")
    for name in sorted({name_of(each) for each in found}):
        mine = [each for each in found if name_of(each) == name]
        print(f"| {' | '.join([name, *_cells(mine)])} |")
    print()


def _cells(mine: Sequence[Judged]) -> Iterator[str]:
    yield str(len(mine))
    for verdict in ("claimed", "failed", "false"):
        yield str(sum(each.verdict == verdict for each in mine))
    claims = [
        e.claim for e in mine if e.verdict in ("claimed", "false") and e.case.way.ends == "distance"
    ]
    errors = [abs(claim.estimate_m - claim.truth_m) for claim in claims]
    yield f"{max(errors) * 1000:.0f} mm" if errors else "–"
    bounds = [claim.bound_m for claim in claims if not isnan(claim.bound_m)]
    yield f"{median(bounds) * 1000:.0f} mm" if bounds else "–"


if __name__ == "__main__":
    sys.exit(main())
