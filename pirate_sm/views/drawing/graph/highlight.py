"""Marks a path in a graph: that of a run, taken from its effects, or a counterexample."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TypeAlias

from pirate_sm.core import effects as fx
from pirate_sm.core.errors import UsageError
from pirate_sm.core.spelling import meant
from pirate_sm.views.drawing.graph.graph import EdgeKind, Graph, NodeKind

Stop: TypeAlias = str | tuple[str, str] | tuple[str, str, EdgeKind]


def highlight(graph: Graph, path: Sequence[Stop]) -> Graph:
    """Return the graph with the path marked: nodes numbered in order, edges marked as taken.

    A phase of a called mission that is not drawn counts as the phase that calls it. A stop
    follows the last one in its own cluster. If the drawing has no edge between them, the edge from
    any node of the cluster is taken.

    Args:
        graph: Any graph.
        path: The nodes reached, in order. ``(from, to)`` stands for both, unless the path is at the
            first already; ``(from, to, kind)`` also gives the kind of the edge between them.

    Raises:
        UsageError: The graph has no such node.
    """
    stops = _stops(graph, path)
    if not stops:
        return graph
    home = {node.id: node.cluster for node in graph.nodes}
    visits: dict[str, list[int]] = {}
    taken: dict[int, list[int]] = {}
    last: dict[str, str] = {}
    for number, (stop, kind) in enumerate(stops, 1):
        cluster = home[stop]
        visits.setdefault(stop, []).append(number)
        for place in _between(graph, cluster, last.get(cluster), stop, kind):
            taken.setdefault(place, []).append(number)
        last[cluster] = stop
    nodes = tuple(
        replace(node, visits=tuple(visits.get(node.id, ())), current=node.id == stops[-1][0])
        for node in graph.nodes
    )
    edges = tuple(
        replace(edge, taken=tuple(taken.get(place, ()))) for place, edge in enumerate(graph.edges)
    )
    return replace(graph, nodes=nodes, edges=edges)


def _between(
    graph: Graph, cluster: str, source: str | None, target: str, kind: EdgeKind | None
) -> tuple[int, ...]:
    """Return the indices of the edges that may have been taken; of the likeliest kind only."""
    hub = NodeKind.INITIAL if source is None else NodeKind.ANYWHERE
    hubs = {node.id for node in graph.nodes if node.kind is hub and node.cluster == cluster}
    direct = _edges(graph, {source or ""}, target)
    indirect = _edges(graph, hubs, target)
    for found in (direct, indirect):
        of_kind = tuple(place for place in found if graph.edges[place].kind is kind)
        if of_kind:
            return of_kind
    return direct or indirect


def _edges(graph: Graph, sources: set[str], target: str) -> tuple[int, ...]:
    return tuple(
        place
        for place, edge in enumerate(graph.edges)
        if edge.source in sources and edge.target == target
    )


def _stops(graph: Graph, path: Iterable[Stop]) -> list[tuple[str, EdgeKind | None]]:
    """Return each node reached, with the kind of edge that led to it, if known."""
    known = {node.id for node in graph.nodes}
    stops: list[tuple[str, EdgeKind | None]] = []
    for stop in path:
        names = (stop,) if isinstance(stop, str) else stop[:2]
        kind = stop[2] if len(stop) == 3 and not isinstance(stop, str) else None
        for place, name in enumerate(names):
            found = _shown(name, known)
            if found is None:
                raise UsageError(_unknown(graph, name))
            leads = place + 1 == len(names)
            there = bool(stops) and stops[-1][0] == found
            if not (there and (found != name or not leads)):
                stops.append((found, kind if leads else None))
    return stops


def _shown(name: str, known: set[str]) -> str | None:
    """Return the node with this name, or that of the phase that calls it."""
    while name not in known and "/" in name:
        name = name.rpartition("/")[0]
    return name if name in known else None


def _unknown(graph: Graph, name: str) -> str:
    hidden = {NodeKind.INITIAL, NodeKind.ANYWHERE}
    names = [node.id for node in graph.nodes if node.kind not in hidden]
    return f"{graph.title} has no '{name}' to mark: {meant(name, names)}"


class RunPath:
    """Records the phases that a run reaches, and by which kind of edge.

    Attributes:
        stops: For :func:`pirate_sm.views.drawing.graph.highlight.highlight`.
    """

    def __init__(self) -> None:
        self.stops: list[Stop] = []
        self._here = ""
        self._kind: EdgeKind | None = None

    def see(self, effects: Sequence[fx.Effect], now_s: float) -> None:
        """Note the phases and the end that the effects reach."""
        for effect in effects:
            match effect:
                case fx.PhaseChange(phase=phase):
                    self._reach(phase)
                case fx.Ended(end=end) if end:
                    self._reach(end)
                case fx.TriggerFired(trigger=trigger):
                    self._kind = EdgeKind.WITHIN if trigger == "within" else EdgeKind.TRIGGER
                case fx.CommandStatus(status="failed" | "refused"):
                    self._kind = EdgeKind.FAILURE
                case fx.Fault(handling=handling) if handling != "continue":
                    self._kind = EdgeKind.FAULT
                case fx.CommandStatus(status="sent" | "skipped"):
                    self._kind = None
                case _:
                    pass

    def _reach(self, name: str) -> None:
        if self._here and self._kind is not None:
            self.stops.append((self._here, name, self._kind))
        else:
            self.stops.append(name)
        self._here, self._kind = name, None
