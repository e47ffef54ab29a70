"""How far a mission holds, for its page: from results of margins that are of the same files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from html import escape
from importlib.util import find_spec
from pathlib import Path

from pirate_sm.core.errors import PirateError, not_installed
from pirate_sm.lab.campaign.conductor import stored, stored_plan
from pirate_sm.lab.campaign.margins_page import HOW_TO_READ, MARGINS_STYLE, margins_markup
from pirate_sm.lab.campaign.plan import Cell, code_version, key_of
from pirate_sm.lab.campaign.results import CellResult, result_of
from pirate_sm.lab.campaign.store import Store
from pirate_sm.running.wiring import Order, load
from pirate_sm.views.report.figure_page import FigureSection

_TITLE = "How far it holds"


def known_margins(folder: Path, mission: Order) -> Iterator[FigureSection]:
    """Yield how far a mission holds, as far as results in a folder say it.

    Of results of other files nothing is shown, but that they are of others.

    Args:
        folder: The folder of a campaign's results.
        mission: The mission, its robot and its pipe; what else a run has is that of the results.
    """
    try:
        yield from _sections(folder, mission)
    except PirateError as error:
        yield FigureSection(_TITLE, [str(error)])


def _sections(folder: Path, mission: Order) -> Iterator[FigureSection]:
    plan = stored_plan(Store(folder))
    if plan.margins is None:
        return
    cells = [each.key for each in plan.cells if _is_of(each, mission, plan.version)]
    if not cells:
        yield FigureSection(_TITLE, [_others(folder, plan.cells, plan.version)])
        return
    if find_spec("pyarrow") is None:
        raise not_installed("the results of margins", "pyarrow", "campaign")
    plan, tallies, damaged, margins = stored(folder)
    found = result_of(plan, tallies, folder, margins).cells
    by = f"Found by {plan.version}"
    if plan.version != code_version():
        by += ", another version of this program than the one that shows it"
    for cell, result in zip(plan.cells, found, strict=False):
        if cell.key in cells:
            yield _section(result, [f"{by}; the results are in '{folder}'.", *damaged])


def _is_of(cell: Cell, mission: Order, version: str) -> bool:
    """Return whether the runs of a cell were of this mission, by the text of all its files."""
    here = replace(cell.order, mission=mission.mission, robot=mission.robot, pipe=mission.pipe)
    try:
        return key_of(here, load(here), cell.end, cell.design, version) == cell.key
    except PirateError:  # such as a parameter that this mission does not have
        return False


def _others(folder: Path, cells: tuple[Cell, ...], version: str) -> str:
    """Return that results are of other files, and why they are."""
    names = ", ".join(each.name for each in cells[:3])
    of = f"Not known: the results in '{folder}' ({names}) are of"
    if any(_is_of(each, each.order, version) for each in cells):
        return f"{of} another mission, another robot or another pipe."
    return f"{of} an earlier text of the mission, its robot or its pipe; `pirate margins` finds it."


def _section(cell: CellResult, lines: list[str]) -> FigureSection:
    about = [f"With the values of the files: {cell.summary}."]
    about += [f"{cell.incomplete}."] if cell.incomplete else []
    words = "".join(
        f"<li><b>{escape(each.name)}</b> {escape(each.words)}</li>" for each in cell.margins
    )
    return FigureSection(
        f"{_TITLE}: {cell.column}" if cell.column else _TITLE,
        [*about, *lines, *([HOW_TO_READ] if cell.margins else [])],
        markup=f"{MARGINS_STYLE}<ul>{words}</ul>{margins_markup(cell.margins, cell.maps)}",
    )
