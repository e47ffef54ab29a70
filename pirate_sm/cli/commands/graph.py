"""`pirate graph`: draws a robot's chart, a mission or a pipe, or writes one as SCXML."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from pirate_sm.cli.options.declaring import read_settings
from pirate_sm.cli.options.files import GraphOptions
from pirate_sm.cli.output.files import refuse_losses, write_or_print
from pirate_sm.core import library
from pirate_sm.core.documents import Document, Problems, read_document
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import PROFILE_FILE
from pirate_sm.core.loading import (
    ChartOutline,
    LoadedMission,
    check_pipe,
    load_mission,
    load_pipe,
    load_robot,
    outline_chart,
)
from pirate_sm.core.models import Pipe
from pirate_sm.core.on_disk import is_file, is_folder
from pirate_sm.core.spelling import meant
from pirate_sm.views.drawing.graph.graph import Graph, chart_graph, pipe_graph
from pirate_sm.views.drawing.graph.highlight import Stop, highlight
from pirate_sm.views.drawing.graph.mission_graph import called_missions, mission_graph
from pirate_sm.views.drawing.pipe_plan import plan_svg
from pirate_sm.views.drawing.svg.svg_writer import svg
from pirate_sm.views.drawing.text_formats import dot, mermaid
from pirate_sm.views.interchange.scxml import chart_scxml, mission_scxml

WRITERS: dict[str, Callable[[Graph], str]] = {"mermaid": mermaid, "dot": dot, "svg": svg}


_PIPES_HAVE = ("segments", "runs")


_SCXML = "scxml"


_BY_SUFFIX = {
    **{".svg": "svg", ".dot": "dot", ".gv": "dot", ".mmd": "mermaid", ".mermaid": "mermaid"},
    ".scxml": _SCXML,
}


class _Chart(NamedTuple):
    outline: ChartOutline
    name: str
    description: str


def draw_graph(options: GraphOptions) -> int:
    """Write the drawing to the file, or to standard output; return the exit code.

    Raises:
        LoadError: The files have errors.
        UsageError: There is no such mission, robot or chart, or no such node to mark.
    """
    kind = options.format or _kind(options.output)
    if options.output is not None:
        script = [options.counterexample] if options.counterexample is not None else []
        inputs = [_found(options.file), *script]
        refuse_losses([options.output], inputs=inputs, overwrite=options.overwrite)
    write_or_print(options.output, _text(options, kind))
    return 0


def _text(options: GraphOptions, kind: str) -> str:
    """Return the drawing; that of a pipe is a plan to scale where it can be one."""
    if kind == _SCXML:
        return _scxml(options)
    if kind == "svg" and options.path is None and options.counterexample is None:
        path = _found(options.file)
        content = _content(path, options)
        if isinstance(content, Pipe):
            return plan_svg(content, content.pipe or path.stem)
    return WRITERS[kind](_marked(options))


def _kind(output: Path | None) -> str:
    """Return the format that the ending of a name stands for.

    Raises:
        UsageError: It stands for none.
    """
    if output is None or not output.suffix:
        return "mermaid"
    kind = _BY_SUFFIX.get(output.suffix.lower())
    if kind is None:
        known = ", ".join(_BY_SUFFIX)
        raise UsageError(
            f"'{output}': no drawing ends in '{output.suffix}'; possible are {known}, "
            "or say the --format"
        )
    return kind


def _marked(options: GraphOptions) -> Graph:
    graph = _graph(options)
    if options.counterexample is not None:
        if options.path is not None:
            raise UsageError("--highlight and --counterexample exclude each other")
        return highlight(graph, _counterexample(options, options.counterexample))
    if options.path is not None:
        stops = [stop.strip() for stop in options.path.split(",")]
        return highlight(graph, [stop for stop in stops if stop])
    return graph


def _scxml(options: GraphOptions) -> str:
    given = {
        "--calls": options.calls,
        "--highlight": options.path is not None,
        "--counterexample": options.counterexample is not None,
    }
    for option, is_given in given.items():
        if is_given:
            raise UsageError(f"SCXML has no place for {option}: it is for drawings")
    content = _content(_found(options.file), options)
    if isinstance(content, _Chart):
        return chart_scxml(content.outline, content.name, content.description)
    if isinstance(content, LoadedMission):
        return mission_scxml(content.mission)
    raise UsageError(f"'{options.file}' is a pipe; SCXML is for charts and missions")


def _counterexample(options: GraphOptions, script: Path) -> list[Stop]:
    # The runtime is not needed for a plain drawing.
    from pirate_sm.cli.commands.rehearsal import phases_of_course

    settings = read_settings(options.settings)
    return phases_of_course(_found(options.file), script, settings)


def _graph(options: GraphOptions) -> Graph:
    path = _found(options.file)
    if options.counterexample is not None and not _is_mission(path):
        raise UsageError(f"'{options.file}' is not a mission: no event sequence leads through it")
    content = _content(path, options)
    if isinstance(content, _Chart):
        return chart_graph(content.outline, content.name)
    if isinstance(content, Pipe):
        return pipe_graph(content, content.pipe or path.stem)
    called = called_missions(content.mission, path) if options.calls else ()
    return mission_graph(content.mission, called)


def _content(path: Path, options: GraphOptions) -> _Chart | Pipe | LoadedMission:
    """Return what is to be drawn.

    Raises:
        LoadError: The files have errors.
    """
    if path.name == PROFILE_FILE or is_folder(path):
        robot = load_robot(library.find_robot(str(path), Path.cwd()))
        return _chart(robot.documents[1], robot.profile.robot)
    document = read_document(path)
    if isinstance(document.data, dict) and "states" in document.data:
        return _chart(document, str(document.data.get("name") or path.stem))
    if isinstance(document.data, dict) and not document.data.keys().isdisjoint(_PIPES_HAVE):
        return _pipe(path)
    return load_mission(path, settings=read_settings(options.settings))


def _pipe(path: Path) -> Pipe:
    pipe, document = load_pipe(path)
    problems = Problems(document)
    check_pipe(pipe, document, problems)
    problems.raise_errors()
    return pipe


def _is_mission(path: Path) -> bool:
    if path.name == PROFILE_FILE or is_folder(path):
        return False
    data = read_document(path).data
    return isinstance(data, dict) and "phases" in data


def _found(what: str) -> Path:
    """Return the file or the robot's folder with this path or name."""
    path = Path(what)
    if is_folder(path) or is_file(path):
        return path
    if "/" in what or path.suffix:
        try:
            return library.find_mission(what)
        except UsageError:
            raise UsageError(f"there is no mission, robot or pipe at '{what}'") from None
    known = {robot.name: robot for robot in library.robots()}
    known |= {pipe.stem: pipe for pipe in library.pipes()}
    known |= {mission.stem: mission for mission in library.missions()}
    if what in known:
        return known[what]
    near = library.file_nearby(what, [Path()])
    hint = f"did you mean '{near}'?" if near is not None else meant(what, sorted(known))
    raise UsageError(f"there is no mission, robot, pipe or file '{what}'; {hint}")


def _chart(document: Document, name: str) -> _Chart:
    problems = Problems(document)
    outline = outline_chart(document, problems)
    problems.raise_errors()
    if outline is None:
        raise AssertionError("an outline is missing only beside a problem")
    return _Chart(outline, name, document.data.get("description", ""))
