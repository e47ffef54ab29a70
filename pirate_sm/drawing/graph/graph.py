"""What is drawn, whatever it was made from and however it is written."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from pirate_sm.errors import PirateError


class NodeKind(StrEnum):
    """What a node stands for."""

    INITIAL = "initial"
    ANYWHERE = "anywhere"
    """Whatever is current: what leads away from it does so from everywhere in the cluster."""
    PHASE = "phase"
    STATE = "state"
    SUCCEED = "succeed"
    FAIL = "fail"


class EdgeKind(StrEnum):
    """Why one node follows another."""

    START = "start"
    GO = "go"
    TRIGGER = "trigger"
    WITHIN = "within"
    FAILURE = "failure"
    FAULT = "fault"


@dataclass(frozen=True, slots=True)
class Node:
    """Something that can be current.

    Attributes:
        id: Unique in its graph; what :func:`pirate_sm.drawing.graph.highlight.highlight` calls it.
        title: Its name, as a reader shall see it.
        lines: What it does, in order; a line is indented by blanks.
        tooltip: More about it, for whoever asks.
        cluster: Id of the cluster that it stands in.
        visits: When it was reached, counted from 1; empty when it was not.
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


@dataclass(frozen=True, slots=True)
class Edge:
    """Leads from one node to another of the same cluster, or back to itself.

    Attributes:
        label: When it is taken.
        tooltip: The same in full, where the label is short.
        taken: When it was taken: the numbers of the visits it leads to.
    """

    source: str
    target: str
    kind: EdgeKind
    label: str = ""
    tooltip: str = ""
    taken: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Cluster:
    """A group of nodes; one without a title has no frame."""

    id: str
    title: str = ""
    tooltip: str = ""


@dataclass(frozen=True, slots=True)
class Note:
    """What a label was too short for; labels refer to it by its mark."""

    mark: str
    text: str


@dataclass(frozen=True)
class Graph:
    """A whole drawing. Nodes and edges stand in the order in which they shall be read.

    Raises:
        GraphError: An id stands twice, or something refers to nothing.
    """

    title: str
    clusters: tuple[Cluster, ...]
    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...]
    description: str = ""
    notes: tuple[Note, ...] = ()

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
    """Is raised for a graph that does not hold together: a fault of whoever built it."""
