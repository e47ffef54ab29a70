"""How far a cell of a campaign holds, by the counts of the cells around it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from pirate_sm.lab.campaign.envelope import Envelope, Side, envelope, grid
from pirate_sm.lab.campaign.margin_factors import bound_of, level_of
from pirate_sm.lab.campaign.margins_model import MarginFactor, Margins
from pirate_sm.lab.campaign.plan import Cell, command_of
from pirate_sm.lab.campaign.sequential import DOUBTFUL, FAILS, HOLDS, REFUSED, Verdict
from pirate_sm.lab.campaign.tally import Cause, Tally


@dataclass(frozen=True)
class TriedValue:
    """What the runs at one value of a factor came to.

    Attributes:
        value: Of the factor, in its unit; of a pair, the second one is ``other``.
        verdict: Whether it holds; ``open`` while that is not decided, ``refused`` if a run cannot
            begin.
        passed: How many of its runs passed, of ``runs``.
        least: Least share of the interval of its success; likewise ``most``.
        why: Why a run did not pass, most often; empty if all did. An internal error, or that a run
            cannot begin, comes first.
        command: Repeats the first of these runs.
        bugs: How many of its runs met an internal error.
    """

    value: float
    verdict: Verdict | str
    passed: int = 0
    runs: int = 0
    least: float = 0.0
    most: float = 1.0
    why: str = ""
    command: str = ""
    other: float | None = None
    bugs: int = 0


@dataclass(frozen=True)
class FactorMargin:
    """How far a cell holds when one factor changes.

    Attributes:
        name: Of the factor, which is given in ``unit``.
        nominal: Its value in the files; of a defect, the end of the range at which it does least.
        low: The least value that was tried; likewise ``high``.
        holds_from: It holds from here, likewise ``holds_to``; None: not even at the nominal value.
        fails_below: The first value below the nominal one that fails; None: none that was tried.
        fails_above: Likewise above.
        again: Values behind an edge that hold: success does not depend on the factor one way.
        levels: What was tried, from the least value on.
        missed: Which wanted margins are missed.
        added: Whether the nominal value is tried with a defect that the files do not have.
    """

    name: str
    unit: str
    nominal: float
    low: float
    high: float
    holds_from: float | None
    holds_to: float | None
    fails_below: float | None
    fails_above: float | None
    again: tuple[float, ...]
    levels: tuple[TriedValue, ...]
    missed: tuple[str, ...]
    added: bool = False

    @property
    def refused_below(self) -> float | None:
        """The first value below the nominal one that cannot be run; None: none that was tried."""
        found = (level.value for level in self.levels if level.verdict == REFUSED)
        return max((value for value in found if value < self.nominal), default=None)

    @property
    def refused_above(self) -> float | None:
        """Likewise above."""
        found = (level.value for level in self.levels if level.verdict == REFUSED)
        return min((value for value in found if value > self.nominal), default=None)

    @property
    def words(self) -> str:
        """How far it holds, human-readable."""
        unit = f" {self.unit}" if self.unit else ""
        if self.holds_from is None or self.holds_to is None:
            at = f"{self.nominal:g}{unit}, where it does least"
            verdicts = [each.verdict for each in self.levels if each.value == self.nominal]
            verdict = _SAID[verdicts[0] if verdicts else "open"]
            words = f"{verdict} at {at if self.added else 'the value of the files'}"
            return "; ".join([words, *(f"MISSED: {each}" for each in self.missed)])
        ends = [
            ("all below" if self.low < self.nominal else "", self.holds_from, self.low),
            ("all above" if self.high > self.nominal else "", self.holds_to, self.high),
        ]
        words = f"holds from {self.holds_from:g} to {self.holds_to:g}{unit}"
        found = [
            f"fails at {each:g}{unit}"
            for each in (self.fails_below, self.fails_above)
            if each is not None
        ]
        found += [
            f"cannot be run at {each:g}{unit}"
            for each in (self.refused_below, self.refused_above)
            if each is not None
        ]
        found += [f"{what} tried holds" for what, edge, end in ends if what and edge == end]
        found += (
            [f"holds again at {', '.join(f'{x:g}' for x in self.again)}{unit}"]
            if self.again
            else []
        )
        return "; ".join([words, *found, *(f"MISSED: {each}" for each in self.missed)])


@dataclass(frozen=True)
class PairMap:
    """How far a cell holds when two factors change.

    Attributes:
        names: Of the factors: across, and up; likewise ``units`` and ``nominal`` values.
        levels: What was tried, row by row from below.
    """

    names: tuple[str, str]
    units: tuple[str, str]
    nominal: tuple[float, float]
    levels: tuple[TriedValue, ...]


@dataclass(frozen=True)
class CellMargins:
    """How far a cell holds, as far as that is known.

    Attributes:
        share: The share of runs that must pass.
        verdict: Of the cell itself; None while it is not decided.
        factors: Each factor alone; likewise ``pairs``.
        wanted: The cells whose results are needed next.
        runs: How many runs there are at other values.
        bugs: How many of these met an internal error.
    """

    share: float
    verdict: Verdict | None
    factors: tuple[FactorMargin, ...]
    pairs: tuple[PairMap, ...]
    wanted: tuple[Cell, ...]
    runs: int = 0
    bugs: int = 0

    @property
    def missed(self) -> tuple[str, ...]:
        """Which wanted margins are missed, of all factors; and the share at the values of files."""
        itself = []
        if self.verdict is not None and self.verdict != HOLDS:
            share, said = f"{100 * self.share:.12g} %", _SAID[self.verdict]
            itself = [f"success >= {share} at the values of the files, where it {said}"]
        margins = (f"margin of {f.name} {each}" for f in self.factors for each in f.missed)
        return (*itself, *margins)


TallyOf: TypeAlias = Callable[[str], Tally | None]
"""Returns the counts of the cell with a key, if there are any."""


def wanted_cells(cell: Cell, wanted: Margins, tally_of: TallyOf) -> list[Cell]:
    """Return the cells whose results are needed next to know how far a cell holds."""
    return _searched(cell, wanted, tally_of)[1]


def _searched(
    cell: Cell, wanted: Margins, tally_of: TallyOf
) -> tuple[list[Envelope], list[Cell], list[Tally]]:
    """Return what is known of each factor, the cells to run next, and the counts of the others."""
    asked: dict[str, Cell] = {}
    counted: dict[str, Tally] = {}

    def verdict_at(values: Mapping[MarginFactor, float]) -> Verdict | None:
        level = level_of(cell, values)
        tally = tally_of(level.key)
        verdict = tally.verdict if tally is not None else None
        if level.key != cell.key:
            if tally is not None:
                counted[level.key] = tally
            if verdict is None:
                asked[level.key] = level
        return verdict

    nominal = tally_of(cell.key)
    if nominal is None or nominal.verdict != HOLDS:
        return [], [], []
    found = [
        envelope(
            factor,
            verdict_at,
            wanted.levels,
            wanted.halvings,
            [bound_of(factor, each.text) for each in wanted.expects.get(factor.name, ())],
        )
        for factor in cell.around
    ]
    for pair in _pairs(cell, wanted):
        for values in grid(pair):
            verdict_at(values)
    return found, list(asked.values()), list(counted.values())


def _pairs(cell: Cell, wanted: Margins) -> list[tuple[MarginFactor, MarginFactor]]:
    by_name = {each.name: each for each in cell.around}
    return [(by_name[first], by_name[second]) for first, second in wanted.pairs]


def margins_of(cell: Cell, wanted: Margins, tally_of: TallyOf) -> CellMargins:
    """Return how far a cell with factors round it holds, as far as that is known."""
    nominal = tally_of(cell.key)
    if nominal is None or nominal.verdict != HOLDS:
        verdict = None if nominal is None else nominal.verdict
        around = cell.around if verdict is not None else ()
        factors = tuple(_unheld(cell, each, wanted, tally_of) for each in around)
        return CellMargins(wanted.share, verdict, factors, (), ())
    found, asked, others = _searched(cell, wanted, tally_of)
    factors = tuple(_factor_margin(cell, each, wanted, tally_of) for each in found)
    maps = []
    for first, second in _pairs(cell, wanted):
        levels = tuple(_level(cell, each, tally_of) for each in grid((first, second)))
        middle = first.shown(first.nominal), second.shown(second.nominal)
        maps.append(PairMap((first.name, second.name), (first.unit, second.unit), middle, levels))
    counts = sum(each.runs for each in others), sum(each.bugs for each in others)
    return CellMargins(wanted.share, HOLDS, factors, tuple(maps), tuple(asked), *counts)


def _unheld(cell: Cell, factor: MarginFactor, wanted: Margins, tally_of: TallyOf) -> FactorMargin:
    """Return the margin of a factor of a cell that does not even hold itself."""
    low, nominal, high = map(factor.shown, (factor.low, factor.nominal, factor.high))
    missed = tuple(f"{each.side} {each.text}" for each in wanted.expects.get(factor.name, ()))
    itself = (_tried(cell, [nominal], tally_of),)
    return FactorMargin(
        factor.name, factor.unit, nominal, low, high, None, None, None, None, (), itself, missed
    )


def _factor_margin(cell: Cell, found: Envelope, wanted: Margins, tally_of: TallyOf) -> FactorMargin:
    factor, below, above = found.factor, found.below, found.above
    shown = factor.shown
    tried = [*(value for side in (below, above) for value, _ in side.tried), factor.nominal]
    values = sorted({shown(value): value for value in tried}.values())

    def fails(side: Side) -> float | None:
        return None if side.fails is None else shown(side.fails)

    levels = tuple(_level(cell, {factor: value}, tally_of) for value in values)
    begins = levels[values.index(factor.nominal)].verdict == HOLDS
    missed = tuple(
        f"{each.side} {each.text}"
        for each in wanted.expects.get(factor.name, ())
        if not begins or not _reaches(each.side, bound_of(factor, each.text), found)
    )
    return FactorMargin(
        factor.name,
        factor.unit,
        shown(factor.nominal),
        shown(factor.low),
        shown(factor.high),
        shown(below.edge) if begins else None,
        shown(above.edge) if begins else None,
        fails(below),
        fails(above),
        tuple(map(shown, (*below.again, *above.again))),
        levels,
        missed,
        factor.added,
    )


def _reaches(side: str, bound: float, found: Envelope) -> bool:
    """Return whether it holds down to a bound, or up to it."""
    at = found.factor.rounded(bound)
    return found.below.edge <= at if side == ">=" else found.above.edge >= at


def _level(cell: Cell, values: Mapping[MarginFactor, float], tally_of: TallyOf) -> TriedValue:
    shown = [factor.shown(value) for factor, value in values.items()]
    return _tried(level_of(cell, values), shown, tally_of)


def _tried(level: Cell, shown: Sequence[float], tally_of: TallyOf) -> TriedValue:
    other = shown[1] if len(shown) > 1 else None
    tally = tally_of(level.key)
    if tally is None or not tally.runs:
        return TriedValue(shown[0], "open", other=other)
    cause = max(tally.causes.values(), key=_telling, default=None)
    command = "" if cause is None else command_of(level.order, cause.seeds[0])
    why = "" if cause is None else f"{cause.verdict}: {cause.why}"
    counts, verdict = (tally.passed, tally.runs, *tally.interval), tally.verdict or "open"
    return TriedValue(shown[0], verdict, *counts, why, command, other, tally.bugs)


def _telling(cause: Cause) -> tuple[bool, int]:
    return cause.verdict in ("bug", REFUSED), cause.count


# --- text ----------------------------------------------------------------------------------------


def margin_lines(factors: Sequence[FactorMargin], pairs: Sequence[PairMap]) -> Iterator[str]:
    """Yield what is known as text: a line for each factor, and the map of each pair."""
    width = max((len(each.name) for each in factors), default=0)
    for each in factors:
        yield f"{each.name:{width}}  {each.words}"
        yield from _nearest(each, width)
    for pair in pairs:
        yield from _map_lines(pair)


def _nearest(found: FactorMargin, width: int) -> Iterator[str]:
    """Yield why it does not hold where that counts, and the command that repeats it.

    That is the first value behind each edge that fails or cannot be run, the value with which a
    defect does least, and where there was an internal error.
    """
    ats = {found.fails_below, found.fails_above, found.refused_below, found.refused_above}
    ats |= {found.nominal} if found.added and found.holds_from is None else set()
    for level in found.levels:
        if (level.value in ats and level.why) or level.bugs:
            yield f"{'':{width}}    at {level.value:g}: {level.why}"
            yield f"{'':{width}}    {level.command}"


_SIGNS: Mapping[str, str] = {HOLDS: "+", DOUBTFUL: "?", FAILS: "-", REFUSED: "/", "open": " "}
_SAID: Mapping[str, str] = {
    HOLDS: "holds",
    DOUBTFUL: "is doubtful",
    FAILS: "fails",
    REFUSED: "cannot be run",
    "open": "has no result yet",
}


def _map_lines(pair: PairMap) -> Iterator[str]:
    """Yield the map of a pair, and where there was an internal error."""
    across, up = (f"{n}, {u}" if u else n for n, u in zip(pair.names, pair.units, strict=True))
    yield f"{up} (up) against {across} (across): + holds, ? doubtful, - fails, / cannot be run"
    rows: dict[float | None, list[TriedValue]] = {}
    for level in pair.levels:
        rows.setdefault(level.other, []).append(level)
    for other, levels in reversed(rows.items()):
        yield f"{other:>10g}  " + "".join(f"{_SIGNS[each.verdict]:>9}" for each in levels)
    first: Sequence[TriedValue] = next(iter(rows.values()), [])
    yield f"{'':>10}  " + "".join(f"{each.value:9g}" for each in first)
    for level in pair.levels:
        if level.bugs:
            yield f"    at {level.value:g}, {level.other:g}: {level.why}"
            yield f"    {level.command}"
