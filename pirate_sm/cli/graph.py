"""`pirate graph`: a robot's chart or a mission as a picture."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from pirate_sm.cli.run import read_pairs
from pirate_sm.drawing.chart_graph import chart_graph
from pirate_sm.drawing.dot import dot
from pirate_sm.drawing.highlight import Stop, highlight
from pirate_sm.drawing.mermaid import mermaid
from pirate_sm.drawing.mission_graph import called_missions, mission_graph
from pirate_sm.drawing.model import Graph
from pirate_sm.drawing.svg.picture import svg
from pirate_sm.errors import UsageError
from pirate_sm.loading import library
from pirate_sm.loading.chart_outline import outline_chart
from pirate_sm.loading.folders import PROFILE_FILE, shown
from pirate_sm.loading.mission import load_mission
from pirate_sm.loading.problems import Problems
from pirate_sm.loading.robot import load_robot
from pirate_sm.loading.source import Document, read_document
from pirate_sm.spelling import nearest, one_of

WRITERS: dict[str, Callable[[Graph], str]] = {"mermaid": mermaid, "dot": dot, "svg": svg}
_BY_SUFFIX = {".svg": "svg", ".dot": "dot", ".gv": "dot", ".mmd": "mermaid", ".mermaid": "mermaid"}


@dataclass(frozen=True)
class GraphWishes:
    """Is what the command line asked for."""

    what: str
    format: str | None
    output: Path | None
    path: str | None
    calls: bool
    settings: list[str]
    counterexample: Path | None = None


def run_graph(wishes: GraphWishes) -> int:
    """The drawing stands in the file, or on standard output.

    Raises:
        LoadError: The files have faults.
        UsageError: There is no such mission, robot or chart, or nothing of a name to mark.
    """
    graph = _graph(wishes)
    if wishes.counterexample is not None:
        if wishes.path is not None:
            raise UsageError("--highlight and --counterexample exclude each other")
        graph = highlight(graph, _played(wishes, wishes.counterexample))
    elif wishes.path is not None:
        stops = [stop.strip() for stop in wishes.path.split(",")]
        graph = highlight(graph, [stop for stop in stops if stop])
    kind = wishes.format or _BY_SUFFIX.get(wishes.output.suffix if wishes.output else "", "")
    text = WRITERS[kind or "mermaid"](graph)
    if wishes.output is None:
        sys.stdout.write(text)
        return 0
    try:
        wishes.output.write_text(text, encoding="utf-8")
    except OSError as error:
        raise UsageError(f"'{wishes.output}' cannot be written: {error.strerror}") from None
    return 0


def _played(wishes: GraphWishes, script: Path) -> list[Stop]:
    from pirate_sm.cli.played import played_path  # the runtime is not needed for a plain drawing

    settings = read_pairs("--set", wishes.settings, "NAME=VALUE")
    return played_path(_found(wishes.what), script, settings)


def _graph(wishes: GraphWishes) -> Graph:
    path = _found(wishes.what)
    if wishes.counterexample is not None and not _is_mission(path):
        raise UsageError(f"'{wishes.what}' is no mission: no course of events leads through it")
    if path.name == PROFILE_FILE or path.is_dir():
        robot = load_robot(library.find_robot(str(path), Path.cwd()))
        return _chart(robot.documents[1], robot.profile.robot)
    document = read_document(path, shown(path))
    if isinstance(document.data, dict) and "states" in document.data:
        return _chart(document, str(document.data.get("name") or path.stem))
    if isinstance(document.data, dict) and "segments" in document.data:
        raise UsageError(f"'{wishes.what}' is a pipe: expected a mission, a robot or a chart")
    loaded = load_mission(path, settings=read_pairs("--set", wishes.settings, "NAME=VALUE"))
    called = called_missions(loaded.mission, path) if wishes.calls else ()
    return mission_graph(loaded.mission, called)


def _is_mission(path: Path) -> bool:
    if path.name == PROFILE_FILE or path.is_dir():
        return False
    data = read_document(path, shown(path)).data
    return isinstance(data, dict) and "phases" in data


def _found(what: str) -> Path:
    """The file or the robot's folder that is meant: by its path, or by its name."""
    path = Path(what)
    if path.is_dir() or path.is_file():
        return path
    if "/" in what or path.suffix:
        return library.find_mission(what)
    known = {robot.name: robot for robot in library.robots()}
    known |= {mission.stem: mission for mission in library.missions()}
    if what in known:
        return known[what]
    close = nearest(what, known)
    hint = f"did you mean '{close}'?" if close else f"expected {one_of(sorted(known))}"
    raise UsageError(f"there is no mission, robot or file '{what}'; {hint}")


def _chart(document: Document, title: str) -> Graph:
    problems = Problems(document)
    outline = outline_chart(document, problems)
    problems.raise_errors()
    if outline is None:
        raise AssertionError("an outline is missing only beside a problem")
    return chart_graph(outline, title)
