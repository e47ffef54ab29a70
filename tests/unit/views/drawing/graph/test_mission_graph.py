from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from pirate_sm.core import models as model
from pirate_sm.views.drawing.graph.graph import Edge, EdgeKind, Graph, NodeKind
from pirate_sm.views.drawing.graph.mission_graph import mission_graph

from ..conftest import MISSIONS, ROOT, drawing, name, read_mission, written


def edges(graph: Graph) -> list[tuple[str, str, str, str]]:
    return [(each.source, each.target, each.kind.value, each.label) for each in graph.edges]


def lines(graph: Graph, node: str) -> tuple[str, ...]:
    return next(each.lines for each in graph.nodes if each.id == node)


def ways_out(wait: model.Phase | model.WaitStep) -> list[tuple[str, EdgeKind]]:
    """Return where a wait leads; in a step, what has no ``go`` leads on to the next step."""
    found = [(each.go, EdgeKind.TRIGGER) for each in wait.wait if each.go]
    if wait.within and wait.within.go:
        found.append((wait.within.go, EdgeKind.WITHIN))
    return found


def ways(mission: model.Mission) -> Counter[tuple[str, EdgeKind]]:
    """How many ways of each kind lead to each name, counted in the file itself."""
    found: Counter[tuple[str, EdgeKind]] = Counter({(mission.start, EdgeKind.START): 1})
    for phase in mission.phases.values():
        found.update(ways_out(phase))
        if phase.go:
            found[phase.go, EdgeKind.GO] += 1
        for step, _ in model.every_step(phase.do):
            if step.on_failure not in {None, "continue"}:
                found[str(step.on_failure), EdgeKind.FAILURE] += 1
            if isinstance(step, model.WaitStep):
                found.update(ways_out(step))
            if isinstance(step, model.AskStep):
                targets = set(step.choices.values()) - {"continue", "fail"}
                found.update((target, EdgeKind.TRIGGER) for target in targets)
        if phase.on_failure:
            found[phase.on_failure, EdgeKind.FAILURE] += 1
    if mission.on_failure:
        found[mission.on_failure, EdgeKind.FAILURE] += 1
    found.update((each.go, EdgeKind.FAULT) for each in mission.on_fault if each.go)
    return found


@pytest.mark.parametrize("path", MISSIONS, ids=name)
def test_every_phase_end_and_way_is_drawn_once(path: Path) -> None:
    mission = read_mission(path)
    graph = mission_graph(mission)

    hidden = {NodeKind.INITIAL, NodeKind.ANYWHERE}
    shown = [node.id for node in graph.nodes if node.kind not in hidden]
    assert shown == [*mission.phases, *mission.ends]
    assert Counter((each.target, each.kind) for each in graph.edges) == ways(mission)


def test_ways_say_when_they_are_taken() -> None:
    graph = mission_graph(
        written(
            """
  a:
    wait:
      - {when: level > 3, held: 200 ms, go: b}
      - {name: late, after: 90 s, go: b}
      - {operator: stop, go: well}
      - {after: 2 min, go: well}
    within: {time: $longest, go: well}
  b: {go: well, on_failure: well}""",
            "on_failure: b\non_fault: [{fault: [sensor.silent, robot.stuck], go: b}]",
        )
    )

    assert edges(graph) == [
        ("(start)", "a", "start", ""),
        ("a", "b", "trigger", "level > 3 for 200 ms"),
        ("a", "b", "trigger", "late: after 90 s"),
        ("a", "well", "trigger", "operator: stop"),
        ("a", "well", "trigger", "after 2 min"),
        ("a", "well", "within", "not within $longest"),
        ("b", "well", "go", ""),
        ("b", "well", "failure", "a step fails"),
        ("(any phase)", "b", "failure", "a step fails"),
        ("(any phase)", "b", "fault", "sensor.silent, robot.stuck"),
    ]


def test_steps_stand_in_their_phase_and_those_inside_others_are_indented() -> None:
    graph = mission_graph(
        written(
            """
  a:
    do:
      - Hold
      - {command: Turn, if: level > 3, timeout: 8 s, retry: 2, unneeded: skip, on_failure: continue}
      - {repeat: {times: 3, do: [Hold, {log: Again}]}, if: level < 2}
      - choose: [{if: level > 1, do: [Hold]}, {if: level > 0, do: [Turn]}]
        else: [{call: other, with: {far: 2 m}}]
      - {ask: "Free?", choices: {free: continue, wait: b}, on_failure: b}
      - {control: gentle, if: level > 3, on_failure: b}
    go: b
  b: {go: well}"""
        )
    )

    assert lines(graph, "a") == (
        "Hold",
        "Turn, if level > 3, if needed, ≤ 8 s, retry 2, or go on",
        "if level < 2:",
        "  3 times:",
        "    Hold",
        "    log “Again”",
        "if level > 1:",
        "  Hold",
        "else if level > 0:",
        "  Turn",
        "else:",
        "  call other (far = 2 m)",
        "ask “Free?” (free, wait), or b",
        "if level > 3:",
        "  control gentle, or b",
    )
    assert ("a", "b", "trigger", "answer: wait") in edges(graph)
    assert ("a", "b", "failure", "“Free?” fails") in edges(graph)
    assert ("a", "b", "failure", "control gentle fails") in edges(graph)


def test_the_beginning_says_in_which_states_and_by_which_control() -> None:
    graph = mission_graph(written("  a: {go: well}", "starts_in: {Arm: Up}\ncontrol: gentle"))

    assert edges(graph) == [
        ("(start)", "a", "start", "Arm=Up, control gentle"),
        ("a", "well", "go", ""),
    ]


def test_ends_say_how_they_ended_and_faults_that_change_nothing_are_named() -> None:
    graph = mission_graph(
        written(
            "  a: {go: well}",
            "on_fault: [{fault: sensor.silent, then: continue}]",
            "ends: {well: {succeed: Well}, ill: {fail: 'Ill: {cause}'}}",
        )
    )

    kinds = {node.id: node.kind for node in graph.nodes}
    assert (kinds["well"], kinds["ill"]) == (NodeKind.SUCCEED, NodeKind.FAIL)
    assert lines(graph, "ill") == ("Ill: {cause}",)
    assert lines(graph, "(any phase)") == ("sensor.silent: go on",)


def test_a_mission_that_catches_nothing_has_no_node_for_any_phase() -> None:
    assert "(any phase)" not in {
        node.id for node in mission_graph(written("  a: {go: well}")).nodes
    }


def test_called_missions_have_clusters_of_their_own_called_as_the_engine_calls_them() -> None:
    graph = drawing(ROOT / "sequences" / "exp_2b_detector.yaml")

    assert [cluster.id for cluster in graph.clusters] == [
        "",
        "bend/mitre_bend",
        "bend/mitre_bend.prepare/prepare_bend",
        "bend/mitre_bend.pass/pass_bend",
    ]
    home = {node.id: node.cluster for node in graph.nodes}
    assert home["bend/mitre_bend.prepare/prepare_bend.bend"] == graph.clusters[2].id
    begins = "bend/mitre_bend.(start)"
    assert Edge(begins, "bend/mitre_bend.enter", EdgeKind.START, "BendingState=Unclamped") in (
        graph.edges
    )


def test_a_mission_called_three_times_by_a_phase_is_drawn_once() -> None:
    graph = drawing(ROOT / "sequences" / "exp_1a_both.yaml")

    assert [cluster.title for cluster in graph.clusters] == ["", "rounds / exp_1_round"]
