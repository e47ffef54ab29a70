from __future__ import annotations

from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree

import pytest
from representative import thorough_but

from pirate_sm.views.drawing.graph.graph import Cluster, Edge, EdgeKind, Graph, Node, NodeKind
from pirate_sm.views.drawing.graph.highlight import highlight
from pirate_sm.views.drawing.svg.arrangement import arranged
from pirate_sm.views.drawing.svg.svg_writer import svg, visits_text

from ..conftest import DRAWN, FEW, ROOT, drawing, name
from ..geometry import along, inside, overlap, rectangle

SPACE = "{http://www.w3.org/2000/svg}"


def tiny(title: str = "A", label: str = "", tooltip: str = "") -> Graph:
    nodes = (
        Node("a", NodeKind.PHASE, title, (label,) if label else (), tooltip),
        Node("b", NodeKind.FAIL, "b"),
    )
    edge = Edge("a", "b", EdgeKind.WITHIN, label, tooltip)
    return Graph("tiny", (Cluster(""),), nodes, (edge,))


def parsed(graph: Graph) -> ElementTree.Element:
    return ElementTree.fromstring(svg(graph))


@pytest.mark.parametrize("path", thorough_but(FEW, DRAWN), ids=name)
def test_no_label_and_no_foreign_line_lies_on_a_box(path: Path) -> None:
    picture = arranged(drawing(path))

    boxes = {box.node.id: rectangle(box.corner, box.size) for box in picture.boxes}
    labels = {
        number: rectangle(arrow.route.label, arrow.room)
        for number, arrow in enumerate(picture.arrows)
        if arrow.lines
    }
    assert not any(overlap(*pair) for pair in combinations(boxes.values(), 2))
    assert not any(overlap(*pair) for pair in combinations(labels.values(), 2))
    assert not any(overlap(text, box) for text in labels.values() for box in boxes.values())
    for number, arrow in enumerate(picture.arrows):
        ends = {arrow.edges[0].source, arrow.edges[0].target}
        for point in along(arrow.route):
            assert not any(inside(point, box) for node, box in boxes.items() if node not in ends)
            assert not any(inside(point, text) for n, text in labels.items() if n != number)
    for left, top, right, bottom in [*boxes.values(), *labels.values()]:
        assert left >= 0
        assert top >= 0
        assert right <= picture.size.width
        assert bottom <= picture.size.height


@pytest.mark.parametrize("path", thorough_but(FEW, DRAWN), ids=name)
def test_every_node_and_every_label_is_in_the_picture_which_needs_nothing_else(path: Path) -> None:
    graph = drawing(path)
    text = svg(graph)
    root = ElementTree.fromstring(text)

    assert [each.get("data-node") for each in root.iter() if each.get("data-node")] == [
        node.id for node in graph.nodes
    ]
    shown = " ".join(each.text or "" for each in root.iter(f"{SPACE}text"))
    words = {word for edge in graph.edges for word in edge.label.split() if len(word) < 28}
    assert {word for word in words if word not in shown} == set()
    drawn = {(each.get("data-from"), each.get("data-to")) for each in root.iter(f"{SPACE}g")}
    assert {(edge.source, edge.target) for edge in graph.edges} <= drawn
    bare = text.replace('xmlns="http://www.w3.org/2000/svg"', "")
    assert not any(word in bare for word in ("http:", "https:", "<script", "@import", "url("))


def test_any_text_stays_text() -> None:
    text = '<b> & "it\'s" ]]> \x07 {x} \\l 漢字'
    root = parsed(tiny(text, text, text))

    titles = [each.text for each in root.iter(f"{SPACE}title")]
    assert titles[0] == text.replace("\x07", "\N{REPLACEMENT CHARACTER}")


def test_what_was_visited_has_numbers_and_what_was_taken_a_thicker_line() -> None:
    root = parsed(highlight(drawing(ROOT / "docs/examples/within.yaml"), ["look"]))

    classes = {each.get("data-node"): each.get("class") for each in root.iter(f"{SPACE}g")}
    numbers = [each.text for each in root.iter(f"{SPACE}text") if each.get("class") == "number"]
    assert classes["look"] == "phase visited"
    assert numbers == ["1"]
    assert [each.get("class") for each in root.iter(f"{SPACE}g") if each.get("data-from")].count(
        "edge start taken"
    ) == 1
    assert sum(each.get("class") == "ring" for each in root.iter()) == 1


def test_many_visits_are_told_by_the_first_ones_and_the_last() -> None:
    assert visits_text([2, 4]) == "2, 4"
    assert visits_text([1, 2, 3, 4, 5, 9]) == "1, 2, 3 … 9"


def test_edges_of_one_kind_between_the_same_two_nodes_are_one_arrow() -> None:
    nodes = (Node("a", NodeKind.STATE, "a"), Node("b", NodeKind.STATE, "b"))
    edges = tuple(Edge("a", "b", EdgeKind.TRIGGER, label) for label in ("One", "Two"))
    picture = arranged(Graph("tiny", (Cluster(""),), nodes, edges))

    assert [[line for line, _ in arrow.lines] for arrow in picture.arrows] == [["One", "Two"]]


def test_both_palettes_colour_the_same_things() -> None:
    text = svg(tiny())
    day, night = text.split("@media screen and (prefers-color-scheme: dark)")

    for rule in night.split("}")[0:-3]:
        assert rule.partition("{")[0].strip(" {\n") in day


def test_a_graph_of_a_thousand_phases_is_drawn_all_the_same() -> None:
    nodes = tuple(Node(f"p{n}", NodeKind.PHASE, f"p{n}") for n in range(1000))
    edges = tuple(Edge(f"p{n}", f"p{n + 1}", EdgeKind.GO) for n in range(999))

    assert parsed(Graph("long", (Cluster(""),), nodes, edges)) is not None
