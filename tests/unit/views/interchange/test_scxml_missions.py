"""Missions as SCXML: python-statemachine opens them and finds their phases, ends and ways."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from representative import MISSIONS as REPRESENTATIVE
from representative import thorough_but
from statemachine.io import load

from pirate_sm.core.documents import read_document
from pirate_sm.core.loading import load_mission, validate
from pirate_sm.core.models import Mission
from pirate_sm.views.drawing.graph.graph import EdgeKind
from pirate_sm.views.drawing.graph.mission_graph import ANY_PHASE as ANYWHERE
from pirate_sm.views.drawing.graph.mission_graph import mission_graph
from pirate_sm.views.interchange.scxml import ANY_PHASE, END, PHASE, mission_scxml

from .charts import ROOT

MISSIONS = sorted(
    each
    for folder in ("sequences", "docs/examples", "tests/robots/newt")
    for each in (ROOT / folder).glob("*.yaml")
    if "phases:" in each.read_text("utf-8")
)
FEW = [each for each in MISSIONS if each.parent.name != "sequences" or each.stem in REPRESENTATIVE]


def mission_of(path: Path) -> Mission:
    return validate(read_document(path), Mission)


def ways(states: Any) -> set[tuple[str, str, str]]:
    """Return source, first word of the event, and target of all transitions with a target."""
    return {
        (state.id, event.partition(".")[0], target.id)
        for state in states
        for each in state.transitions
        if not each.initial
        for event in each.event.split()
        for target in each.targets
    }


@pytest.mark.parametrize("path", thorough_but(FEW, MISSIONS), ids=lambda path: path.stem)
def test_the_structure_of_a_mission_is_found_again(path: Path) -> None:
    mission = mission_of(path)
    machine = load(mission_scxml(mission), format="scxml")()
    every = {state.id: state for state in machine.states_map.values()}
    graph = mission_graph(mission)

    assert set(every) == {
        ANY_PHASE,
        *(f"{PHASE}{name}" for name in mission.phases),
        *(f"{END}{name}" for name in mission.ends),
    }
    assert {id_ for id_, state in every.items() if state.final} == {
        f"{END}{name}" for name in mission.ends
    }
    assert set(machine.configuration_values) == {ANY_PHASE, f"{PHASE}{mission.start}"}
    words = {EdgeKind.GO: "done", EdgeKind.WITHIN: "within"}
    words |= {EdgeKind.FAILURE: "failed", EdgeKind.FAULT: "fault"}
    ids = {ANYWHERE: ANY_PHASE} | {name: f"{PHASE}{name}" for name in mission.phases}
    ids |= {name: f"{END}{name}" for name in mission.ends}
    drawn = {
        (ids[edge.source], words.get(edge.kind, _word(edge.label)), ids[edge.target])
        for edge in graph.edges
        if edge.kind is not EdgeKind.START
    }
    assert ways(every.values()) == drawn


def _word(label: str) -> str:
    return "answer" if label.startswith("answer: ") else "trigger"


def test_the_most_specific_way_out_is_taken() -> None:
    scxml = mission_scxml(load_mission(ROOT / "sequences" / "mitre_bend.yaml").mission)

    def after(*events: str) -> str:
        machine = load(scxml, format="scxml")()
        for event in events:
            machine.send(event)
        return str(list(machine.configuration_values)[-1])

    # A failed step of a phase that says nothing leads where the mission says.
    assert after("failed.2") == "phase.regrip"
    assert after("failed.2", "failed.4") == "end.lost_grip"
    assert after("fault.sensor.silent") == "phase.enter"
    assert after("trigger.prepare", "fault.robot.stuck", "done") == "end.gave_up"
    assert after("trigger.prepare", "trigger.pass", "within") == "phase.regrip"


def test_what_scxml_has_no_word_for_stands_beside_it() -> None:
    scxml = mission_scxml(mission_of(ROOT / "sequences" / "mitre_bend.yaml"))

    for text in (
        'event="trigger.prepare" target="phase.prepare" sm:when="detector == close"',
        'sm:held="200 ms"',
        "<sm:step>ClampRear, ≤ 20 s, retry 2</sm:step>",
        '<transition event="fault.sensor.silent" sm:of="wheel_3, wheel_4" />',
        '<final id="end.passed" sm:succeed="In the far leg" />',
        'sm:time_limit="10 min"',
    ):
        assert text in scxml
