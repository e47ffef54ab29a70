"""The content of a drawing, independent of its source and its output format."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from pirate_sm.core.errors import PirateError
from pirate_sm.views.drawing.text_wrapping import wrapped


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
        lines: Its actions, in order; a line is indented by blanks.
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
