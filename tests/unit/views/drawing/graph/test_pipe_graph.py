"""Pipes as graphs."""

from __future__ import annotations

import pytest

from pirate_sm.core.models import Pipe
from pirate_sm.views.drawing.graph.graph import pipe_graph
from pirate_sm.views.drawing.svg.svg_writer import svg
from pirate_sm.views.drawing.text_formats import dot, mermaid

HOUSE = {
    "section": "round",
    "diameter": "120 mm",
    "description": "A house",
    "runs": {
        "main": {"from": "entry", "to": "t1", "segments": [{"straight": "1 m"}]},
        "past": {"from": "t1.on", "to": "cap", "segments": [{"straight": "2 m"}]},
        "up": {
            "from": "t1.branch",
            "to": "exit",
            "diameter": "110 mm",
            "segments": [
                {"straight": "800 mm"},
                {"elbow": "90 deg", "radius": "180 mm", "roll": "-90 deg"},
                {"straight": "1 m"},
                {"reducer": "60 mm", "to": "100 mm"},
                {"straight": "1 m"},
            ],
        },
    },
    "junctions": {"t1": {"tee": "90 deg", "roll": "90 deg"}},
    "ends": {"entry": "open", "cap": "closed", "exit": "open"},
    "routes": {"in": ["main", "up"], "on": ["main", "past"]},
}


@pytest.fixture(scope="module")
def graph():
    return pipe_graph(Pipe.model_validate(HOUSE), "house")


def test_junctions_and_ends_are_nodes(graph) -> None:
    assert {node.id: node.lines for node in graph.nodes} == {
        "entry": ("open end",),
        "t1": ("tee, branch at 90°",),
        "cap": ("closed end",),
        "exit": ("open end",),
    }


def test_runs_are_edges_with_their_fittings(graph) -> None:
    assert [(edge.source, edge.target, edge.label) for edge in graph.edges] == [
        ("entry", "t1", "main, 120 mm"),
        ("t1", "cap", "past, straight on of t1, 120 mm"),
        ("t1", "exit", "up, branch of t1, 110 mm: elbow 90° rolled -90°, reducer to 100 mm"),
    ]
    assert graph.edges[-1].tooltip.endswith(
        "elbow 90° rolled -90°, straight 1 m, reducer to 100 mm, straight 1 m"
    )


def test_routes_are_notes(graph) -> None:
    assert [(note.mark, note.text) for note in graph.notes] == [
        ("route in", "main, up"),
        ("route on", "main, past"),
    ]


@pytest.mark.parametrize("write", [svg, dot, mermaid])
def test_every_format_draws_it(graph, write) -> None:
    text = write(graph)
    assert all(name in text for name in ("entry", "t1", "cap", "exit", "reducer"))


def test_inline_tees_are_junctions_with_a_closed_stub() -> None:
    pipe = Pipe.model_validate(
        {
            "section": "round",
            "diameter": "120 mm",
            "segments": [
                {"straight": "1 m"},
                {"tee": "90 deg", "take": "branch"},
                {"straight": "1 m"},
            ],
        }
    )
    drawn = pipe_graph(pipe, "p")
    assert len(drawn.edges) == 3
    assert [node.lines for node in drawn.nodes if node.id.startswith("cap")] == [("closed end",)]
    assert drawn.notes == ()
