"""The content of a drawing, whatever its source and format; robots' charts and pipes as graphs."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from math import degrees

from pirate_sm.core.errors import PirateError
from pirate_sm.core.geometry import BRANCH, ON, port_of
from pirate_sm.core.loading import ChartOutline, ChartTransition
from pirate_sm.core.models import Pipe, PipeRun, Straight
from pirate_sm.views.drawing.wrapping import wrapped

# --- graphs -------------------------------------------------------------------------------------


class NodeKind(StrEnum):
    """The meaning of a node."""

    INITIAL = "initial"
    ANYWHERE = "anywhere"
    """Any current node: edges from it leave from every node of the cluster."""
    PHASE = "phase"
    STATE = "state"
    SUCCEED = "succeed"
    FAIL = "fail"


_SIGNS = {NodeKind.SUCCEED: "✓ ", NodeKind.FAIL: "✗ "}


class EdgeKind(StrEnum):
    """The reason for an edge."""

    START = "start"
    GO = "go"
    TRIGGER = "trigger"
    WITHIN = "within"
    FAILURE = "failure"
    FAULT = "fault"


@dataclass(frozen=True, slots=True)
class Node:
    """A node of the graph.

    Attributes:
        id: Unique id; :func:`pirate_sm.views.drawing.graph.highlight.highlight` uses it.
        title: Its name for readers.
        lines: Its actions, in order; a line is indented by spaces.
        tooltip: Details.
        cluster: Id of its cluster.
        visits: Numbers of the visits, from 1; empty if it was not visited.
        current: Whether the path ends here.
    """

    id: str
    kind: NodeKind
    title: str = ""
    lines: tuple[str, ...] = ()
    tooltip: str = ""
    cluster: str = ""
    visits: tuple[int, ...] = ()
    current: bool = False

    @property
    def heading(self) -> str:
        """Its title, after the numbers of its visits and the sign of an end."""
        visits = f"({', '.join(map(str, self.visits))}) " if self.visits else ""
        return f"{visits}{_SIGNS.get(self.kind, '')}{self.title}"


@dataclass(frozen=True, slots=True)
class Edge:
    """An edge from a node to another of the same cluster, or to itself.

    Attributes:
        label: When it is taken.
        tooltip: The same in full, if the label is shortened.
        taken: The numbers of the visits that it led to.
    """

    source: str
    target: str
    kind: EdgeKind
    label: str = ""
    tooltip: str = ""
    taken: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Cluster:
    """A group of nodes; a cluster without a title has no frame."""

    id: str
    title: str = ""
    tooltip: str = ""


@dataclass(frozen=True, slots=True)
class GraphNote:
    """The full text for a label that refers to it by its mark."""

    mark: str
    text: str


@dataclass(frozen=True)
class Graph:
    """A whole drawing, with nodes and edges in reading order.

    Raises:
        GraphError: An id occurs twice, or a reference leads nowhere.
    """

    title: str
    clusters: tuple[Cluster, ...]
    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...]
    description: str = ""
    notes: tuple[GraphNote, ...] = ()

    def note_lines(self, columns: int) -> tuple[str, ...]:
        """Return the notes, each after its mark, in lines of so many columns."""
        texts = [f"{note.mark}: {note.text}" for note in self.notes]
        return tuple(line for text in texts for line in wrapped(text, columns))

    def __post_init__(self) -> None:
        home = {node.id: node.cluster for node in self.nodes}
        clusters = {cluster.id for cluster in self.clusters}
        if len(home) < len(self.nodes) or len(clusters) < len(self.clusters):
            raise GraphError("two nodes or two clusters have the same id")
        if not clusters.issuperset(home.values()):
            raise GraphError("a node stands in a cluster that is not there")
        for edge in self.edges:
            if home.get(edge.source, edge.source) != home.get(edge.target, edge.target):
                raise GraphError(f"'{edge.source}' and '{edge.target}' are not in one cluster")
            if edge.source not in home:
                raise GraphError(f"there is no node '{edge.source}'")


class GraphError(PirateError):
    """Is raised for an inconsistent graph, which is an internal error."""


# --- charts -------------------------------------------------------------------------------------


START = "(start)"
LONGEST_GUARD = 24
"""Guards up to this length are written out; longer ones become a note."""

_IN = re.compile(r"In\(\s*(['\"])(.*?)\1\s*\)")


def chart_graph(outline: ChartOutline, title: str) -> Graph:
    """Return the graph of a chart; a state's id is ``Region.State``.

    Guards are written without their ``In('…')``. Long ones are numbered, each different one once:
    the label has the number, the graph's notes the text.
    """
    marks: dict[str, GraphNote] = {}
    clusters = tuple(Cluster(region, region) for region in outline.regions)
    nodes = tuple(
        node for place in range(len(outline.regions)) for node in _state_nodes(outline, place)
    )
    starts = tuple(
        Edge(f"{region}.{START}", f"{region}.{initial}", EdgeKind.START)
        for region, initial in zip(outline.regions, outline.initial, strict=True)
    )
    edges = tuple(_transition(transition, marks) for transition in outline.transitions)
    return Graph(title, clusters, nodes, starts + edges, notes=tuple(marks.values()))


def _state_nodes(outline: ChartOutline, place: int) -> Iterator[Node]:
    """Yield the region's states, the nearest to its initial one first."""
    region = outline.regions[place]
    yield Node(f"{region}.{START}", NodeKind.INITIAL, "start", cluster=region)
    for state in _by_distance(outline, place):
        yield Node(f"{region}.{state}", NodeKind.STATE, state, cluster=region)


def _by_distance(outline: ChartOutline, place: int) -> list[str]:
    region, first = outline.regions[place], outline.initial[place]
    following: dict[str, list[str]] = {}
    for transition in outline.transitions:
        if transition.region == region:
            following.setdefault(transition.source, []).append(transition.target)
    distance = {f"{region}.{first}": 0}
    queue = deque(distance)
    while queue:
        state = queue.popleft()
        for target in following.get(state, ()):
            if target not in distance:
                distance[target] = distance[state] + 1
                queue.append(target)
    states = outline.states[place]
    return sorted(states, key=lambda state: distance.get(f"{region}.{state}", len(states)))


def _transition(transition: ChartTransition, marks: dict[str, GraphNote]) -> Edge:
    guard = " ".join(_IN.sub(r"\2", transition.guard).split())
    label, tooltip = transition.event, ""
    if guard:
        tooltip = f"{transition.event} [{guard}]"
        short = guard
        if len(guard) > LONGEST_GUARD:
            short = marks.setdefault(guard, GraphNote(f"guard {len(marks) + 1}", guard)).mark
        label = f"{transition.event} [{short}]"
    return Edge(transition.source, transition.target, EdgeKind.TRIGGER, label, tooltip)


# --- pipes --------------------------------------------------------------------------------------


_PIPE = "pipe"
_PORTS = {ON: "straight on", BRANCH: "branch"}


def pipe_graph(pipe: Pipe, title: str) -> Graph:
    """Return the graph of a pipe without faults; a node's id is the name of its junction or end."""
    runs = {name: each.run for name, each in pipe.written.items()}
    edges = tuple(_run(name, run, pipe.diameter) for name, run in runs.items())
    ways = tuple(
        GraphNote(f"route {name}", ", ".join(way)) for name, way in pipe.ways.items() if pipe.runs
    )
    nodes = tuple(_pipe_nodes(pipe, runs))
    return Graph(title, (Cluster(_PIPE),), nodes, edges, pipe.description, ways)


def _pipe_nodes(pipe: Pipe, runs: dict[str, PipeRun]) -> Iterator[Node]:
    """Yield the junctions and ends in the order in which runs name them."""
    names = [port_of(at)[0] for run in runs.values() for at in (run.from_port, run.to)]
    closed = pipe.network().closed
    for name in dict.fromkeys(names):
        if name in pipe.tees:
            line = f"tee, branch at {_deg(pipe.tees[name])}"
            yield Node(name, NodeKind.STATE, name, (line,), cluster=_PIPE)
        elif names.count(name) > 1:
            yield Node(name, NodeKind.STATE, name, cluster=_PIPE)
        else:
            kind = NodeKind.STATE if name in closed else NodeKind.ANYWHERE
            end = "closed end" if name in closed else "open end"
            yield Node(name, kind, name, (end,), cluster=_PIPE)


def _run(name: str, run: PipeRun, diameter_m: float) -> Edge:
    (source, out), (target, into) = port_of(run.from_port), port_of(run.to)
    ports = [
        f"{_PORTS[port]} of {junction}"
        for junction, port in ((source, out), (target, into))
        if port
    ]
    inside = ", ".join(each.words for each in run.segments)
    fittings = ", ".join(each.words for each in run.segments if not isinstance(each, Straight))
    head = ", ".join([name, *ports, _mm(run.diameter or diameter_m)])
    label = f"{head}: {fittings}" if fittings else head
    return Edge(source, target, EdgeKind.GO, label, f"{head}; {inside}")


def _mm(length_m: float) -> str:
    return f"{length_m:.4g} m" if length_m >= 1.0 else f"{length_m * 1e3:.4g} mm"


def _deg(angle_rad: float) -> str:
    return f"{degrees(angle_rad):.4g}°"
