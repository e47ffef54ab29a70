"""Branches that the exploration and runs have taken, as the engine notes them."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any, get_args

import pytest
from late import late
from representative import thorough_but

import pirate_sm
from pirate_sm.checking.reports.counterexamples import course_text
from pirate_sm.core._engine.mission.program import BranchKind
from pirate_sm.core.branches import branches
from pirate_sm.core.documents import parse_document
from pirate_sm.core.effects import CommandStatus, Fault, TriggerFired
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.core.program import BranchKey
from pirate_sm.robot.backends import trace_script
from pirate_sm.running.runtime.scripted_events import Firing
from pirate_sm.running.wiring import Order

evidence = late("pirate_sm.lab.coverage.evidence")

ROOT = Path(__file__).parents[4]
EXAMPLES = sorted((ROOT / "docs" / "examples").glob("*.yaml"))


def kinds(taken: Counter[BranchKey], loaded: LoadedMission) -> list[tuple[str, str]]:
    """Return kind and name of what was taken that the mission declares, in the order of lines."""
    known = branches(loaded.program, evidence.names_of_commands(loaded))
    return sorted((key.kind, key.name) for key in taken if key in known)


def traced(name: str, **options: Any) -> tuple[Any, LoadedMission]:
    path = ROOT / "docs" / "examples" / f"{name}.yaml"
    order = Order(str(path), backend="trace", **options)
    loaded = load_mission(path, states=order.states)
    return evidence.played(order, loaded).run, loaded


@pytest.mark.parametrize("path", thorough_but(EXAMPLES[::4], EXAMPLES), ids=lambda path: path.stem)
def test_a_trace_takes_each_branch_to_which_the_exploration_knows_a_way(path: Path) -> None:
    loaded = load_mission(path)
    found, possible = evidence.possible_in(loaded)

    for key, step in found.taken.items():
        assert key in possible.branches
        if found.is_playable(step):
            course = trace_script.read_script(parse_document(course_text(found, step), "it")).course
            order = Order(str(path), backend="trace", course=course)
            assert key in evidence.taken_in(evidence.played(order, loaded).run).branches


@pytest.mark.parametrize("path", thorough_but(EXAMPLES[::4], EXAMPLES), ids=lambda path: path.stem)
def test_what_is_counted_is_what_the_engine_reports(path: Path) -> None:
    loaded = load_mission(path)
    found, _ = evidence.possible_in(loaded)
    for step in {0, *found.taken.values()}:
        if not found.is_playable(step):
            continue
        course = trace_script.read_script(parse_document(course_text(found, step), "it")).course
        run = evidence.played(Order(str(path), backend="trace", course=course), loaded).run
        effects = [effect for each in run.steps() for effect in each.effects]
        counts = Counter[str]()
        for key, times in evidence.taken_in(run).branches.items():
            counts[key.kind] += times

        fired = [each.trigger for each in effects if isinstance(each, TriggerFired)]
        assert counts["within"] == fired.count("within")
        assert counts["trigger"] == len(fired) - counts["within"]
        faults = [each for each in effects if isinstance(each, Fault)]
        assert counts["on_fault"] == sum(each.handling != "stop" for each in faults)
        status = [each.status for each in effects if isinstance(each, CommandStatus)]
        assert counts["retry"] <= status.count("failed")


def test_a_time_limit_is_taken_and_its_trigger_is_not() -> None:
    for firings, wanted in (((), "trigger"), ((Firing("within"),), "within")):
        run, loaded = traced("within", firings=firings)
        found = kinds(evidence.taken_in(run).branches, loaded)
        assert [kind for kind, _ in found] == [wanted]


def test_a_condition_is_taken_one_way_or_the_other() -> None:
    run, loaded = traced("choose")
    assert kinds(evidence.taken_in(run).branches, loaded) == [("else", ""), ("else", "")]

    states = {"BendingState": "RearClampedFrontRelaxed", "RearWheelsState": "Fixed"}
    run, loaded = traced("choose", states=states)
    assert kinds(evidence.taken_in(run).branches, loaded) == [("if", "")]


def test_the_first_answer_is_taken_and_no_other() -> None:
    run, loaded = traced("ask")

    assert ("choice", "free") in kinds(evidence.taken_in(run).branches, loaded)
    names = {key.name for key in evidence.possible_in(loaded)[1].branches if key.kind == "choice"}
    assert names == {"free", "wait", "stop"}


def test_every_kind_of_branch_is_in_an_example() -> None:
    found = set()
    for path in EXAMPLES:
        loaded = load_mission(path)
        found |= {key.kind for key in branches(loaded.program, evidence.names_of_commands(loaded))}

    assert found == set(get_args(BranchKind))


def test_a_recording_has_taken_what_its_run_has(tmp_path: Path) -> None:
    path = ROOT / "docs" / "examples" / "on_fault.yaml"
    run = pirate_sm.run(path, defects="wheels_3_4_dead", record=tmp_path / "run.mcap")
    recorded = pirate_sm.read(tmp_path / "run.mcap")
    taken, again = evidence.taken_in(run), evidence.taken_in(recorded)

    assert sum(taken.branches.values()) == sum(again.branches.values()) > 0
    assert {key.kind for key in again.branches} == {key.kind for key in taken.branches}
    assert evidence.evidence_of(recorded.header) == "simulated"


def test_a_trace_shows_less_than_a_simulated_robot() -> None:
    run, _ = traced("held")

    assert evidence.evidence_of(run.header) == "trace"
    assert evidence.EVIDENCE.index("trace") < evidence.EVIDENCE.index("simulated")
