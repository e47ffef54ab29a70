"""A wheel torque loop by itself, and with a geared motor whose frames come late."""

from __future__ import annotations

from math import nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._engine.robot.actuation_spec import WheelTorqueSpec
from pirate_sm.core._engine.robot.loops import Circumstances, WheelTorqueLoop

SPEC = WheelTorqueSpec(stall_torque_nm=0.2, no_load_rad_s=5.0, speed=0)
SPEEDS = st.floats(-20, 20)


def after(loop: WheelTorqueLoop, *speeds: float) -> WheelTorqueLoop:
    for speed in speeds:
        loop = loop.heard(Circumstances((speed,)))
    return loop


def test_a_wheel_that_stands_gets_the_share_of_its_stall_torque():
    assert WheelTorqueLoop(2, SPEC, 0.05).duty(()) == pytest.approx(0.25)


@pytest.mark.parametrize(("speed", "duty"), [(2.0, 0.65), (-2.0, -0.15)])
def test_it_makes_up_for_the_speed_of_the_wheel(speed, duty):
    assert after(WheelTorqueLoop(2, SPEC, 0.05), speed).duty(()) == pytest.approx(duty)


def test_an_unknown_speed_holds_the_duty():
    turning = after(WheelTorqueLoop(2, SPEC, 0.05), 2.0)

    assert after(turning, nan) == turning


@given(st.floats(-1, 1), st.lists(SPEEDS | st.just(nan)))
def test_whatever_it_hears_the_duty_is_one(target, speeds):
    assert abs(after(WheelTorqueLoop(2, SPEC, target), *speeds).duty(())) <= 1


@given(st.floats(-0.2, 0.2), st.lists(SPEEDS), SPEEDS)
def test_nothing_winds_up(target, speeds, speed):
    """It remembers the last speed alone."""
    old, new = after(WheelTorqueLoop(2, SPEC, target), *speeds), WheelTorqueLoop(2, SPEC, target)

    assert after(old, speed) == after(new, speed)


@given(st.floats(-0.15, 0.15), st.floats(-1.0, 1.0), st.integers(1, 3))
def test_a_wheel_of_a_steady_speed_gives_the_torque(target, speed, delay):
    loop = after(WheelTorqueLoop(2, SPEC, target), *[speed] * delay)

    torque = SPEC.stall_torque_nm * (loop.duty(()) - speed / SPEC.no_load_rad_s)
    assert torque == pytest.approx(target, abs=1e-12)
