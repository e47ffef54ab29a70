"""Everything that can happen to a mission, each by the fewest events, told in sentences."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import pytest

from checking.small_missions import checked, only, write
from pirate_sm.checking.exploring.exploration import Exploration, Waiting, index_exploration, story
from pirate_sm.checking.exploring.explore import conditions_of, explore
from pirate_sm.checking.mission.check_mission import check_mission
from pirate_sm.checking.reports.counterexamples import write_counterexample
from pirate_sm.core.effects import CommandStatus, Effect
from pirate_sm.core.loading import load_mission
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.wiring import Order, prepare
from pirate_sm.running.wiring.backends import read_script

ONE = "start: p\nphases: {p: {do: [HoldNose], go: good}}\n"
WAITING = """
start: p
phases:
  p:
    do: [SwitchLamp]
    wait: [{when: way > 50 mm, held: 1 s, go: good}, {operator: no, go: bad}]
    within: {time: 5 s, go: bad}
"""
HANDLING = """
on_fault: [{fault: sensor.silent, go: h}, {fault: robot.stuck, go: h}]
start: p
phases:
  p: {do: [HoldNose, GoAhead, Rest], go: good}
  h: {do: [{command: Rest, unneeded: skip}], go: bad}
"""


def explored(folder: Path, body: str, **limits: float) -> Exploration:
    loaded = load_mission(write(folder, body))
    return explore(loaded.robot, loaded.program, conditions_of(loaded), **limits)  # type: ignore[arg-type]


def wait_of(found: Exploration) -> Waiting:
    """Return what happened at the one wait of the mission."""
    (waiting,) = index_exploration(found).waits.values()
    return waiting


def moves(found: Exploration) -> list[str]:
    return [step.move.kind for step in found.steps]


def test_a_command_is_accepted_or_not_done_or_not(tmp_path: Path) -> None:
    assert moves(explored(tmp_path, ONE)) == ["start", "accepted", "rejected", "time", "failed"]


def test_a_wait_is_ended_by_sensors_operator_or_time(tmp_path: Path) -> None:
    book = wait_of(explored(tmp_path, WAITING))

    assert set(book.fired) == {"good", "bad", "within"}
    assert not book.at_once["good"]


def test_a_wait_for_a_condition_or_a_word_is_ended_by_sensors_too(tmp_path: Path) -> None:
    """The condition may be untrue as the wait begins, and come true later."""
    found = explored(tmp_path, WAITING.replace(", held: 1 s", ""))
    book = wait_of(found)

    fired = {found.steps[each].move.kind for each in book.fired["good"]}
    assert "sensors" in fired


def test_a_fault_that_only_a_rule_tells_comes_where_the_rule_can_hold(tmp_path: Path) -> None:
    found = explored(tmp_path, HANDLING)
    faults = {
        (step.move.word, found.robot.table.configurations[
            found.nodes[step.source].state.robot.configuration][1])
        for step in found.steps if step.move.kind == "fault"
    }  # fmt: skip

    assert ("sensor.silent", "Resting") in faults  # the first of those that lead to one handler
    assert not any(code == "robot.stuck" and state == "Resting" for code, state in faults)


def test_a_fault_is_no_choice_while_one_is_handled(tmp_path: Path) -> None:
    found = explored(tmp_path, HANDLING)

    assert all(
        not found.nodes[step.source].state.mission.handling
        for step in found.steps
        if step.move.kind == "fault"
    )


def test_where_an_interrupted_command_stands_makes_no_difference(tmp_path: Path) -> None:
    body = (
        "on_fault: [{fault: sensor.silent, go: h}]\nstart: w\nphases:\n"
        "  w: {wait: [{operator: yes, go: p}, {operator: no, go: q}],\n"
        "      within: {time: 5 s, go: bad}}\n"
        "  p: {do: [HoldNose], go: good}\n  q: {do: [HoldNose], go: bad}\n"
        "  h: {do: [{command: Rest, unneeded: skip}], go: bad}\n"
    )
    nodes = [node.state for node in explored(tmp_path, body).nodes]

    given = [each for each in nodes if each.robot.motion and not each.mission.diverting]
    interrupted = [each for each in nodes if each.robot.motion and each.mission.diverting]
    assert len(given) == 4, "in two places, before and after it is accepted"
    assert len(interrupted) == 1, "before it is accepted; after that it is over at once"


LOSES = """
pipe: straight_113
on_fault: [{fault: clamp.lost, %s}]
start: p
phases:
  p:
    do: [ClampFront, ClampRear]
    wait: [{operator: "on", go: good}]
    within: {time: 1 min, go: bad}
  h: {do: [RelaxRear], go: bad}
"""


def test_a_fault_of_a_rule_denies_the_clamps_that_its_rule_denies(tmp_path: Path) -> None:
    """Without them nothing may let go that would leave such a part alone, as on the robot."""
    check = check_mission(write(tmp_path, LOSES % "go: h", robot=Path("pirate_ii")))

    refused = only(check, "handler.impossible")
    assert "RelaxRear can be refused as impossible: no clamp that would" in refused.message
    assert any("the front has opened nearly to its end stop" in each for each in refused.story)


def test_a_fault_that_is_only_logged_denies_them_too(tmp_path: Path) -> None:
    body = LOSES.replace("go: good}]", "go: h}]") % "then: continue"

    check = check_mission(write(tmp_path, body, robot=Path("pirate_ii")))

    assert "RelaxRear" in only(check, "step.maybe_impossible").message


def test_a_fault_that_denies_is_shown_alike_by_its_counterexample(tmp_path: Path) -> None:
    path = write(tmp_path, LOSES % "go: h", robot=Path("pirate_ii"))
    check = check_mission(path)
    finding = only(check, "handler.impossible")

    written = write_counterexample(finding, check, tmp_path / "found", "m", path)

    mission, script = tmp_path / "found" / "m.yaml", Path(written.example)
    firings, course = read_script(script)
    assert not firings
    prepared = prepare(Order(str(mission), backend="trace", course=course, check=False))
    seen: list[Effect] = []
    run = MissionRun(
        prepared.engine, prepared.backend, companions=prepared.companions, observers=[Seen(seen)]
    )
    run.execute()
    refused = [each for each in seen if isinstance(each, CommandStatus)]
    assert ("RelaxRear", "refused") in [(each.name, each.status) for each in refused]


class Seen:
    def __init__(self, effects: list[Effect]) -> None:
        self.effects = effects

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        self.effects += effects


def test_nothing_happens_after_the_end(tmp_path: Path) -> None:
    found = explored(tmp_path, HANDLING)

    assert not any(found.nodes[step.source].over for step in found.steps if step.source >= 0)


def test_a_path_leads_from_the_start_to_its_step(tmp_path: Path) -> None:
    found = explored(tmp_path, HANDLING)
    path = found.path(len(found.steps) - 1)

    assert path[0].source == -1
    assert all(after.source == before.target for before, after in itertools.pairwise(path))


@pytest.mark.parametrize("limit", [{"most": 3}, {"most_work": 2.5}])
def test_what_is_too_much_is_cut_off_and_known_to_be(
    tmp_path: Path, limit: dict[str, float]
) -> None:
    found = explored(tmp_path, HANDLING, **limit)

    assert not found.complete
    assert len(found.nodes) <= 4
    assert explored(tmp_path, HANDLING).complete


def test_a_story_says_what_happens_in_order(tmp_path: Path) -> None:
    found = explored(tmp_path, WAITING)
    fired = wait_of(found).fired["good"][0]

    told = story(found, fired)

    assert told[0] == "the mission begins; p begins"
    assert told[1].startswith("SwitchLamp")
    assert "way > 50 mm" in told[-1]
    assert "(with " not in told[-1], "the trigger itself says what was so"
    assert told[-1].endswith("the mission has ended: Good") or "so good" in told[-1]


def test_what_cannot_be_decided_is_explored_last_and_is_not_sure(tmp_path: Path) -> None:
    body = """
start: p
phases:
  p:
    wait: [{when: way * way == 1.7 mm * 1 m and pace / 1 m > way / 1 m / 1 s, go: q}]
    within: {time: 5 s, go: good}
  q: {do: [Rest], go: good}
"""
    check = checked(tmp_path, body)

    assert [(each.code, each.severity.word) for each in check.findings
            if each.code.startswith("step.")] == [("step.unneeded", "possible")]  # fmt: skip
    assert not any(each.course for each in check.findings if each.severity.word == "possible")


def test_a_way_that_leads_back_to_where_it_began_is_known_too(tmp_path: Path) -> None:
    body = """
start: p
phases:
  p:
    wait: [{operator: again, go: p}, {operator: enough, go: good}]
    within: {time: 5 s, go: bad}
"""
    assert set(wait_of(explored(tmp_path, body)).fired) == {"p", "good", "within"}
