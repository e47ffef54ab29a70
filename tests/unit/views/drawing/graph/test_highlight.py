from __future__ import annotations

import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.views.drawing.graph.graph import EdgeKind, Graph
from pirate_sm.views.drawing.graph.highlight import highlight
from pirate_sm.views.drawing.graph.mission_graph import mission_graph

from ..conftest import CHARTS, ROOT, drawing, read_mission, written


@pytest.fixture
def loop() -> Graph:
    return mission_graph(
        written(
            """
  a: {wait: [{after: 1 s, go: b}], within: {time: 2 s, go: b}}
  b: {wait: [{after: 1 s, go: b}, {after: 2 s, go: a}, {after: 3 s, go: well}]}
  c: {go: well}""",
            "on_failure: c",
        )
    )


def visits(graph: Graph) -> dict[str, tuple[int, ...]]:
    return {node.id: node.visits for node in graph.nodes if node.visits}


def taken(graph: Graph) -> dict[tuple[str, str, str], tuple[int, ...]]:
    return {
        (edge.source, edge.target, edge.kind.value): edge.taken
        for edge in graph.edges
        if edge.taken
    }


def test_nodes_have_the_numbers_of_their_visits_and_edges_those_they_lead_to(loop: Graph) -> None:
    marked = highlight(loop, ["a", "b", "a", "b", "b", "well"])

    assert visits(marked) == {"a": (1, 3), "b": (2, 4, 5), "well": (6,)}
    assert [node.id for node in marked.nodes if node.current] == ["well"]
    assert taken(marked) == {
        ("(start)", "a", "start"): (1,),
        ("a", "b", "trigger"): (2, 4),
        ("a", "b", "within"): (2, 4),
        ("b", "b", "trigger"): (5,),
        ("b", "a", "trigger"): (3,),
        ("b", "well", "trigger"): (6,),
    }


def test_pairs_join_and_may_say_which_edge_it_was(loop: Graph) -> None:
    marked = highlight(loop, [("a", "b", EdgeKind.WITHIN), ("b", "b"), ("b", "well")])

    assert visits(marked) == {"a": (1,), "b": (2, 3), "well": (4,)}
    assert ("a", "b", "within") in taken(marked)
    assert ("a", "b", "trigger") not in taken(marked)


def test_what_no_edge_leads_to_was_reached_from_any_phase(loop: Graph) -> None:
    marked = highlight(loop, ["a", "b", "c"])

    assert taken(marked)["(any phase)", "c", "failure"] == (3,)


def test_called_phases_count_as_their_caller_where_they_are_not_drawn() -> None:
    mission = ROOT / "sequences" / "mitre_bend.yaml"
    path = ["enter", "prepare", "prepare/prepare_bend.bend", "pass", "pass/pass_bend.pass", "halt"]

    flat = highlight(mission_graph(read_mission(mission)), path)
    assert visits(flat) == {"enter": (1,), "prepare": (2,), "pass": (3,), "halt": (4,)}
    whole = highlight(drawing(mission), path)
    assert visits(whole)["prepare/prepare_bend.bend"] == (3,)
    assert taken(whole)["prepare", "pass", "trigger"] == (4,)


def test_in_a_chart_each_region_goes_its_own_way() -> None:
    graph = drawing(CHARTS[1])
    states = [node.id for node in graph.nodes if node.kind.value == "state"]
    edge = next(each for each in graph.edges if each.kind is EdgeKind.TRIGGER)
    foreign = next(each for each in states if each.split(".")[0] != edge.source.split(".")[0])

    marked = highlight(graph, [edge.source, foreign, edge.target])

    assert taken(marked)[edge.source, edge.target, "trigger"] == (3,)


def test_an_unknown_name_is_refused_with_the_nearest(loop: Graph) -> None:
    with pytest.raises(UsageError, match="did you mean 'well'"):
        highlight(loop, ["a", "wel"])


def test_an_empty_path_marks_nothing(loop: Graph) -> None:
    assert highlight(loop, []) == loop
