"""The rows of the bend: how a run is judged, and that sharing the work changes nothing."""

from __future__ import annotations

from dataclasses import replace
from math import nan

import pytest

from benchmarks.campaign import Outcome, run, run_all
from benchmarks.seeds import Row, judge
from pirate_sm.wiring import Order

BEYOND = (1.4, 1.35, 1.3, 1.2, 1.15, 1.1)
HELD = Outcome(
    seed=7, outcome="failed", message="Holding", exit_code=1, time_s=20.0, distance_m=0.0,
    arcs_m=(0.9, 0.85, 0.8, 0.7, 0.65, 0.6), gone=False, stopped=True, states=(), faults=(),
    held_at_end=True, torques=(0.0, -0.7, 0.7, -0.7, 0.7, 0.0), slid_m=0.0, short_m=nan, late_m=(),
)  # fmt: skip
FLAT = Row("flat", "mitre_bend")
UPRIGHT = Row("upright", "take_bend", holding=True, snapshots=False)


def test_a_run_that_ends_beyond_the_bend_has_passed():
    verdict = judge(replace(HELD, outcome="succeeded", arcs_m=BEYOND), UPRIGHT, [])
    assert (verdict.passed, verdict.counts, verdict.false) == (True, True, False)


def test_a_success_before_the_bend_is_false():
    verdict = judge(replace(HELD, outcome="succeeded"), UPRIGHT, [])
    assert (verdict.passed, verdict.counts, verdict.false) == (False, False, True)


def test_a_robot_that_holds_counts_where_a_leg_is_upright_only():
    assert judge(HELD, UPRIGHT, []).counts
    assert not judge(HELD, FLAT, []).counts


@pytest.mark.parametrize("change", [
    {"slid_m": 0.02}, {"gone": True}, {"stopped": False}, {"held_at_end": False},
    {"torques": (0.0,) * 6},
])  # fmt: skip
def test_a_robot_that_says_it_holds_and_does_not_is_not_counted(change):
    verdict = judge(replace(HELD, **change), UPRIGHT, [])
    assert not verdict.counts
    assert verdict.why == "NOT HELD: Holding"


def test_outcomes_are_the_same_for_any_number_of_workers():
    orders = [Order("enter_2d", seed=seed, friction_jitter=0.2) for seed in range(3)]
    # As text, for NaN (no word was said) is not equal to itself.
    assert repr(run_all(orders, workers=1)) == repr(run_all(orders, workers=2))


def test_values_of_motors_replace_those_of_the_profile():
    order = Order("climb")
    as_it_is = run(order)
    free = run(order, (("wheel", "hold_torque", 0.001),))
    assert as_it_is.outcome == "succeeded"
    assert free.outcome != "succeeded"  # nothing holds the wheels at the top
