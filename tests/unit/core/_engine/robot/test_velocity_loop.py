"""A velocity loop by itself: what it sends, what it learns, where it stops to learn."""

from __future__ import annotations

from math import nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._engine.robot.actuation_spec import VelocitySpec
from pirate_sm.core._engine.robot.loops import Circumstances, RunningVelocityLoop

SPEC = VelocitySpec(gain=0.3, limit=1.0, no_load_rad_s=5.0, speed=0, radius_m=0.02)
SPEEDS = st.floats(-20, 20)


def after(loop: RunningVelocityLoop, *speeds: float) -> RunningVelocityLoop:
    for speed in speeds:
        loop = loop.heard(Circumstances((speed,)))
    return loop


def test_it_begins_with_the_duty_of_a_motor_without_load():
    assert RunningVelocityLoop(2, SPEC, 3.0).duty(()) == pytest.approx(0.6)


def test_a_fresh_frame_adds_its_share_of_the_error():
    slow = after(RunningVelocityLoop(2, SPEC, 3.0), 2.0)

    assert slow.integral == pytest.approx(0.3 * (3.0 - 2.0) / 5.0)
    assert slow.duty(()) == pytest.approx(0.6 + slow.integral)


def test_an_unknown_speed_holds_the_integral():
    slow = after(RunningVelocityLoop(2, SPEC, 3.0), 2.0)

    assert after(slow, nan) == slow


@pytest.mark.parametrize("target", [3.0, -3.0])
@pytest.mark.parametrize("drop", [0.0, 0.2, -0.2])
@pytest.mark.parametrize("delay", [1, 2, 3])
def test_a_loaded_wheel_comes_to_its_speed_although_frames_are_late(target, drop, delay):
    loop, speeds = RunningVelocityLoop(2, SPEC, target), [0.0] * delay

    for _ in range(60):
        loop = loop.heard(Circumstances((speeds[-delay],)))
        speeds.append(5.0 * (loop.duty(()) - drop))

    assert speeds[-10:] == pytest.approx([target] * 10, rel=0.01)


def test_a_wheel_that_was_blocked_for_long_slows_down_with_the_next_frames():
    blocked = after(RunningVelocityLoop(2, SPEC, 3.0), *[0.0] * 100)
    assert blocked.duty(()) == 1.0

    assert after(blocked, 5.0).duty(()) == pytest.approx(1.0 - 0.3 * 2.0 / 5.0)


@given(st.floats(-10, 10), st.floats(0.01, 1), st.floats(0.05, 1), st.lists(SPEEDS | st.just(nan)))
def test_whatever_it_hears_the_duty_stays_within_its_limit(target, gain, limit, speeds):
    loop = after(RunningVelocityLoop(2, SPEC._replace(gain=gain, limit=limit), target), *speeds)

    assert abs(loop.duty(())) <= limit


@given(st.floats(-10, 10), st.lists(SPEEDS), SPEEDS)
def test_a_wheel_that_is_too_slow_never_gets_less(target, speeds, speed):
    loop = after(RunningVelocityLoop(2, SPEC, target), *speeds)
    change = after(loop, speed).duty(()) - loop.duty(())

    assert change * (target - speed) >= -1e-12
