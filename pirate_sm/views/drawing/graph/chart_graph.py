"""A robot's statechart as a graph: a cluster for each region, an edge for each transition."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator

from pirate_sm.core.loading import ChartOutline, ChartTransition
from pirate_sm.views.drawing.graph.graph import (
    Cluster,
    Edge,
    EdgeKind,
    Graph,
    GraphNote,
    Node,
    NodeKind,
)

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
    nodes = tuple(node for place in range(len(outline.regions)) for node in _nodes(outline, place))
    starts = tuple(
        Edge(f"{region}.{START}", f"{region}.{initial}", EdgeKind.START)
        for region, initial in zip(outline.regions, outline.initial, strict=True)
    )
    edges = tuple(_edge(transition, marks) for transition in outline.transitions)
    return Graph(title, clusters, nodes, starts + edges, notes=tuple(marks.values()))


def _nodes(outline: ChartOutline, place: int) -> Iterator[Node]:
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


def _edge(transition: ChartTransition, marks: dict[str, GraphNote]) -> Edge:
    guard = " ".join(_IN.sub(r"\2", transition.guard).split())
    label, tooltip = transition.event, ""
    if guard:
        tooltip = f"{transition.event} [{guard}]"
        short = guard
        if len(guard) > LONGEST_GUARD:
            short = marks.setdefault(guard, GraphNote(f"guard {len(marks) + 1}", guard)).mark
        label = f"{transition.event} [{short}]"
    return Edge(transition.source, transition.target, EdgeKind.TRIGGER, label, tooltip)
