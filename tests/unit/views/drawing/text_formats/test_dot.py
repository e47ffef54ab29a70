"""What is written follows the grammar of the DOT language, as far as it is used here."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from representative import thorough_but

from pirate_sm.views.drawing.graph.graph import Cluster, Edge, EdgeKind, Graph, Node, NodeKind
from pirate_sm.views.drawing.graph.highlight import highlight
from pirate_sm.views.drawing.text_formats import dot

from ..conftest import DRAWN, FEW, ROOT, drawing, name

_TOKEN = re.compile(r'\s*(?:("(?:[^"\\]|\\.)*")|([A-Za-z_]\w*|-?\d+(?:\.\d+)?)|(->|[{}\[\]=,;]))')


def tokens(text: str) -> Iterator[str]:
    at = 0
    while text[at:].strip():
        found = _TOKEN.match(text, at)
        assert found, f"no token at {text[at : at + 40]!r}"
        at = found.end()
        yield found.group().strip()


class Parser:
    """Reads a digraph; an id is a token, quoted ones without their quotes."""

    def __init__(self, text: str) -> None:
        self.tokens = list(tokens(text))
        self.nodes: dict[str, dict[str, str]] = {}
        self.edges: list[tuple[str, str, dict[str, str]]] = []
        assert self.tokens.pop(0) == "digraph"
        self.identifier()
        self.block()
        assert not self.tokens

    def identifier(self) -> str:
        token = self.tokens.pop(0)
        assert token[0] == '"' or re.fullmatch(r"[A-Za-z_]\w*|-?\d+(\.\d+)?", token), token
        inside = token[1:-1] if token[0] == '"' else token
        return inside.replace('\\"', '"').replace("\\\\", "\\").replace("&amp;", "&")

    def block(self) -> None:
        assert self.tokens.pop(0) == "{"
        while self.tokens[0] != "}":
            self.statement()
        self.tokens.pop(0)

    def statement(self) -> None:
        if self.tokens[0] == "subgraph":
            self.tokens.pop(0)
            assert self.identifier().startswith("cluster_")
            self.block()
            return
        quoted = self.tokens[0][0] == '"'
        first = self.identifier()
        if self.tokens[0] == "=":
            self.tokens.pop(0)
            self.identifier()
        elif self.tokens[0] == "->":
            self.tokens.pop(0)
            self.edges.append((first, self.identifier(), self.attributes()))
        elif quoted:
            assert first not in self.nodes
            self.nodes[first] = self.attributes()
        else:
            assert first in {"graph", "node", "edge"}
            self.attributes()

    def attributes(self) -> dict[str, str]:
        found: dict[str, str] = {}
        if self.tokens[0] != "[":
            return found
        while self.tokens.pop(0) != "]":
            key = self.identifier()
            assert self.tokens.pop(0) == "="
            found[key] = self.identifier()
        return found


@pytest.mark.parametrize("path", thorough_but(FEW, DRAWN), ids=name)
def test_every_node_and_every_edge_is_written_once(path: Path) -> None:
    graph = drawing(path)
    found = Parser(dot(graph))

    assert [node for node in found.nodes if node != "(notes)"] == [n.id for n in graph.nodes]
    assert Counter((source, target) for source, target, _ in found.edges) == Counter(
        (edge.source, edge.target) for edge in graph.edges
    )


def test_any_text_stays_text() -> None:
    text = 'say "hi" \\N & <b> {x} | \\'
    nodes = (Node("a", NodeKind.PHASE, text, (text,), text), Node("b", NodeKind.FAIL, "b"))
    graph = Graph(text, (Cluster(""),), nodes, (Edge("a", "b", EdgeKind.GO, text, text),))
    found = Parser(dot(graph))

    assert found.nodes["a"]["tooltip"] == text
    assert found.edges[0][2]["tooltip"] == text


def test_a_path_is_told_by_numbers_and_thick_lines() -> None:
    found = Parser(dot(highlight(drawing(ROOT / "docs/examples/within.yaml"), ["look"])))

    assert found.nodes["look"]["label"].startswith("(1) look")
    assert found.nodes["look"]["peripheries"] == "2"
    assert found.edges[0][2]["penwidth"] == "3"
