"""A mission before its run as one page: what the check finds, its diagram, its pipe, its lines."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from html import escape
from pathlib import Path

from pirate_sm.checking.check_project import check_paths
from pirate_sm.checking.file_part import Wishes
from pirate_sm.checking.findings import Finding
from pirate_sm.core.documents import LoadError
from pirate_sm.core.errors import PirateError
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.views.drawing.graph.mission_graph import mission_graph
from pirate_sm.views.drawing.pipe_plan import plan_svg
from pirate_sm.views.drawing.svg.svg_writer import svg
from pirate_sm.views.report.figure_page import FigureSection, figure_page
from pirate_sm.views.report.phase_lines import phase_lines


def mission_page(
    path: Path,
    robot: str | None = None,
    pipe: str | None = None,
    known: Callable[[], Iterable[FigureSection]] = tuple,
) -> str:
    """Return the page as HTML; of a mission that cannot be loaded, with what is wrong.

    Args:
        path: The file of the mission.
        robot: The robot, instead of the mission's own.
        pipe: The pipe, instead of the mission's own.
        known: Returns what else is known of the mission, which is shown if it can be loaded.
    """
    try:
        return _page(path, robot, pipe, known)
    except (PirateError, OSError) as error:  # such as a file that has been removed since
        return figure_page(path.name, [FigureSection("It cannot be shown", [str(error)])])


def _page(
    path: Path,
    robot: str | None,
    pipe: str | None,
    known: Callable[[], Iterable[FigureSection]],
) -> str:
    findings = check_paths([str(path)], Wishes(robot=robot, pipe=pipe)).open
    try:
        loaded = load_mission(path, robot=robot, pipe=pipe)
    except LoadError:
        loaded = None
    title = path.stem if loaded is None else loaded.mission.mission
    parts = [_check(path, findings), *([] if loaded is None else (*_drawn(loaded), *known()))]
    return figure_page(f"{title}: before its run", [*parts, _listing(path, findings)])


def _check(path: Path, findings: tuple[Finding, ...]) -> FigureSection:
    rows = "".join(
        f"<tr><th>{_line(path, each)}</th><th>{each.severity.word}</th>"
        f"<td>{escape(each.message)} [{escape(each.code)}]{_how(each)}</td></tr>"
        for each in findings
    )
    found = "Nothing is wrong." if not findings else "A line leads to its place in the file below."
    return FigureSection(
        "What the check finds", [found], markup=f"<table>{rows}</table>" if rows else ""
    )


def _line(path: Path, finding: Finding) -> str:
    """Return where a finding is; in the mission's own file it leads there."""
    place = finding.place
    if not _is_in(path, finding):
        return escape(f"{Path(place.file).name}:{place.line}")
    return f'<a href="#L{place.line}">line {place.line}</a>'


def _is_in(path: Path, finding: Finding) -> bool:
    return os.path.realpath(finding.place.file) == os.path.realpath(path)


def _how(finding: Finding) -> str:
    steps = "".join(f"<li>{escape(each)}</li>" for each in finding.story)
    return f"<details><summary>How it happens</summary><ol>{steps}</ol></details>" if steps else ""


def _drawn(loaded: LoadedMission) -> Iterator[FigureSection]:
    mission = loaded.mission
    lines = phase_lines(loaded.documents[0], mission)
    links = {name: f"#L{each.line}" for name, each in lines.items()}
    where = f"On {loaded.robot.name}" + (f", in pipe {loaded.pipe.pipe}" if loaded.pipe else "")
    about = [mission.description] if mission.description else []
    yield FigureSection(
        "The mission",
        [*about, f"{where}. A phase leads to its lines in the file below."],
        markup=svg(mission_graph(mission), links),
    )
    if loaded.pipe is not None:
        drawing = plan_svg(loaded.pipe, loaded.pipe.pipe or "pipe")
        yield FigureSection("The pipe, to scale", markup=drawing)


def _listing(path: Path, findings: tuple[Finding, ...]) -> FigureSection:
    worst: dict[int, Finding] = {}
    for each in sorted(findings, key=lambda each: each.severity):
        if _is_in(path, each):
            worst[each.place.line] = each
    rows = []
    text = path.read_text("utf-8", errors="replace")
    for number, line in enumerate(text.splitlines(), 1):
        found = worst.get(number)
        mark = f' class="{found.severity.word}" title="{escape(found.message)}"' if found else ""
        rows.append(f'<li id="L{number}"{mark}>{escape(line)}</li>')
    return FigureSection(path.name, markup=f'<ol class="listing">{"".join(rows)}</ol>')
