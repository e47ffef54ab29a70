"""Handing a mission back: every phase is tried from the states that the robot is in."""

from __future__ import annotations

from checking.plans.conftest import standing
from pirate_sm.checking.plans import why_not_from


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
