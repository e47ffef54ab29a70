"""A pipe as a graph: a node for each junction and end, an edge for each run with its fittings."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees

from pirate_sm.core.geometry import BRANCH, ON, port_of
from pirate_sm.core.pipe import Elbow, Mitre, Pipe, PipeRun, Reducer, Segment, Straight
from pirate_sm.views.drawing.graph.graph import (
    Cluster,
    Edge,
    EdgeKind,
    Graph,
    GraphNote,
    Node,
    NodeKind,
)

_PIPE = "pipe"
_PORTS = {ON: "straight on", BRANCH: "branch"}


def pipe_graph(pipe: Pipe, title: str) -> Graph:
    """Return the graph of a pipe without faults; a node's id is the name of its junction or end."""
    runs = {name: each.run for name, each in pipe.written.items()}
    edges = tuple(_edge(name, run, pipe.diameter) for name, run in runs.items())
    ways = tuple(
        GraphNote(f"route {name}", ", ".join(way)) for name, way in pipe.ways.items() if pipe.runs
    )
    nodes = tuple(_nodes(pipe, runs))
    return Graph(title, (Cluster(_PIPE),), nodes, edges, pipe.description, ways)


def _nodes(pipe: Pipe, runs: dict[str, PipeRun]) -> Iterator[Node]:
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


def _edge(name: str, run: PipeRun, diameter_m: float) -> Edge:
    (source, out), (target, into) = port_of(run.from_port), port_of(run.to)
    ports = [
        f"{_PORTS[port]} of {junction}"
        for junction, port in ((source, out), (target, into))
        if port
    ]
    inside = ", ".join(map(_words, run.segments))
    fittings = ", ".join(_words(each) for each in run.segments if not isinstance(each, Straight))
    head = ", ".join([name, *ports, _mm(run.diameter or diameter_m)])
    label = f"{head}: {fittings}" if fittings else head
    return Edge(source, target, EdgeKind.GO, label, f"{head}; {inside}")


def _words(segment: Segment) -> str:
    """Return a segment in a few words."""
    match segment:
        case Straight(straight=length_m):
            return f"straight {_mm(length_m)}"
        case Mitre(mitre=angle_rad, roll=roll_rad):
            return f"mitre {_deg(angle_rad)}{_rolled(roll_rad)}"
        case Elbow(elbow=angle_rad, roll=roll_rad):
            return f"elbow {_deg(angle_rad)}{_rolled(roll_rad)}"
        case Reducer(to=to_m):
            return f"reducer to {_mm(to_m)}"


def _rolled(roll_rad: float) -> str:
    return f" rolled {_deg(roll_rad)}" if roll_rad else ""


def _mm(length_m: float) -> str:
    return f"{length_m:.4g} m" if length_m >= 1.0 else f"{length_m * 1e3:.4g} mm"


def _deg(angle_rad: float) -> str:
    return f"{degrees(angle_rad):.4g}°"
