"""A mission that succeeds has its wheels where the detector's last word says, by the truth."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest
from representative import thorough_but

import pirate_sm
from benchmarks.camera_bends import is_false, joint_defects
from benchmarks.campaign import run
from pirate_sm.core import library
from pirate_sm.core.loading import load_robot
from pirate_sm.lab.campaign.watched_run import SHORT_M
from pirate_sm.running.wiring import Order

HEEDLESS = Path(__file__).parents[2] / "campaigns" / "missions"
DETECTORS = ("sim", "odometry")
DEFECTS = joint_defects(load_robot(library.find_robot("pirate_ii")).profile)


def test_the_campaign_knows_the_defects_of_joints_from_the_profile() -> None:
    assert {"gamma_2_drops", "gamma_2_stiff", "gamma_3_spikes", "gamma_1_zero_jumps"} < {*DEFECTS}
    assert not {"imu_stale", "wheels_3_4_dead", "bay_silent"} & {*DEFECTS}


@pytest.mark.parametrize(
    ("defect", "detector"),
    thorough_but(
        {("gamma_2_drops", "sim"), ("gamma_2_stiff", "odometry")}, product(DEFECTS, DETECTORS)
    ),
)
def test_no_defect_of_a_joint_makes_a_mission_succeed_falsely(defect: str, detector: str) -> None:
    heedless = sorted(map(str, HEEDLESS.glob("*.yaml")))
    assert len(heedless) == 2
    missions = ["mitre_bend", "exp_2c_tilted", *heedless]
    for number, mission in enumerate(missions):
        outcome = run(Order(mission, seed=number, defects=(defect,), detector=detector))
        assert not is_false(outcome), f"{mission}: {outcome.short_m * 1000:.0f} mm short"
        assert outcome.stopped


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize(
    "mission",
    thorough_but(
        {"mitre_bend_backward"},
        ["mitre_bend", "mitre_bend_backward", "mitre_bend_other_side"],
    ),
)
def test_a_sound_robot_succeeds_with_its_wheel_beyond_the_words_place(
    mission: str, detector: str
) -> None:
    outcome = run(Order(mission, detector=detector))
    assert outcome.outcome == "succeeded"
    assert outcome.short_m < SHORT_M


@pytest.mark.thorough
@pytest.mark.parametrize("after_s", thorough_but({12}, [9, 12, 16]))
@pytest.mark.parametrize("mission", ["mitre_bend", str(HEEDLESS / "mitre_bend_heedless.yaml")])
def test_belief_a_silent_joint_of_the_part_that_holds_lets_go_of_nothing(
    mission: str, after_s: int
) -> None:
    done = pirate_sm.run(mission, defects=[f"board_26_silent:after={after_s}s"], check=False)

    silent_s = done.faults["time_s"][done.faults["code"].index("sensor.silent")]
    commands = zip(*(done.commands[key] for key in ("time_s", "name", "status")), strict=True)
    later = {name for at_s, name, status in commands if at_s >= silent_s and status == "accepted"}
    assert done.outcome != "succeeded"
    assert "RelaxRear" not in later
    assert "BendingState" in done.states["unconfirmed"][-1]


STIFF = "gamma_4_stiff:friction=0.9Nm"
JUMPS = "gamma_1_zero_jumps:after=2s,by={}"
"""By 13 deg a joint jumps faster than slow motors turn: that is another fault."""


@pytest.mark.parametrize("seed", thorough_but({0}, range(12)))
def test_belief_a_folded_robot_before_the_bend_has_not_passed_it(seed: int) -> None:
    two = STIFF, JUMPS.format("7deg")
    order = Order("mitre_bend", pipe="mitre_60", seed=seed, defects=two, detector="odometry")
    outcome = run(order)

    assert outcome.outcome != "succeeded"
    assert outcome.stopped


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(12))
def test_belief_a_folded_robot_with_quick_joints_has_not_passed_the_bend_either(
    assumed_speeds: str, seed: int
) -> None:
    two = STIFF, JUMPS.format("13deg")
    order = Order("mitre_bend", pipe="mitre_60", seed=seed, defects=two, detector="odometry")
    outcome = run(replace(order, twin=assumed_speeds))

    assert outcome.outcome != "succeeded"
    assert outcome.stopped


@pytest.mark.parametrize("seed", thorough_but({3, 7}, range(12)))
def test_belief_a_joint_sensor_that_sticks_in_the_bend_makes_no_false_success(seed: int) -> None:
    defects = ("gamma_2_sticks:after=22s",)
    outcome = run(Order("mitre_bend_backward", seed=seed, defects=defects, detector="odometry"))

    assert not is_false(outcome), f"{outcome.short_m * 1000:.0f} mm short"


@pytest.mark.parametrize(
    ("quick", "jump", "why"),
    [
        (True, "13deg", r"diameter_front shows 11\d mm where it has 120 mm"),
        pytest.param(
            False,
            "7deg",
            r"a wheel would be in a wall, or its parts do not lie along one axis",
            marks=pytest.mark.thorough,
        ),
    ],
)
def test_belief_a_bend_that_the_shape_contradicts_ends_holding_with_that_reason(
    assumed_speeds: str, quick: bool, jump: str, why: str
) -> None:
    twin, defects = assumed_speeds if quick else None, (JUMPS.format(jump),)
    done = pirate_sm.run("mitre_bend", twin=twin, defects=defects, detector="odometry", check=False)

    assert done.faults["code"] == ["place.contradicted"]
    assert re.search(f"the robot does not fit the pipe there: {why}", done.message)
    held = done.states["BendingState"][-1], done.states["unconfirmed"][-1]
    assert held == ("DoubleClamped", "FrontWheelsState RearWheelsState")


def test_belief_a_joint_that_shows_the_same_all_through_a_bend_proves_nothing() -> None:
    defects = ("gamma_3_sticks:after=4.9s", "gamma_4_stiff:after=9.3s,friction=0.33Nm")
    pipe = "mitre_90_from_below"
    order = Order("take_bend", pipe=pipe, seed=62, defects=defects, detector="odometry")
    outcome = run(order)

    assert not is_false(outcome), f"{outcome.short_m * 1000:.0f} mm short"
