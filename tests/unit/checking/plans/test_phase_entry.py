"""Handing a mission back: every phase is tried from the states that the robot is in."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.checking.plans.phase_entry import why_not_from
from pirate_sm.engine.robot.robot_state import at_rest_in
from pirate_sm.loading.mission import load_mission

ROOT = Path(__file__).resolve().parents[4]


@pytest.fixture(scope="module")
def bend():
    return load_mission(ROOT / "sequences" / "mitre_bend.yaml")


def standing(loaded, *states):
    return at_rest_in(loaded.robot, loaded.robot.table.index_of(states))


def test_driven_in_by_hand_with_the_lights_off_the_bend_can_be_prepared(bend):
    body = standing(bend, "DrivingForward", "DrivingForward", "DoubleClamped", "Unaligned", "Off")

    assert why_not_from(bend, "prepare", body) == ""


def test_what_would_be_refused_is_said(bend):
    body = standing(bend, "Free", "Fixed", "RearClampedFrontRelaxed", "Unaligned", "Off")

    assert "mission pass_bend" in why_not_from(bend, "pass", body)


def test_a_phase_that_cannot_succeed_is_none_to_go_on_with(bend):
    body = standing(bend, "Fixed", "Fixed", "DoubleClamped", "Unaligned", "Off")

    assert "no path leads to an end that succeeds" in why_not_from(bend, "regrip", body)


def test_an_unknown_phase_is_said(bend):
    body = standing(bend, "Fixed", "Fixed", "DoubleClamped", "Unaligned", "Off")

    assert "no such phase" in why_not_from(bend, "nowhere", body)
