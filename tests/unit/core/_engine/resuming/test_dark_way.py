"""How far a robot has driven while nobody recorded it, by what its wheels show."""

from __future__ import annotations

from dataclasses import replace
from math import inf, isnan, nan, pi

import pytest
from cut_off import CutOff
from driving import BOTH_CLAMPED, IDLE, changed_newt, command

from pirate_sm.core._engine.unwatched import DarkWay, dark_way, odometry_m
from pirate_sm.core._loading.robot.loader import load_robot

RADIUS_M = 0.024
WHEELS = range(1, 7)
FORWARD = {number: 1 if number in (1, 3, 5) else -1 for number in WHEELS}
"""Which way each wheel turns when the robot goes forward."""


def rolled(way_m: float, **also: float) -> dict[str, float]:
    """What the wheel angles show after this way."""
    return {f"theta_{n}": FORWARD[n] * way_m / RADIUS_M for n in WHEELS} | also


def driving(drive, begun_m: float = 0.5, driven_s: float = 0.4) -> CutOff:
    """A robot that is cut off while it drives forward, half a metre on."""
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.signals |= rolled(begun_m)
    driver.run(1.0)
    command(driver, "DriveForward")
    driver.accept()
    driver.run(1.2)
    return CutOff(driver, driven_s)


def test_wheels_that_agree_show_the_way(drive):
    way = driving(drive).look(**rolled(0.52)).way

    assert way.exact
    assert way.low_m == way.high_m == pytest.approx(0.02, abs=1e-4)


def test_wheels_that_do_not_agree_leave_an_interval(drive):
    way = driving(drive).look(**rolled(0.52, theta_2=FORWARD[2] * 0.5 / RADIUS_M)).way

    assert not way.exact
    assert way.low_m == -way.high_m == pytest.approx(-0.4 * 6.3 * RADIUS_M)


def test_belief_in_an_exact_place_takes_more_than_one_wheel(drive):
    others = {f"theta_{number}": nan for number in WHEELS if number != 2}

    way = driving(drive).look(**rolled(0.52, **others)).way

    assert not way.exact
    assert way.low_m == -way.high_m < 0.0


def test_two_wheels_are_enough_for_an_exact_place(drive):
    others = {f"theta_{number}": nan for number in WHEELS if number not in (2, 5)}

    way = driving(drive).look(**rolled(0.52, **others)).way

    assert way.exact
    assert way.low_m == pytest.approx(0.02, abs=1e-4)


def test_counters_that_began_anew_show_nothing(drive):
    way = driving(drive).look(**rolled(0.0)).way

    assert not way.exact
    assert not way.moved


def test_counters_near_zero_may_have_begun_anew(drive):
    assert not driving(drive, begun_m=0.01).look(**rolled(0.02)).way.exact


def test_absolute_encoders_show_the_way_up_to_whole_turns(drive):
    cut = driving(drive, begun_m=0.01)
    dark = replace_absolute(cut)

    way = cut.look(**rolled(0.03 - 2 * pi * RADIUS_M)).way

    assert dark == frozenset(range(6))
    assert way.exact
    assert way.low_m == pytest.approx(0.02, abs=1e-4)


def test_an_absolute_encoder_that_is_not_read_shows_nothing(drive):
    cut = driving(drive, begun_m=0.01)
    replace_absolute(cut)

    way = cut.look(**rolled(0.03, theta_1=nan)).way

    assert way.why == "5 driven wheels agree on it"


def test_absolute_encoders_do_not_tell_turns_apart(drive):
    cut = driving(drive, driven_s=1.0)
    replace_absolute(cut)

    assert not cut.look(**rolled(0.52)).way.exact


def replace_absolute(cut: CutOff) -> frozenset[int]:
    """All wheels of the robot have absolute encoders."""
    sight = cut.robot.sight
    dark = sight.dark._replace(absolute=frozenset(range(len(cut.robot.wheels))))
    cut.robot = replace(cut.robot, sight=replace(sight, dark=dark))
    return dark.absolute


def test_more_than_the_motors_can_do_is_asked_about(drive):
    found = driving(drive).look(**rolled(0.6))

    assert found.questions == (
        "wheels have rolled 100, 100, 100, 100, 100, 100 mm, but driven they can have 60 mm",
    )


def test_nobody_knows_the_way_of_wheels_driven_for_nobody_knows_how_long(drive):
    way = driving(drive, driven_s=float("inf")).look(**rolled(0.52)).way

    assert way.low_m == -way.high_m == float("-inf")


def test_a_robot_that_was_not_driven_is_where_it_was(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.run(1.0)

    way = CutOff(driver, driven_s=5.0).look().way

    assert (way.low_m, way.high_m, way.exact) == (0.0, 0.0, True)


def test_the_profile_says_which_wheels_are_absolute(tmp_path):
    robot = changed_newt(tmp_path, ("name: left_fore,", "name: left_fore, absolute: true,"))

    assert load_robot(robot).normal.sight.dark.absolute == frozenset({0})


def test_the_odometry_goes_on_from_the_middle_of_the_way(drive):
    cut = driving(drive)
    last = cut.last.sensing
    known = last.numbers[cut.robot.odometry]

    assert odometry_m(cut.robot, last, cut.look(**rolled(0.52)).way) == pytest.approx(
        known + 0.02, abs=1e-4
    )
    assert odometry_m(cut.robot, last, DarkWay(0.1, 0.4, False, "")) == pytest.approx(known + 0.25)
    assert odometry_m(cut.robot, last, DarkWay(-inf, inf, False, "")) == known
    last = last._replace(numbers=(*last.numbers[:-1], 1.0))
    assert isnan(odometry_m(replace(cut.robot, odometry=-1), last, DarkWay(0.1, 0.4, False, "")))


def test_what_the_motors_cannot_have_done_leaves_every_way_open(drive):
    way = driving(drive).look(**rolled(0.6)).way

    assert (way.low_m, way.high_m) == (-inf, inf)
    assert way.seen == frozenset()


def test_boards_that_were_heard_at_different_times_are_levelled(drive):
    """At 0.1 m/s a board whose last report is 0.5 s older has rolled 50 mm more since."""
    cut = driving(drive, driven_s=1.5)
    sensing, robot = cut.last.sensing, cut.robot
    number = robot.wheel_boards[0]
    heard_s, numbers = list(sensing.heard_s), list(sensing.numbers)
    heard_s[number] -= 0.5
    for wheel in robot.wheels:
        numbers[wheel.speed] = 0.1 / wheel.metres_per_rad
    sensing = sensing._replace(heard_s=tuple(heard_s), numbers=tuple(numbers))
    cut.last = cut.last._replace(sensing=sensing)
    late = {
        f"theta_{n}": FORWARD[n] * (0.57 if board == number else 0.52) / RADIUS_M
        for n, board in zip(WHEELS, robot.wheel_boards, strict=True)
    }

    assert cut.look(**late).way.exact
    assert not cut.look(**rolled(0.52)).way.exact


class TestExactly:
    """What is returned for a robot that was driven 20 mm, 0.4 s long at 100 mm/s at most."""

    @pytest.fixture
    def cut(self, drive) -> CutOff:
        return driving(drive)

    @staticmethod
    def angles(cut: CutOff, *numbers: int) -> frozenset[int]:
        return frozenset(cut.robot.wheels[number - 1].angle for number in numbers or WHEELS)

    @staticmethod
    def known_before(cut: CutOff, **changes) -> None:
        """Something else was known when the recording ended."""
        cut.last = cut.last._replace(sensing=cut.last.sensing._replace(**changes))

    def test_all_wheels_agree(self, cut):
        way = cut.look(**rolled(0.52)).way

        assert way == DarkWay(
            *(way.low_m, way.low_m, True, "6 driven wheels agree on it", "", self.angles(cut))
        )

    def test_no_wheel_was_driven(self, drive):
        driver = drive(IDLE, states=BOTH_CLAMPED)
        driver.signals |= rolled(0.5)
        driver.run(1.0)
        still = CutOff(driver)
        rolled_m = 1.1 * still.robot.sight.dark.agree_m
        shown = ", ".join([f"{rolled_m * 1000:.0f}"] * 6)
        moved = f"no wheel was driven, but wheels have rolled {shown} mm"

        assert still.look().way == DarkWay(
            0.0, 0.0, True, "no wheel was driven", "", self.angles(still)
        )
        assert still.look(**rolled(0.5 - 0.8 * rolled_m)).way.exact
        assert still.look(**rolled(0.5 + rolled_m)).way == DarkWay(-inf, inf, False, moved, moved)

    def test_a_command_under_way_may_have_rolled_wheels_that_none_drove(self, cut):
        motion = cut.last.robot.motion
        assert motion is not None
        numbers = cut.look(**rolled(0.6)).numbers

        assert dark_way(cut.robot, cut.last, numbers, 0.0).moved == ""
        at_rest = cut.last._replace(robot=cut.last.robot._replace(motion=None))
        assert dark_way(cut.robot, at_rest, numbers, 0.0).moved

    def test_only_wheels_that_were_driven_count(self, cut):
        values = list(cut.last.robot.latest)
        for wheel in cut.robot.wheels[3:]:
            values[wheel.slot] = 0.0
        body = cut.last.robot._replace(values=tuple(values), flight=None)
        cut.last = cut.last._replace(robot=body)
        standing = {f"theta_{n}": FORWARD[n] * 0.5 / RADIUS_M for n in (4, 5, 6)}

        way = cut.look(**rolled(0.52, **standing)).way

        assert way.why == "3 driven wheels agree on it"
        assert way.seen == self.angles(cut, 1, 2, 3)

    @pytest.mark.parametrize(
        ("shown", "why"),
        [(2, "its wheels have rolled 20, 0 mm"), (1, "its wheels do not show it"), (0, None)],
    )
    def test_why_they_do_not_show_it(self, cut, shown, why):
        blind = {f"theta_{n}": nan for n in WHEELS if n > shown}
        stuck = {"theta_2": FORWARD[2] * 0.5 / RADIUS_M} if shown > 1 else {}

        way = cut.look(**rolled(0.52, **(blind | stuck))).way

        assert way == DarkWay(
            -way.high_m, way.high_m, False, why or "its wheels do not show it", "", frozenset()
        )
        assert 0.0 < way.high_m < inf

    def test_a_wheel_that_was_not_known_before_shows_nothing(self, cut):
        angles = list(cut.last.sensing.angles)
        angles[cut.robot.wheels[0].place] = nan
        self.known_before(cut, angles=tuple(angles))

        way = cut.look(**rolled(0.52)).way

        assert way.exact
        assert way.seen == self.angles(cut, 2, 3, 4, 5, 6)

    def test_a_wheel_whose_speed_was_not_known_is_not_levelled(self, cut):
        numbers = list(cut.last.sensing.numbers)
        numbers[cut.robot.wheels[0].speed] = nan
        self.known_before(cut, numbers=tuple(numbers))

        assert cut.look(**rolled(0.52)).way.exact

    def test_wheels_may_roll_a_little_more_than_the_motors_can(self, cut):
        agree_m, most_m = cut.robot.sight.dark.agree_m, cut.robot.sight.dark.top_m_s * 0.4
        begun_m = 0.5

        assert cut.look(**rolled(begun_m + most_m + 0.9 * agree_m)).way.exact
        moved = cut.look(**rolled(begun_m + most_m + 1.2 * agree_m)).way
        shown = ", ".join([f"{(most_m + 1.2 * agree_m) * 1000:.0f}"] * 6)
        why = f"wheels have rolled {shown} mm, but driven they can have 60 mm"
        assert moved == DarkWay(-inf, inf, False, why, why)

    def test_a_counter_that_may_have_begun_again_shows_nothing(self, drive):
        cut = driving(drive, begun_m=0.02)
        agree_m, most_m = cut.robot.sight.dark.agree_m, cut.robot.sight.dark.top_m_s * 0.4

        assert not cut.look(**rolled(most_m + 0.9 * agree_m)).way.seen
        assert cut.look(**rolled(most_m + 1.1 * agree_m)).way.seen

    def test_an_odometry_of_any_place_is_read(self, cut):
        first = replace(cut.robot, odometry=0)
        self.known_before(cut, numbers=(2.0, *cut.last.sensing.numbers[1:]))

        assert odometry_m(first, cut.last.sensing, DarkWay(0.5, 0.5, True, "")) == 2.5
