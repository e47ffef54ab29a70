"""A mission hears once that a grip is exhausted, and asks in vain what no sensor tells."""

from __future__ import annotations

import shutil
from math import pi

import pytest
from driving import NEWT, PIRATE

from pirate_sm.core._loading.problems import LoadError

BODY = """\
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
on_fault:
  - {fault: grip.exhausted, go: weak}
  - {fault: [clamp.slipping, clamp.lost, robot.stuck], then: continue}
start: clamp
phases:
  clamp: {do: [{control: exp_3c}], wait: [{operator: on, go: done}], within: {time: 1 h, go: done}}
  weak: {wait: [{operator: on, go: done}], within: {time: 1 h, go: done}}
ends: {done: {succeed: Done}}
"""


def weak(text: str, friction: float) -> str:
    old = "friction: {front: 0.2, rear: 0.5}"
    assert old in text
    return text.replace(old, f"friction: {{front: {friction}, rear: {friction}}}")


@pytest.fixture
def slick(tmp_path):
    """The robot whose grip takes a wall to have so much friction."""

    def change(friction: float):
        robot = tmp_path / "slick"
        shutil.copytree(PIRATE, robot)
        profile = robot / "profile.yaml"
        profile.write_text(weak(profile.read_text("utf-8"), friction), "utf-8")
        return robot

    return change


@pytest.mark.parametrize(("friction", "exhausted"), [(0.2, 0), (0.01, 1)])
def test_a_mission_catches_a_grip_that_is_exhausted_once(drive, slick, friction, exhausted):
    driver = drive(BODY, slick(friction))
    driver.accept()
    driver.signals |= {
        "gamma_1": -1.85, "gamma_2": 1.75, "gamma_3": -1.75, "gamma_4": 1.85,
        "bend_torque_1": -0.7, "bend_torque_4": 0.7,
    }  # fmt: skip
    driver.signals |= {"acc_x": 9.81 * 0.68, "acc_y": 9.81 * 0.73, "acc_z": 0.0}

    driver.run(6.0)

    told = [code for code, _ in driver.faults if code == "grip.exhausted"]
    assert len(told) == exhausted
    assert driver.faults.count(("grip.exhausted", "weak")) == exhausted
    assert abs(driver.state.surveyed.reported.pitch_rad) == pytest.approx(pi / 2, abs=0.2)


def test_a_mission_cannot_ask_for_the_friction_of_a_robot_without_such_signals(drive):
    body = """\
start: a
phases: {a: {wait: [{when: mu_estimate_front < 0.25, go: e}], within: {time: 1 h, go: e}}}
ends: {e: {succeed: Done}}
"""
    with pytest.raises(LoadError, match="unknown name 'mu_estimate_front'"):
        drive(body, NEWT)
