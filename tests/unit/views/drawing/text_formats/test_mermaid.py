from __future__ import annotations

import re
from collections import Counter
from html import unescape
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from representative import thorough_but

from pirate_sm.views.drawing.graph.graph import Cluster, Edge, EdgeKind, Graph, Node, NodeKind
from pirate_sm.views.drawing.graph.highlight import highlight
from pirate_sm.views.drawing.text_formats import mermaid, plain_names
from pirate_sm.views.drawing.wrapping import printable

from ..conftest import DRAWN, FEW, ROOT, drawing, name

_TEXT = r'"((?:[^"#;]|#\w+;)*)"'
_NODE = re.compile(rf"\s+(n_\w+|notes)[(\[]+{_TEXT}[)\]]+")
_EDGE = re.compile(rf"    (n_\w+) (?:-->|==>)(?:\|{_TEXT}\|)? (n_\w+)")
_OTHER = re.compile(
    rf"---|title: \".*\"|flowchart TD|\s+end|\s+subgraph c_\w+\[{_TEXT}\]"
    r"|    (linkStyle \d+|classDef \w+|class \w+) [\w#:,\- ]+"
)


def read(text: str) -> tuple[dict[str, str], list[tuple[str, str, str]]]:
    """The labels of the nodes, and the edges with theirs; every line must be of a known form."""
    nodes: dict[str, str] = {}
    edges: list[tuple[str, str, str]] = []
    for line in text.splitlines():
        if node := _NODE.fullmatch(line):
            assert node[1] not in nodes
            nodes[node[1]] = plain(node[2])
        elif edge := _EDGE.fullmatch(line):
            edges.append((edge[1], edge[3], plain(edge[2] or "")))
        else:
            assert _OTHER.fullmatch(line), line
    return nodes, edges


def plain(label: str) -> str:
    unbroken = label.replace("<br/>", " ").replace("<b>", "").replace("</b>", "")
    return unescape(re.sub(r"#(\w+);", lambda m: f"&{'#' * m[1].isdigit()}{m[1]};", unbroken))


@pytest.mark.parametrize("path", thorough_but(FEW, DRAWN), ids=name)
def test_every_node_and_every_edge_is_written_once(path: Path) -> None:
    graph = drawing(path)
    nodes, edges = read(mermaid(graph))
    names = plain_names((node.id for node in graph.nodes), "n")

    assert [node for node in nodes if node != "notes"] == list(names.values())
    assert Counter(edges) == Counter(
        (names[edge.source], names[edge.target], edge.label) for edge in graph.edges
    )


@given(st.text(min_size=1, max_size=30))
def test_any_text_stays_text(text: str) -> None:
    nodes = (Node("end", NodeKind.PHASE, "end"), Node("b", NodeKind.FAIL, "b"))
    graph = Graph("x", (Cluster(""),), nodes, (Edge("end", "b", EdgeKind.GO, f"1. {text}"),))
    _, edges = read(mermaid(graph))

    assert edges[0][2].replace(" ", "") == printable("".join(f"1. {text}".split()))


def test_a_path_is_told_by_numbers_and_thick_lines() -> None:
    text = mermaid(highlight(drawing(ROOT / "docs/examples/within.yaml"), ["look"]))

    assert '["<b>(1) look</b>' in text
    assert "n_start ==> n_look" in text
    assert "class n_look visited" in text


def test_names_stay_different() -> None:
    names = plain_names(["a/b.c", "a_b_c", "a.b", "é"], "n")

    assert len(set(names.values())) == 4
    assert all(re.fullmatch(r"n_[A-Za-z0-9_]*", each) for each in names.values())
