"""The result of a campaign as one HTML page that loads no other file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from urllib.parse import quote

from pirate_sm.campaign.results import CampaignResult, CauseResult, CellResult
from pirate_sm.report.figure_page import FigureSection, figure_page

_STYLE = """<style>
.wide { overflow-x: auto; }
.heat td { text-align: center; border: 1px solid var(--border); min-width: 90px; }
.heat .bad { outline: 2px solid var(--bad); outline-offset: -2px; }
.heat small { display: block; color: var(--soft); }
.causes code { font-size: 12px; user-select: all; }
</style>"""

_MOST_SEEDS = 20


def page_of(result: CampaignResult, recordings: str, damaged: Sequence[str] = ()) -> str:
    """Return the page: a map of all cells, and each cell with its interval and its causes.

    Args:
        result: The result.
        recordings: The folder of the recordings, as seen from the page.
        damaged: What is wrong with files of results that cannot be read.
    """
    lines = [
        f"{result.summary}. Run with {result.version}; intervals of {result.confidence:.0%} "
        "(Wilson).",
        *damaged,
        *(f"{name}: not run, a cell before it is not as expected" for name in result.left_out),
    ]
    sections = [
        FigureSection("Success", lines, markup=_STYLE + "".join(_map(result))),
        *(_section(cell, recordings) for cell in result.cells),
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


def _section(cell: CellResult, recordings: str) -> FigureSection:
    times = "/".join(f"{each:.1f}" for each in cell.times_s)
    lines = [
        f"{cell.summary}; {cell.held:,} passed or were held, "
        f"{cell.false:,} falsely said to have succeeded, {cell.unsafe:,} were not safe, "
        f"{cell.bugs:,} met a fault in this program.",
        f"Expected: {cell.expected}.",
        *([f"Missed: {', '.join(cell.missed)}."] if cell.missed else []),
    ]
    if cell.incomplete:
        lines.append(f"{cell.incomplete}.")
    if times:
        lines.append(f"Mission time of those that passed, least/median/most: {times} s.")
    anchor = f'<a id="{_id(cell)}"></a>'
    return FigureSection(cell.name, lines, markup=anchor + "".join(_causes(cell, recordings)))


def _causes(cell: CellResult, recordings: str) -> Iterator[str]:
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
            f"{_link(cause, recordings)}</td></tr>"
        )
    yield "</tbody></table>"


def _seeds(cause: CauseResult) -> str:
    more = ", …" if cause.count > _MOST_SEEDS else ""
    numbers = f"; numbers of seed {cause.seeds[0]}" if cause.varies else ""
    return ", ".join(map(str, cause.seeds[:_MOST_SEEDS])) + more + numbers


def _link(cause: CauseResult, recordings: str) -> str:
    if not cause.recording:
        return ""
    name = quote(cause.recording.rpartition("/")[2])
    return f'<br><a href="{escape(quote(recordings))}/{name}">recording</a>'
