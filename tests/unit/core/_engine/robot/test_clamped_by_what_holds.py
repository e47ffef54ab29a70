"""A clamp is what joints show that stand still under their duty, whatever their motors give."""

import math

import pytest
from driving import IDLE, command

BENT = {"gamma_1": math.radians(-106), "gamma_2": math.radians(100)}


def clamping(drive, mission, torque_nm):
    driver = drive(mission)
    driver.signals |= BENT | {"bend_torque_1": -torque_nm, "bend_torque_2": torque_nm}
    driver.report_all(0.1)
    command(driver, "ClampFront")
    driver.accept()
    return driver


def done_after_s(driver, at_most=25.0):
    began = driver.now
    while driver.last_status.status == "accepted":
        assert driver.now < began + at_most
        driver.report_all(driver.now + 0.05)
    assert driver.last_status.status == "done", driver.last_status.reason
    return driver.now - began


@pytest.mark.parametrize(("torque_nm", "after_s"), [(0.5, 0.25), (0.48, 1.5), (0.159, 1.5)])
def test_belief_in_a_clamp_does_not_ask_for_the_motor_of_the_profile(drive, torque_nm, after_s):
    """The thesis measured 0.159 Nm at a joint that held; 500 mNm were asked for."""
    driver = clamping(drive, f"pipe: mitre_90\n{IDLE}", torque_nm)
    assert done_after_s(driver) == pytest.approx(after_s, abs=0.11)


@pytest.mark.parametrize(("pipe", "least"), [("mitre_90", 100), ("vertical", 187)])
def test_belief_in_a_clamp_ends_where_it_cannot_hold_the_robot(drive, pipe, least):
    driver = clamping(drive, f"pipe: {pipe}\n{IDLE}", least / 1000 - 0.01)
    driver.run(45.0)
    assert driver.last_status.status == "failed"
    assert f"bend_torque_1 should be at least {least} mNm" in driver.last_status.reason


def test_a_weak_clamp_must_stand_still_all_the_time(drive):
    driver = clamping(drive, f"pipe: mitre_90\n{IDLE}", 0.3)
    driver.run(driver.now + 1.2)
    driver.run(driver.now + 0.2, every=0.1, gamma_1=-0.3)  # rad/s
    assert driver.last_status.status == "accepted"
    assert done_after_s(driver) > 1.2
