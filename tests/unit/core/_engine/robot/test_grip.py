"""How hard a part presses: eq. 3-16 to 3-25 with the thesis's numbers, and what it remembers."""

from __future__ import annotations

from math import asin, cos, inf, isnan, nan, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._engine.robot.actuation_spec import (
    GripSpec,
    TorqueSpec,
    VelocitySpec,
    WheelTorqueSpec,
)
from pirate_sm.core._engine.robot.loops import (
    Circumstances,
    RunningTorqueLoop,
    RunningVelocityLoop,
    WheelTorqueLoop,
    gripping,
    gripping_after,
    torque_nm,
)

UPRIGHT, LEVEL = pi / 2, 0.0
ANGLE, SLIP, MU_A, MU_B, TORQUE, SPEED = range(6)
IN_12_CM = 2 * asin((0.120 - 0.048) / 0.090)
AS_PRINTED = GripSpec(
    safety=2.0,
    friction=nan,
    estimates=(MU_A, MU_B),
    slip_speeds=(SLIP,),
    speed=SPEED,
    angle=ANGLE,
    leg_m=0.090,
    weight_n=0.79 * 9.81,
    wheels=6,
    share=1.0,
    at_least_nm=0.1,
    at_most_nm=0.7,
    alarm_m_s=0.010,
    lower_nm_s=0.07,
)
CORRECTED = AS_PRINTED._replace(share=2.0)


def seen(
    now_s=0.0, *, mu=nan, other=nan, slip=0.0, pitch=UPRIGHT, angle=IN_12_CM, torque=0.0, speed=0.0
) -> Circumstances:
    return Circumstances((angle, slip, mu, other, torque, speed), pitch, now_s)


def course(spec, *each: Circumstances):
    now = gripping(spec)
    for one in each:
        now = gripping_after(spec, now, one)
    return now


@pytest.mark.parametrize(("friction", "printed_nm"), [(0.2, 0.35), (0.5, 0.14)])
@pytest.mark.parametrize("way", [1, -1])
def test_upright_in_12_cm_it_is_what_the_thesis_prints(friction, printed_nm, way):
    for angle in (IN_12_CM, -IN_12_CM):
        size = torque_nm(AS_PRINTED, friction, angle, way * UPRIGHT)
        assert size == pytest.approx(printed_nm, abs=0.005)
        assert torque_nm(CORRECTED, friction, angle, way * UPRIGHT) == pytest.approx(2 * size)


def test_level_it_is_a_wheels_share_of_the_weight():
    size = torque_nm(AS_PRINTED, 0.2, IN_12_CM, LEVEL)

    assert size == pytest.approx(0.5 * 0.054 * 0.79 * 9.81 / 6)


@given(st.floats(0.05, 1.0), st.floats(-pi / 2, pi / 2))
def test_it_presses_so_hard_that_friction_could_bear_safety_times_the_weight(friction, pitch):
    # By the law of the thesis each of six wheels gets 2 tau over the reach of a leg.
    normal_n = 2 * torque_nm(AS_PRINTED, friction, IN_12_CM, pitch) / (0.090 * cos(IN_12_CM / 2))
    along_n, across_n = 0.79 * 9.81 * abs(sin(pitch)), 0.79 * 9.81 * cos(pitch)

    assert 6 * friction * (normal_n - across_n / 6) == pytest.approx(2 * along_n)


@pytest.mark.parametrize(
    "unknown", [{"mu": nan}, {"mu": 0.5, "pitch": nan}, {"mu": 0.5, "angle": nan}]
)
def test_it_presses_all_it_may_while_anything_is_unknown(unknown):
    now = course(CORRECTED, *[seen(t, **unknown) for t in (0.0, 5.0, 60.0)])

    assert now.torque_nm == CORRECTED.at_most_nm
    assert not now.exhausted


def test_once_friction_is_known_it_is_lowered_slowly():
    now = course(CORRECTED, seen(0.0, mu=0.5), seen(1.0, mu=0.5))
    assert now.torque_nm == pytest.approx(0.7 - 0.07)

    now = gripping_after(CORRECTED, now, seen(60.0, mu=0.5))
    assert now.torque_nm == pytest.approx(torque_nm(CORRECTED, 0.5, IN_12_CM, UPRIGHT))


def test_the_least_known_friction_counts_and_is_remembered():
    now = course(CORRECTED, seen(0.0, mu=0.6, other=0.4), seen(1.0), seen(60.0))

    assert now.friction == 0.4
    assert now.torque_nm == pytest.approx(torque_nm(CORRECTED, 0.4, IN_12_CM, UPRIGHT))


@pytest.mark.parametrize("slip", [0.011, -0.011])
def test_a_slipping_wheel_raises_it_at_once(slip):
    calm = course(CORRECTED, seen(0.0, mu=0.6), seen(60.0, mu=0.6))
    assert calm.torque_nm < 0.3

    assert gripping_after(CORRECTED, calm, seen(60.1, mu=0.6, slip=slip)).torque_nm == 0.7
    assert gripping_after(CORRECTED, calm, seen(60.1, mu=0.6, slip=0.009)).torque_nm < 0.3
    assert gripping_after(CORRECTED, calm, seen(60.1, mu=0.6, slip=nan)).torque_nm < 0.3


def test_less_friction_raises_it_at_once():
    calm = course(CORRECTED, seen(0.0, mu=0.6), seen(60.0, mu=0.6))

    now = gripping_after(CORRECTED, calm, seen(60.1, mu=0.3))

    assert now.torque_nm == pytest.approx(torque_nm(CORRECTED, 0.3, IN_12_CM, UPRIGHT))


def test_it_stays_within_its_bounds():
    assert course(CORRECTED, seen(0.0, mu=5.0, pitch=LEVEL), seen(60.0, mu=5.0, pitch=LEVEL)) == (
        CORRECTED.at_least_nm, 5.0, 60.0, False,
    )  # fmt: skip
    assert course(CORRECTED, seen(0.0, mu=0.01)).torque_nm == CORRECTED.at_most_nm


@pytest.mark.parametrize(("mu", "exhausted"), [(0.13, False), (0.12, True), (0.0, True)])
def test_it_is_exhausted_where_the_margin_is_less_than_a_quarter(mu, exhausted):
    # Twice the safety needs 0.70 Nm at 0.2; a margin of 1.25 instead of 2 needs 0.70 at 0.125.
    assert course(CORRECTED, seen(0.0, mu=mu)).exhausted is exhausted


def test_a_given_friction_needs_no_estimate():
    given_one = AS_PRINTED._replace(friction=0.2)

    now = course(given_one, seen(0.0, mu=0.9), seen(60.0, mu=0.9))

    assert now.torque_nm == pytest.approx(0.35, abs=0.005)


@pytest.mark.parametrize(
    ("slip", "speed", "pitch", "torque", "exhausted"),
    [
        (0.05, -0.05, UPRIGHT, 0.69, True),
        (-0.05, 0.14, -UPRIGHT, 0.69, True),
        (0.05, -0.05, nan, 0.69, True),  # nothing is known of the tilt
        (0.009, -0.05, UPRIGHT, 0.69, False),  # no more than noise
        (nan, -0.05, UPRIGHT, 0.69, False),
        (0.05, nan, UPRIGHT, 0.69, False),
        (-0.05, 0.05, UPRIGHT, 0.69, False),  # somebody pulls it up
        (0.05, 0.02, UPRIGHT, 0.69, False),  # its wheels turn faster than it climbs
        (0.05, -0.05, UPRIGHT, 0.40, False),  # the clamp is still being wound
    ],
)
def test_it_is_exhausted_where_a_robot_is_carried_down_though_it_presses_all_it_may(
    slip, speed, pitch, torque, exhausted
):
    spec = TorqueSpec(
        gain=1.0, dead_nm=0.03, least_duty=0.15, limit=0.7, within_nm=0.04, stall_torque_nm=1.0,
        torque=TORQUE,
    )  # fmt: skip
    moment = seen(1.0, slip=slip, speed=speed, pitch=pitch, torque=torque)

    assert RunningTorqueLoop(0, spec, 0.35, CORRECTED).heard(moment).exhausted is exhausted


@pytest.mark.parametrize("asked", [-0.35, 0.35])
def test_a_loop_keeps_the_sign_of_the_torque_that_its_state_asks_for(asked):
    spec = TorqueSpec(
        gain=1.0, dead_nm=0.03, least_duty=0.15, limit=0.7, within_nm=0.04, stall_torque_nm=1.0,
        torque=TORQUE,
    )  # fmt: skip
    loop = RunningTorqueLoop(0, spec, asked, CORRECTED)

    loop = loop.heard(seen(0.0))

    assert loop.target_nm == (0.7 if asked > 0 else -0.7)
    assert loop.duty(()) * asked > 0
    assert loop.asks == (asked, CORRECTED)


@pytest.mark.parametrize("assist_nm", [0.03, -0.03])
@pytest.mark.parametrize(("pitch", "share"), [(UPRIGHT, 1), (-UPRIGHT, -1), (LEVEL, 0), (nan, 0)])
def test_wheels_bear_the_weight_by_the_tilt_of_the_pipe(assist_nm, pitch, share):
    around = Circumstances((3.0,), pitch, 0.0)
    velocity = VelocitySpec(0.3, 1.0, 5.0, 0, 0.024, stall_nm=0.3)
    torque = WheelTorqueSpec(stall_torque_nm=0.3, no_load_rad_s=inf, speed=0)

    kept = RunningVelocityLoop(0, velocity, 3.0, assist_nm).heard(around)
    borne = WheelTorqueLoop(0, torque, 0.1, assist_nm).heard(around)

    assert kept.duty(()) == pytest.approx(3.0 / 5.0 + share * assist_nm / 0.3)
    assert borne.duty(()) == pytest.approx((0.1 + share * assist_nm) / 0.3)


def test_a_tilt_that_becomes_unknown_keeps_what_the_wheels_bear():
    spec = VelocitySpec(0.3, 1.0, 5.0, 0, 0.024, stall_nm=0.3)
    loop = RunningVelocityLoop(0, spec, 3.0, 0.03).heard(Circumstances((3.0,), UPRIGHT, 0.0))

    assert loop.heard(Circumstances((3.0,), nan, 0.1)).duty(()) == loop.duty(())
    assert not isnan(loop.duty(()))
