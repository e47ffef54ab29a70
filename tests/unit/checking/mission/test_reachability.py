"""Where a mission can get to, and rules that it can break on its way."""

from __future__ import annotations

from pathlib import Path

import pytest

from checking.small_missions import checked, only, told, write
from pirate_sm.checking.exploring import explore as checking
from pirate_sm.checking.mission.check_mission import check_mission

PIRATE = Path(__file__).resolve().parents[4] / "hardware_profiles" / "pirate_ii"

LOST = """
start: p
phases:
  p: {do: [SwitchLamp], go: good}
  q: {do: [SwitchLamp], go: bad}
"""


def test_phases_and_ends_that_nothing_leads_to_are_reported(tmp_path: Path) -> None:
    check = checked(tmp_path, LOST)

    assert only(check, "phase.unreachable").place.line == 7
    assert only(check, "end.unreachable").message == "nothing leads to the end 'bad'"


CONTROL = """
start: p
phases:
  p: {do: [ClampFront, ClampRear, {control: exp_3a, on_failure: q}], go: good}
  q: {do: [{control: none}], go: bad}
"""


def test_a_control_can_fail(tmp_path: Path) -> None:
    """Its joints may not come to their torques, so what its failure leads to is reached."""
    check = check_mission(write(tmp_path, CONTROL, robot=PIRATE))

    assert told(check) == []


def test_what_follows_the_failure_of_a_control_is_judged(tmp_path: Path) -> None:
    body = CONTROL.replace("{control: none}", "RelaxRear, RelaxFront")
    check = check_mission(write(tmp_path, body, robot=PIRATE))

    found = only(check, "step.impossible")
    assert "the torques are not borne in time" in found.story


def test_a_control_without_torques_cannot_fail(tmp_path: Path) -> None:
    body = CONTROL.replace("ClampFront, ClampRear, ", "").replace("exp_3a", "none")
    check = check_mission(write(tmp_path, body, robot=PIRATE))

    assert "phase.unreachable" in {code for code, _ in told(check)}


def test_a_loop_without_an_end_is_reported(tmp_path: Path) -> None:
    body = """
start: p
phases:
  p: {do: [SwitchLamp], go: q}
  q: {do: [SwitchLamp], go: p}
"""
    codes = {code for code, _ in told(checked(tmp_path, body))}

    assert {"loop.endless", "mission.no_success"} <= codes


def test_phases_that_lead_to_each_other_without_waiting_are_an_error(tmp_path: Path) -> None:
    body = "start: p\nphases: {p: {go: q}, q: {go: p}}\n"

    assert only(checked(tmp_path, body), "loop.instant").severity.word == "error"


def test_a_rule_that_can_be_broken_is_told_where_the_command_stands(tmp_path: Path) -> None:
    body = "start: p\nphases: {p: {do: [HoldNose, Home], go: good}}\n"

    found = only(checked(tmp_path, body), "rule.violated")

    assert "never_let_go" in found.message
    assert found.place.line == 5
    assert len(found.story) == 3


def test_a_mission_that_says_why_may_break_the_rule(tmp_path: Path) -> None:
    body = "allow_unclamp: on a table\nstart: p\nphases: {p: {do: [HoldNose, Home], go: good}}\n"

    assert "rule.violated" not in {code for code, _ in told(checked(tmp_path, body))}


def test_what_is_too_large_is_said_and_nothing_is_called_certain(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(checking, "MOST_WORK", 4)
    body = """
start: p
phases:
  p: {do: [{repeat: {times: 9, do: [SwitchLamp]}}], go: q}
  q: {do: [SwitchLamp], go: good}
"""
    assert [code for code, _ in told(checked(tmp_path, body))] == ["check.too_large"]
