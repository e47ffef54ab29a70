"""Slip between speeds that are means over different times: of starts and stops none is made up."""

from __future__ import annotations

from itertools import accumulate, pairwise
from math import isnan, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._engine.sensing.known_signals import KEPT_S, Stretch, lengthened, slip_between

FAST_M_S, ALARM_M_S = 0.090, 0.010


class Course:
    """A place along the pipe that moves at a constant speed between two times."""

    def __init__(self, *steps: tuple[float, float]) -> None:
        self.steps = (*steps, (1e9, 0.0))

    def place_m(self, at_s: float) -> float:
        """Where it is: each step says from when on it has which speed."""
        return sum(
            m_s * max(0.0, min(at_s, until_s) - from_s)
            for (from_s, m_s), (until_s, _) in pairwise(self.steps)
        )

    def means(self, times: list[float], delay_s: float = 0.0) -> tuple[Stretch, ...]:
        """Return its mean speeds between these times, told after a delay."""
        return tuple(
            Stretch(
                one + delay_s,
                two + delay_s,
                (self.place_m(two) - self.place_m(one)) / (two - one),
            )
            for one, two in pairwise(times)
        )


frame_times = st.lists(st.sampled_from([0.096, 0.192, 0.288]), min_size=3, max_size=6)


@given(
    gaps=frame_times,
    before_s=st.floats(0.0, 1.5),
    lasts_s=st.floats(0.6, 1.0),
    offset_s=st.floats(0.0, 0.1),
    delay_s=st.floats(0.0, 0.05),
    way=st.sampled_from([1, -1]),
)
def test_a_wheel_that_rolls_sets_off_no_alarm_wherever_it_starts_and_stops(
    gaps, before_s, lasts_s, offset_s, delay_s, way
):
    times = [-2.0, *accumulate(gaps, initial=0.0)]
    begins_s = times[-1] - before_s
    course = Course((begins_s, way * FAST_M_S), (begins_s + lasts_s, 0.0))
    rims = course.means(times, delay_s)
    heard = [offset_s + 0.1 * n - 0.2 for n in range(40)]
    readings = course.means([t for t in heard if t <= rims[-1].until_s])

    assert not abs(slip_between(rims, readings, 0.05).slip_m_s) > ALARM_M_S


@given(st.floats(-0.5, 0.5), st.floats(0.0, 0.1))
def test_of_a_steady_wheel_it_is_the_difference(body_m_s, offset_s):
    frames = [0.112 * n for n in range(8)]
    readings = Course((-1.0, body_m_s)).means([offset_s + 0.1 * n - 0.2 for n in range(10)])

    slip = slip_between(Course((0.0, FAST_M_S)).means(frames), readings, 0.05)

    assert slip.slip_m_s == pytest.approx(FAST_M_S - body_m_s)
    assert slip.body_m_s == pytest.approx(body_m_s)


def test_a_robot_that_falls_while_its_wheels_are_stopped_is_seen_to_slip():
    wheels = Course((0.0, FAST_M_S), (0.5, 0.0))
    body = Course((0.0, FAST_M_S), (0.5, 0.0), (0.6, -0.2))
    rims = wheels.means([0.112 * n for n in range(9)])
    readings = body.means([0.1 * n for n in range(10)])

    assert slip_between(rims, readings, 0.05).slip_m_s == pytest.approx(0.2)


def test_while_a_wheel_speeds_up_slip_is_the_least_that_explains_the_body():
    rims = (Stretch(0.0, 0.1, 0.0), Stretch(0.1, 0.2, 0.06))

    for body_m_s, slip in ((0.10, -0.04), (-0.02, 0.02), (0.03, nan)):
        found = slip_between(rims, (Stretch(0.05, 0.15, body_m_s),), 0.0).slip_m_s
        assert found == pytest.approx(slip, nan_ok=True)


def test_nothing_is_known_before_both_are():
    one = (Stretch(0.0, 0.1, 0.0),)

    assert isnan(slip_between((), one, 0.0).slip_m_s)
    assert isnan(slip_between(one, (), 0.0).slip_m_s)


def test_a_reading_later_than_the_frame_waits_for_the_next():
    rims = (Stretch(0.0, 0.1, 0.0),)

    assert isnan(slip_between(rims, (Stretch(0.05, 0.15, 0.09),), 0.0).slip_m_s)
    assert isnan(slip_between(rims, (Stretch(-0.02, 0.08, 0.09),), 0.05).slip_m_s)


def test_stretches_follow_each_other_and_old_ones_are_forgotten():
    stretches = lengthened((), 0.1, 5.0)
    stretches = lengthened(stretches, 0.2, 5.1)
    assert stretches == (Stretch(5.0, 5.0, 0.1), Stretch(5.0, 5.1, 0.2))

    assert lengthened(stretches, 0.3, 5.05 + KEPT_S) == (
        Stretch(5.0, 5.1, 0.2),
        Stretch(5.1, 5.05 + KEPT_S, 0.3),
    )
    assert lengthened(stretches, 0.3, 5.2, since_s=5.15)[-1] == Stretch(5.15, 5.2, 0.3)
    assert lengthened(stretches, nan, 5.2) == ()
