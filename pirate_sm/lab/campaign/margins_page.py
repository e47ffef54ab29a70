"""Draws how far a cell holds: a line for each factor, and a map for each pair of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape

from pirate_sm.lab.campaign.margins import FactorMargin, PairMap, TriedValue
from pirate_sm.lab.campaign.sequential import DOUBTFUL, FAILS, HOLDS, REFUSED

MARGINS_STYLE = """<style>
.figures .margins { width: 100%; min-width: 620px; max-width: 860px; display: block; }
.margins text { font: 12px system-ui, sans-serif; fill: var(--ink); }
.margins .soft { fill: var(--soft); font-size: 11px; }
.margins .holds { fill: var(--good); } .margins .doubtful { fill: var(--late); }
.margins .fails { fill: var(--bad); } .margins :is(.open, .refused) { fill: var(--faint); }
.margins .zone { opacity: 0.3; }
.margins path { fill: none; stroke: var(--ink); stroke-width: 1.5; }
.heat td.holds { background: var(--good-box); } .heat td.fails { background: var(--bad-box); }
.heat td.doubtful { background: var(--late-box); }
</style>"""

_WIDTH, _LEFT, _RIGHT, _ROW = 860.0, 250.0, 810.0, 44.0
_BAR = 12.0
_SIGNS: Mapping[str, str] = {
    HOLDS: "holds",
    DOUBTFUL: "?",
    FAILS: "fails",
    REFUSED: "cannot be run",
    "open": "open",
}

HOW_TO_READ = (
    "Green (●): it holds; amber (○): doubtful, so few or so many runs pass that more would be"
    " needed; red (×): it fails; grey: it cannot be run. The upright line is the value of the files"
    " or, of a defect, the one with which it does least; each mark is a value that was tried: point"
    " at it for its runs. Between neighbouring marks nothing was tried."
)


def margins_markup(factors: Sequence[FactorMargin], pairs: Sequence[PairMap]) -> str:
    """Return the drawing of all factors and the maps of the pairs, as HTML."""
    return "".join((*_envelope(factors), *(line for pair in pairs for line in _map(pair))))


def _envelope(factors: Sequence[FactorMargin]) -> Iterator[str]:
    if not factors:
        return
    height = _ROW * len(factors) + 6
    said = "; ".join(f"{each.name} {each.words}" for each in factors)
    yield (
        f'<div class="wide" tabindex="0"><svg class="margins" viewBox="0 0 {_WIDTH:g} {height:g}" '
        f'role="img" aria-label="{escape(said)}">'
    )
    for number, factor in enumerate(factors):
        yield from _row(factor, _ROW * number + 18)
    yield "</svg></div>"


def _row(factor: FactorMargin, y: float) -> Iterator[str]:
    """Yield the line of a factor: its zones, what was tried, and the numbers at its ends."""
    unit = f", {factor.unit}" if factor.unit else ""
    width = factor.high - factor.low

    def at(value: float) -> float:
        return _LEFT + (_RIGHT - _LEFT) * (value - factor.low) / width

    name = escape(factor.name + unit)
    yield f'<text x="{_LEFT - 14:g}" y="{y + 4:g}" text-anchor="end">{name}</text>'
    for kind, begin, end in _zones(factor):
        yield (
            f'<rect class="zone {kind}" x="{at(begin):.1f}" y="{y - _BAR / 2:g}" '
            f'width="{at(end) - at(begin):.1f}" height="{_BAR:g}"/>'
        )
    nominal = at(factor.nominal)
    yield f'<path d="M{nominal:.1f} {y - 10:g}v20"/>'
    for level in factor.levels:
        yield _mark(level, at(level.value), y)
    edges = {factor.low, factor.high, factor.nominal, factor.holds_from, factor.holds_to}
    last = -1e9
    for value in sorted(each for each in edges if each is not None):
        if at(value) - last > 42:  # else the numbers would overlap
            last = at(value)
            place = f'x="{last:.1f}" y="{y + 21:g}" text-anchor="middle"'
            yield f'<text class="soft" {place}>{value:g}</text>'


def _zones(factor: FactorMargin) -> Iterator[tuple[str, float, float]]:
    """Yield where it holds, where that is in doubt, and where it fails."""
    low, high = factor.low, factor.high
    if factor.holds_from is None or factor.holds_to is None:
        return  # what the marks say is all that is known
    grey_below = low if factor.refused_below is None else factor.refused_below
    grey_above = high if factor.refused_above is None else factor.refused_above
    fails_below, fails_above = factor.fails_below, factor.fails_above
    red_below = grey_below if fails_below is None else max(fails_below, grey_below)
    red_above = grey_above if fails_above is None else min(fails_above, grey_above)
    yield REFUSED, low, grey_below
    yield FAILS, grey_below, red_below
    yield DOUBTFUL, red_below, factor.holds_from
    yield HOLDS, factor.holds_from, factor.holds_to
    yield DOUBTFUL, factor.holds_to, red_above
    yield FAILS, red_above, grey_above
    yield REFUSED, grey_above, high


def _mark(level: TriedValue, x: float, y: float) -> str:
    said = f"{level.value:g}: {_counts(level)}{f'; {level.why}' if level.why else ''}"
    title = f"<title>{escape(said)}</title>"
    if level.verdict == FAILS:
        path = f"M{x - 3.5:.1f} {y - 3.5:g}l7 7m-7 0l7 -7"
        return f'<path style="stroke: var(--bad)" d="{path}">{title}</path>'
    fill = ' style="fill: var(--paper); stroke: var(--late)"' if level.verdict == DOUBTFUL else ""
    return f'<circle class="{level.verdict}"{fill} cx="{x:.1f}" cy="{y:g}" r="3.5">{title}</circle>'


def _counts(level: TriedValue) -> str:
    if not level.runs:
        return "no runs"
    if level.verdict == REFUSED:
        return "cannot be run"
    return f"{level.passed} of {level.runs} passed, {level.least:.0%} to {level.most:.0%}"


def _map(pair: PairMap) -> Iterator[str]:
    """Yield a table with a field for each place: the first factor across, the second one up."""
    across, up = (f"{n}, {u}" if u else n for n, u in zip(pair.names, pair.units, strict=True))
    first, second = pair.nominal
    rows: dict[float | None, list[TriedValue]] = {}
    for level in pair.levels:
        rows.setdefault(level.other, []).append(level)
    heads = "".join(f'<th scope="col">{each.value:g}</th>' for each in next(iter(rows.values())))
    yield (
        f"<p>{escape(up)} (up) against {escape(across)} (across); the files have {first:g} and"
        f' {second:g}.</p><div class="wide" tabindex="0">'
    )
    yield f'<table class="heat"><thead><tr><th></th>{heads}</tr></thead><tbody>'
    for other, levels in reversed(rows.items()):
        fields = "".join(
            f'<td class="{each.verdict}" title="{escape(each.why)}">{_SIGNS[each.verdict]}'
            f"<small>{each.passed} of {each.runs}</small></td>"
            for each in levels
        )
        yield f'<tr><th scope="row">{other:g}</th>{fields}</tr>'
    yield "</tbody></table></div>"
