"""The result of a campaign as one HTML page that loads no other file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from types import MappingProxyType
from urllib.parse import quote

from pirate_sm.lab.campaign.chunk import FROM_FILES
from pirate_sm.lab.campaign.margins_page import HOW_TO_READ, MARGINS_STYLE, margins_markup
from pirate_sm.lab.campaign.results import (
    CampaignResult,
    CauseResult,
    CellResult,
    FactorResult,
    TimeCounts,
)
from pirate_sm.lab.campaign.sensitivity import Decided
from pirate_sm.views.drawing.svg.plot import Plot, PlotSeries
from pirate_sm.views.report.figure_page import FigureSection, figure_page

_STYLE = """<style>
.heat .bad { outline: 2px solid var(--bad); outline-offset: -2px; }
.causes code { font-size: 12px; user-select: all; }
.figures .plot { display: inline-block; width: 100%; max-width: 440px; margin: 6px 10px 0 0; }
</style>"""

_MOST_SEEDS = 20

_MOST_DRAWN = 200
"""The most cells with plots: of more the page would be too large to be shown."""

_MOST_BARS = 12
_HALF_BAR = 0.36

_UNITS = {"m": ("mm", 1e3), "": ("%", 100.0)}
"""The unit in which numbers are shown instead of their own, and how many of it make up one."""


def page_of(
    result: CampaignResult,
    recordings: str,
    damaged: Sequence[str] = (),
    reports: Mapping[str, str] = MappingProxyType({}),
) -> str:
    """Return the page: a map of all cells, and each cell with its interval and its causes.

    Args:
        result: The result.
        recordings: The folder of the recordings, as seen from the page.
        damaged: What is wrong with files of results that cannot be read.
        reports: Links to the reports of recordings, by the paths of these.
    """
    if len(result.cells) > _MOST_DRAWN:
        damaged = [*damaged, f"Plots are shown of the first {_MOST_DRAWN} cells."]
    lines = [
        f"{result.summary}. Run with {result.version}; intervals of {result.confidence:.0%} "
        f"({'of the tests' if any(cell.margins for cell in result.cells) else 'Wilson'}).",
        *damaged,
        *(f"{name}: not run, a cell before it is not as expected" for name in result.left_out),
    ]
    style = _STYLE + (MARGINS_STYLE if any(cell.margins for cell in result.cells) else "")
    sections = [
        FigureSection("Success", lines, markup=style + "".join(_map(result))),
        *(
            _section(cell, recordings, reports, plots=number < _MOST_DRAWN)
            for number, cell in enumerate(result.cells)
        ),
    ]
    return figure_page(f"Campaign {result.name}", sections)


def _map(result: CampaignResult) -> Iterator[str]:
    """Yield a table with a field for each cell: missions down, what else differs across."""
    cells = {(cell.row, cell.column): cell for cell in result.cells}
    rows = list(dict.fromkeys(cell.row for cell in result.cells))
    columns = list(dict.fromkeys(cell.column for cell in result.cells))
    heads = "".join(f'<th scope="col">{escape(column)}</th>' for column in columns)
    yield '<div class="wide" tabindex="0">'
    yield f'<table class="heat"><thead><tr><th></th>{heads}</tr></thead><tbody>'
    for row in rows:
        fields = "".join(_field(cells.get((row, column))) for column in columns)
        yield f'<tr><th scope="row">{escape(row)}</th>{fields}</tr>'
    yield "</tbody></table></div>"


def _field(cell: CellResult | None) -> str:
    if cell is None:
        return "<td></td>"
    link = f'<a href="#{_id(cell)}">'
    if cell.share is None:
        return f'<td title="{escape(cell.name)}">{link}no runs</a></td>'
    bad = "" if cell.good else ' class="bad"'
    hue = f"background: color-mix(in srgb, var(--good-box) {100 * cell.share:.0f}%, var(--bad-box))"
    interval = f"{cell.least:.1%} – {cell.most:.1%}"
    text = (
        f"{cell.share:.1%}<small>{cell.passed:,} of {cell.runs:,}</small><small>{interval}</small>"
    )
    return f'<td{bad} style="{hue}" title="{escape(cell.name)}">{link}{text}</a></td>'


def _id(cell: CellResult) -> str:
    return escape("".join(each if each.isalnum() else "-" for each in cell.name))


def _section(
    cell: CellResult, recordings: str, reports: Mapping[str, str], *, plots: bool
) -> FigureSection:
    times = "/".join(f"{each:.1f}" for each in cell.times_s)
    lines = [
        f"{cell.summary}; {cell.held:,} passed or were held, "
        f"{cell.false:,} falsely said to have succeeded, {cell.unsafe:,} were not safe, "
        f"{cell.bugs:,} met an internal error.",
        f"Expected: {cell.expected}.",
        *([f"Missed: {', '.join(cell.missed)}."] if cell.missed else []),
    ]
    if cell.incomplete:
        lines.append(f"{cell.incomplete}.")
    if cell.not_decided:
        lines.append(f"No indices: {cell.not_decided}.")
    if times:
        lines.append(f"Mission time of those that passed, least/median/most: {times} s.")
    lines += {_HOW_TO_READ[each.method] for each in cell.decided if each.numbers}
    lines += [HOW_TO_READ] if cell.margins else []
    anchor = f'<a id="{_id(cell)}"></a>'
    causes = "".join(_causes(cell, recordings, reports))
    shown = tuple(_plots(cell)) if plots else ()
    drawn = margins_markup(cell.margins, cell.maps) if plots else ""
    return FigureSection(cell.name, lines, markup=anchor + drawn + causes, plots=shown)


_ANY_BAR = (
    "The bar goes to the side to which more of the number moves the outcome; the line is the"
    " interval within which the bar ends."
)
_HOW_TO_READ = {
    "sobol": (
        "How long a bar is says which share of the outcome's variance a number has part in; the"
        f" darker part of it is due to that number alone, without the others. {_ANY_BAR}"
    ),
    "morris": (
        "How long a bar is says by how much the outcome changes on average, up or down, over the"
        f" whole range of a number. {_ANY_BAR}"
    ),
}
"""What indices of Sobol and of Morris mean (Saltelli et al. 2010; Campolongo et al. 2007)."""


def _plots(cell: CellResult) -> Iterator[Plot]:
    """Yield what decides, success against each factor that is drawn, and how long runs took."""
    yield from (_tornado(each) for each in cell.decided if each.numbers)
    yield from map(_against, cell.factors)
    if cell.took is not None:
        yield _histogram(cell.took)


def _against(factor: FactorResult) -> Plot:
    """Return the share of runs that passed in each part of a factor's range, with its interval."""
    unit, scale = _UNITS.get(factor.unit, (factor.unit, 1.0))
    known = [part for part, runs in enumerate(factor.runs) if runs]
    middles = [scale * sum(factor.edges[part : part + 2]) / 2 for part in known]
    interval = PlotSeries(
        "",
        middles,
        [100 * factor.least[part] for part in known],
        "band",
        upper=[100 * factor.most[part] for part in known],
    )
    shares = [100 * factor.passed[part] / factor.runs[part] for part in known]
    name = _plain(factor.name.removesuffix("_m"))
    return Plot(
        f"Success against {name}",
        f"{'difference from the files' if factor.name in FROM_FILES else name}, {unit}",
        "passed, %",
        (interval, PlotSeries("", middles, shares), PlotSeries("", middles, shares, "dots")),
    )


def _tornado(found: Decided) -> Plot:
    """Return how much each number decides, the most at the top, to the side to which it moves it.

    A number's own share of the variance is darker than what it decides with others.
    """
    bars = list[PlotSeries]()
    shown = found.numbers[:_MOST_BARS][::-1]
    for row, each in enumerate(shown):
        side = -1.0 if each.correlation < 0.0 else 1.0
        size, half_width = each.size
        for length in (size, max(each.indices.get("first", 0.0), 0.0)):
            below, above = [row - _HALF_BAR] * 2, [row + _HALF_BAR] * 2
            bars.append(PlotSeries("", [0.0, side * length], below, "band", upper=above))
        ends = [side * max(size - half_width, 0.0), side * (size + half_width)]
        bars.append(PlotSeries("", ends, [row] * 2))
    size_name, *_ = found.numbers[0].indices
    unit = f", {found.unit}" if found.method == "morris" and found.unit else ""
    index = f"{size_name.replace('_', ' ')} index" if found.method == "sobol" else "mu*"
    names = tuple(_plain(each.name) for each in shown)
    label = f"less ← {index}{unit} → more {found.outcome}"
    return Plot(f"What decides {found.outcome}", label, "", tuple(bars), y_names=names)


def _plain(name: str) -> str:
    """Return the name of a number of the robot as it is read: ``bend stall torque``."""
    for group in ("motors.", "joints."):
        name = name.removeprefix(group)
    return name.replace(".", " ").replace("_", " ")


def _histogram(took: TimeCounts) -> Plot:
    """Return how many runs have taken how long, those that passed and the others."""
    edges_s = [edge for edge in took.edges_s for _ in range(2)]
    counts = (("passed", took.passed, 0), ("did not pass", took.others, 1))
    series = [
        PlotSeries(name, edges_s, [0, *(n for n in bars for _ in range(2)), 0], colour=colour)
        for name, bars, colour in counts
        if any(bars)
    ]
    return Plot("Mission time", "time, s", "runs", tuple(series))


def _causes(cell: CellResult, recordings: str, reports: Mapping[str, str]) -> Iterator[str]:
    if not cell.causes:
        return
    yield (
        '<table class="causes"><thead><tr><th>runs</th><th>verdict</th><th>why</th><th>seeds</th>'
        "<th>again</th></tr></thead><tbody>"
    )
    for cause in cell.causes:
        yield (
            f"<tr><td>{cause.count:,}</td><td>{cause.verdict}</td><td>{escape(cause.why)}</td>"
            f"<td>{_seeds(cause)}</td><td><code>{escape(cause.command)}</code>"
            f"{_links(cause, recordings, reports)}</td></tr>"
        )
    yield "</tbody></table>"


def _seeds(cause: CauseResult) -> str:
    more = ", …" if cause.count > _MOST_SEEDS else ""
    numbers = f"; numbers of seed {cause.seeds[0]}" if cause.varies else ""
    return ", ".join(map(str, cause.seeds[:_MOST_SEEDS])) + more + numbers


def _links(cause: CauseResult, recordings: str, reports: Mapping[str, str]) -> str:
    """Return links to the recordings of a cause's runs, and to their reports."""
    lines = []
    for seed, place in cause.recordings.items():
        name = quote(place.rpartition("/")[2])
        links = f'<a href="{escape(quote(recordings))}/{name}">recording</a>'
        if place in reports:
            links = f'<a href="{escape(reports[place])}">report</a>, {links}'
        lines.append(f"<br>seed {seed}: {links}")
    return "".join(lines)
