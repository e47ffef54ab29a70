"""Searches for the smallest change with which a mission fails, or says falsely that it succeeded.

Every factor is measured in its range: 0 is the value of the files, 1 and -1 are its ends. CMA-ES
(Hansen and Ostermeier, "Completely derandomized self-adaptation in evolution strategies",
Evolutionary Computation 9, 2001; the package `cmaes`) looks for what fails by how near each run
came to its limits, and from then on for what fails nearer to the files. It begins several times:
first at the values of the files, then elsewhere. What it finds is made smaller: factors that are
not needed go back to the files, and the others as far as it still fails.

Every run has the same seed, so each change fails or passes for certain, and one command repeats it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isnan, sqrt
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from pirate_sm.core.errors import not_installed
from pirate_sm.lab.campaign.chunk import Chunk, RunRow
from pirate_sm.lab.campaign.crew import ChunkRunner
from pirate_sm.lab.campaign.margin_factors import level_of
from pirate_sm.lab.campaign.margins_model import MarginFactor
from pirate_sm.lab.campaign.plan import Cell
from pirate_sm.lab.campaign.store import Store

if TYPE_CHECKING:
    from cmaes import CMA

Point: TypeAlias = tuple[float, ...]
"""A change: for each factor where it is between its ends, from -1 to 1."""

Evaluate: TypeAlias = Callable[[Sequence[Point]], Sequence[RunRow]]
"""Runs a mission with each change, and returns what came of it."""

STARTS = 3
"""How often a search begins [decided]."""

_SIGMA = 0.3
"""How far from its beginning it looks first, as a share of the range. [decided]"""

_SHARE_OF_SHRINKING = 0.25
"""The share of all runs that is left to make what was found smaller. [decided]"""

_HALVINGS = 4
_LOOK_S = 0.5

Wrong: TypeAlias = Literal["failed", "false", "bug"]
_KINDS: tuple[Wrong, ...] = ("failed", "false", "bug")


@dataclass(frozen=True)
class FailingChange:
    """A change with which a mission does not pass.

    Attributes:
        point: The change; ``row`` is what came of it.
    """

    point: Point
    row: RunRow

    @property
    def size(self) -> float:
        """How large the change is: its length, with every range as 1."""
        return sqrt(sum(each * each for each in self.point))


@dataclass(frozen=True)
class Falsified:
    """What a search has found.

    Attributes:
        least: The smallest change of each kind: ``failed``, or ``false``, the worse one; ``bug`` is
            an internal error of this program.
        runs: How many runs there were; ``wrong``: how many of them did not pass.
    """

    least: Mapping[str, FailingChange]
    runs: int
    wrong: int


class _Log:
    """Evaluates changes, once each, and keeps what came of them."""

    def __init__(self, evaluate: Evaluate) -> None:
        self._evaluate = evaluate
        self.rows: dict[Point, RunRow] = {}

    def __call__(self, points: Sequence[Point]) -> list[RunRow]:
        """Return what comes of some changes."""
        new = [each for each in dict.fromkeys(points) if each not in self.rows]
        self.rows |= zip(new, self._evaluate(new), strict=True)
        return [self.rows[each] for each in points]

    def found(self) -> Iterator[FailingChange]:
        """Yield all changes with which the mission did not pass."""
        return (FailingChange(*each) for each in self.rows.items() if is_wrong(each[1]))


def is_wrong(row: RunRow) -> bool:
    """Return whether a run began and did not pass; one that cannot begin shows nothing."""
    return row.verdict in _KINDS and row.outcome != "refused"


def falsify(
    sides: Sequence[tuple[float, float]], evaluate: Evaluate, budget: int, seed: int
) -> Falsified:
    """Return the smallest changes that were found.

    Args:
        sides: How far each factor may go below its value in the files, -1 or 0, and above, 1 or 0;
            less searches nearer to it.
        evaluate: Runs the mission.
        budget: Runs at most, about.
        seed: Of the search.

    Raises:
        UsageError: The package ``cmaes`` is not installed.
    """
    log, least = _Log(evaluate), dict[str, FailingChange]()
    search = int(budget * (1.0 - _SHARE_OF_SHRINKING))
    for start in range(STARTS):
        limit = search * (start + 1) // STARTS
        _search(_begun(sides, seed, start), log, limit)
    for kind in _KINDS:
        known = [each for each in log.found() if each.row.verdict == kind]
        if known:
            least[kind] = _shrunk(min(known, key=lambda each: each.size), log)
    return Falsified(least, len(log.rows), sum(map(is_wrong, log.rows.values())))


def _begun(sides: Sequence[tuple[float, float]], seed: int, start: int) -> CMA:
    try:
        from cmaes import CMA
    except ModuleNotFoundError:
        raise not_installed("--falsify", "cmaes", "falsify") from None
    bounds = np.array(sides, dtype=float)
    drawn = np.random.default_rng((seed, start)).uniform(bounds[:, 0], bounds[:, 1])
    width = float(np.mean(bounds[:, 1] - bounds[:, 0]))
    mean = drawn if start else np.zeros(len(bounds))
    number = (seed * STARTS + start + 1) % 2**32  # cmaes takes no larger ones
    return CMA(mean, _SIGMA * width / 2, bounds=bounds, seed=number)


def _search(optimizer: CMA, log: _Log, limit: int) -> None:
    """Search from one beginning until so many runs are done, or it has come to rest."""
    while len(log.rows) < limit and not optimizer.should_stop():
        points = [_point(optimizer.ask()) for _ in range(optimizer.population_size)]
        costs = [_cost(*each) for each in zip(points, log(points), strict=True)]
        optimizer.tell([(np.array(p), c) for p, c in zip(points, costs, strict=True)])


def _point(x: Sequence[float]) -> Point:
    return tuple(round(float(each), 3) for each in x)


def _cost(point: Point, row: RunRow) -> float:
    """Return what is minimised: the size of a change that fails, else how far a run is from that.

    Whatever fails costs less than what passes, and a false success half of a failure.
    """
    size, farthest = FailingChange(point, row).size, sqrt(len(point))
    if is_wrong(row):
        return size / 2 if row.verdict == "false" else size
    return farthest + 1.0 / (1.0 + (0.0 if isnan(row.near) else row.near))


def _shrunk(found: FailingChange, log: _Log) -> FailingChange:
    """Return a smaller change of the same kind, by the fewest factors."""
    kind, point = found.row.verdict, found.point

    def still(other: Point) -> bool:
        row = log([other])[0]
        return row.verdict == kind and is_wrong(row)

    for number in sorted(range(len(point)), key=lambda n: abs(point[n])):
        if point[number] and still(other := (*point[:number], 0.0, *point[number + 1 :])):
            point = other
    for number, whole in enumerate(point):
        passes, fails = 0.0, whole
        for _ in range(_HALVINGS if whole else 0):
            middle = round((passes + fails) / 2, 3)
            if still((*point[:number], middle, *point[number + 1 :])):
                fails = middle
            else:
                passes = middle
        point = (*point[:number], fails, *point[number + 1 :])
    return FailingChange(point, log.rows[point])


# --- with a crew ---------------------------------------------------------------------------------


def values_at(factors: Sequence[MarginFactor], point: Point) -> dict[MarginFactor, float]:
    """Return the values of the factors that a change moves."""
    found = zip(factors, point, strict=True)
    return {factor: factor.between(share) for factor, share in found if share}


def sides_of(factors: Sequence[MarginFactor], within: float) -> list[tuple[float, float]]:
    """Return how far each factor may go, as a share of its range."""
    return [
        (-within if each.low < each.nominal else 0.0, within if each.high > each.nominal else 0.0)
        for each in factors
    ]


class Evaluation:
    """Runs a cell with changes, on a crew, and keeps the results in a store.

    Args:
        cell: The cell, with the factors round it.
        store: Where results are kept; what is there is not run again.
        crew: Runs them.
        seed: Of every run.

    Attributes:
        asked: How many changes it was asked for.
    """

    def __init__(self, cell: Cell, store: Store, crew: ChunkRunner, seed: int) -> None:
        self._cell, self._store, self._crew, self._seed = cell, store, crew, seed
        self._rows = {row.cell: row for rows in store.read() for row in rows if row.seed == seed}
        self.asked = 0

    def __call__(self, points: Sequence[Point]) -> list[RunRow]:
        """Return what comes of some changes."""
        self.asked += len(points)
        cells = [level_of(self._cell, values_at(self._cell.around, each)) for each in points]
        left = {each.key: each for each in cells if each.key not in self._rows}
        for cell in left.values():
            self._store.describe(cell.key, cell.values)
        waiting, under_way = list(left.values()), 0
        while waiting or under_way:
            while waiting and (under_way == 0 or self._crew.room > 0):
                cell = waiting.pop(0)
                chunk = Chunk(
                    cell.key, cell.order, cell.end, cell.mission, (self._seed,), near=True
                )
                self._crew.submit(chunk)
                under_way += 1
            for done in self._crew.wait(_LOOK_S):
                under_way -= 1
                self._store.add(done.rows)
                self._rows |= {row.cell: row for row in done.rows}
        return [self._rows[each.key] for each in cells]
