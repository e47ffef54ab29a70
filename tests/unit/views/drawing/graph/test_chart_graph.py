from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from pirate_sm.core.loading import ChartOutline, ChartTransition
from pirate_sm.views.drawing.graph.graph import LONGEST_GUARD, EdgeKind, NodeKind, chart_graph

from ..conftest import CHARTS, name, read_chart


@pytest.mark.parametrize("path", CHARTS, ids=name)
def test_every_state_and_transition_is_drawn_once(path: Path) -> None:
    outline = read_chart(path)
    graph = chart_graph(outline, "robot")

    states = [node.id for node in graph.nodes if node.kind is NodeKind.STATE]
    assert sorted(states) == sorted(
        f"{region}.{state}"
        for region, names in zip(outline.regions, outline.states, strict=True)
        for state in names
    )
    assert [cluster.id for cluster in graph.clusters] == list(outline.regions)
    drawn = Counter(
        (edge.source, edge.target, edge.label.partition(" ")[0])
        for edge in graph.edges
        if edge.kind is not EdgeKind.START
    )
    assert drawn == Counter((each.source, each.target, each.event) for each in outline.transitions)
    assert len(graph.edges) == len(outline.transitions) + len(outline.regions)


def two_states(*guards: str) -> ChartOutline:
    transitions = tuple(
        ChartTransition("Arm", "Arm.In", f"Go{number}", "Arm.Out", guard, (), "Arm.In", None)
        for number, guard in enumerate(guards)
    )
    return ChartOutline("top", ("Arm",), (("Out", "In"),), ("In",), transitions, (), ())


def test_the_initial_state_comes_first() -> None:
    titles = [node.title for node in chart_graph(two_states(""), "x").nodes]

    assert titles == ["start", "In", "Out"]


def test_short_guards_stand_in_the_label_and_long_ones_in_a_note() -> None:
    long = "In('Arm.In') and\n  not In('Arm.Out') and not In(\"Leg.Out\")"
    edges = chart_graph(two_states("In('Leg.In')", long, long), "x").edges[1:]
    notes = chart_graph(two_states("In('Leg.In')", long, long), "x").notes

    assert [edge.label for edge in edges] == ["Go0 [Leg.In]", "Go1 [guard 1]", "Go2 [guard 1]"]
    assert [note.text for note in notes] == ["Arm.In and not Arm.Out and not Leg.Out"]
    assert edges[1].tooltip == "Go1 [Arm.In and not Arm.Out and not Leg.Out]"
    assert len(notes[0].text) > LONGEST_GUARD
