from __future__ import annotations

import pytest

from pirate_sm.views.drawing.graph.graph import (
    Cluster,
    Edge,
    EdgeKind,
    Graph,
    GraphError,
    Node,
    NodeKind,
)

HERE, THERE = Cluster("here"), Cluster("there")
A = Node("a", NodeKind.PHASE, cluster="here")
B = Node("b", NodeKind.PHASE, cluster="there")


@pytest.mark.parametrize(
    ("nodes", "edges"),
    [
        ((A, A), ()),
        ((Node("c", NodeKind.PHASE, cluster="nowhere"),), ()),
        ((A,), (Edge("a", "gone", EdgeKind.GO),)),
        ((A,), (Edge("gone", "gone", EdgeKind.GO),)),
        ((A, B), (Edge("a", "b", EdgeKind.GO),)),
    ],
)
def test_a_graph_that_does_not_hold_together_is_refused(
    nodes: tuple[Node, ...], edges: tuple[Edge, ...]
) -> None:
    with pytest.raises(GraphError):
        Graph("x", (HERE, THERE), nodes, edges)
