"""A run is judged by the truth, not by what its mission says."""

from __future__ import annotations

from dataclasses import replace
from math import nan
from typing import Any

import pytest

from benchmarks.campaign import run
from pirate_sm.lab.campaign.campaign_model import TrueEnd
from pirate_sm.lab.campaign.watched_run import Outcome, judge
from pirate_sm.running.wiring import Order

STATES = (("Free", "Off"), ("Free", "On"), ("Fixed", "On"), ("Driving", "On"), ("Fixed", "On"))
HELD = Outcome(
    seed=7, outcome="failed", message="Holding", exit_code=1, time_s=20.0, distance_m=0.0,
    arcs_m=(0.9, 0.85, 0.8, 0.7, 0.65, 0.6), gone=False, stopped=True, states=STATES, faults=(),
    held_before=True, held_at_end=True, torques=(0.0, -0.7, 0.7, -0.7, 0.7, 0.0), slid_m=0.0,
    short_m=nan, late_m=(),
)  # fmt: skip
SUCCEEDED = replace(HELD, outcome="succeeded", arcs_m=(1.4, 1.35, 1.3, 1.2, 1.15, 1.1))


def test_a_success_that_nothing_contradicts_has_passed():
    assert judge(SUCCEEDED, TrueEnd(beyond=1.0)) == ("passed", "", True, "")


@pytest.mark.parametrize(
    ("change", "end", "why"),
    [
        ({}, {"beyond": 1.1}, "with 1 wheels not beyond 1100 mm"),
        ({}, {"before": 1.35}, "with 2 wheels not before 1350 mm"),
        ({"gone": True}, {}, "and the robot has left the pipe"),
        ({"arcs_m": (1.2, 1.3, 1.1)}, {}, "with a part folded back on itself"),
        ({"short_m": 0.02}, {"at_word": True}, "with a wheel 20 mm short of where"),
        ({}, {"at_word": True}, "with a wheel nan mm short of where"),
        ({}, {"states": (("Fixed", "On"), ("Free", "On"))}, "and 1 of its states did not appear"),
    ],
)
def test_a_success_that_the_truth_contradicts_is_false(
    change: dict[str, Any], end: dict[str, Any], why: str
):
    verdict = judge(replace(SUCCEEDED, **change), TrueEnd(**end))
    assert (verdict.what, verdict.held) == ("false", False)
    assert verdict.why.startswith(f"said to have succeeded, {why}")


def test_a_wheel_may_be_as_short_of_its_word_as_is_allowed():
    assert judge(replace(SUCCEEDED, short_m=0.015), TrueEnd(at_word=True)).what == "passed"


def test_states_may_have_others_between_them():
    assert judge(SUCCEEDED, TrueEnd(states=(STATES[0], STATES[2], STATES[4]))).what == "passed"


def test_a_failure_with_the_robot_held_holds():
    assert judge(HELD, TrueEnd()) == ("failed", "Holding", True, "")


@pytest.mark.parametrize(
    ("change", "unsafe"),
    [
        ({"slid_m": 0.02}, ""),
        ({"slid_m": nan}, ""),
        ({"gone": True}, "left the pipe"),
        ({"stopped": False}, "wheels not stopped"),
        ({"held_at_end": False}, "let go: no part is held at the end"),
        ({"torques": (0.0,) * 6}, "let go: no joint bears a torque at the end"),
        ({"torques": ()}, "let go: no joint bears a torque at the end"),
    ],
)
def test_a_robot_that_says_it_holds_and_does_not(change: dict[str, Any], unsafe: str):
    verdict = judge(replace(HELD, **change), TrueEnd())
    assert (verdict.held, verdict.unsafe) == (False, unsafe)


@pytest.mark.parametrize(
    "change", [{"slid_m": 0.005}, {"torques": (0.0, -0.1)}, {"time_s": 3600.0}], ids=str
)
def test_a_robot_that_just_holds_holds_and_is_safe(change: dict[str, Any]):
    verdict = judge(replace(HELD, **change), TrueEnd())
    assert (verdict.held, verdict.unsafe) == (True, "")


def test_a_run_that_does_not_end_by_itself_is_not_safe():
    assert judge(replace(HELD, time_s=3601.0), TrueEnd()).unsafe == "did not end by itself"


def test_a_run_that_has_clamped_nothing_yet_has_not_let_go():
    assert judge(replace(HELD, held_before=False, held_at_end=False), TrueEnd()).unsafe == ""


def test_a_clamp_that_has_never_held_is_not_let_go() -> None:
    never = replace(HELD, held_before=False, held_at_end=True, torques=(0.0,) * 6)

    assert judge(never, TrueEnd()).unsafe == ""


def test_a_run_that_fails_in_its_first_clamp_has_not_let_go() -> None:
    order = Order("mitre_bend", seed=25, defects=("gamma_2_drops",), friction_jitter=0.2)
    outcome = run(replace(order, start_jitter_m=0.02))

    assert outcome.outcome == "fault"
    assert outcome.states[-1][2] == "FrontClampedRearRelaxed"
    assert judge(outcome, TrueEnd()).unsafe == ""
