"""What a sensor can show follows from the profile's motors, end stops and thresholds."""

from __future__ import annotations

from math import inf, radians
from pathlib import Path

import pytest

from pirate_sm.core._engine.sensing.board_spec import PlausibilitySpec, WatchSpec
from pirate_sm.core._loading.robot.loader import LoadedRobot, load_robot

ROOT = Path(__file__).resolve().parents[5]
SIX_WHEELED = ROOT / "hardware_profiles" / "pirate_ii"
NEWT = ROOT / "tests" / "robots" / "newt"


def watch(robot: LoadedRobot, name: str) -> WatchSpec:
    boards = robot.normal.boards.values()
    return next(w for board in boards for w in board.watched.sensors if w.name == name)


def close(value: float) -> object:
    return pytest.approx(value)


def test_a_sprung_joint_turns_within_its_stops_and_no_faster_than_its_motor() -> None:
    robot = load_robot(SIX_WHEELED)
    limits = watch(robot, "gamma_2")
    stop = next(j.end_stop for j in robot.profile.body.joints if j.name == "gamma_2")

    assert (limits.low, limits.high) == (close(-stop - radians(12)), close(stop + radians(12)))
    assert (limits.rate, limits.slack) == (close(0.36), close(radians(6)))
    assert limits.joint
    assert limits.moved == close(radians(20))
    assert limits.least_duty == close(1.5 * 0.15)
    assert limits.full_load == close(0.3)


def test_a_sprung_joint_has_the_narrower_of_a_limit_and_its_motors_speed(loaded_newt) -> None:
    slow = loaded_newt("profile.yaml", ("{overspeed: 2.5", "{overspeed: 0.5"))
    wide, narrow = watch(load_robot(NEWT), "neck"), watch(slow, "neck")

    assert wide.stiffness > 0
    assert narrow.rate == close(0.5 * wide.rate)


def test_what_rests_on_a_joint_is_named_with_it() -> None:
    robot = load_robot(SIX_WHEELED)
    names = robot.normal.vocabulary.numbers

    resting = {names[number] for number in watch(robot, "gamma_1").numbers}
    assert resting == {"gamma_1", "gamma_rate_1", "diameter_front"}
    assert names[watch(robot, "gamma_1").load] == "bend_current_1"
    torque = {names[number] for number in watch(robot, "wheel_current_3").numbers}
    assert torque == {"wheel_current_3", "wheel_torque_3"}


def test_an_accelerometer_has_the_range_that_the_profile_says() -> None:
    robot = load_robot(SIX_WHEELED)
    limits, names = watch(robot, "acc_z"), robot.normal.vocabulary.numbers

    assert (limits.low, limits.high, limits.rate) == (-40.0, 40.0, inf)
    assert {names[at] for at in limits.numbers} == {"acc_z", "acceleration", "roll", "pitch"}


def test_a_wheel_may_slide_and_has_no_range() -> None:
    limits = watch(load_robot(SIX_WHEELED), "theta_4")

    assert (limits.rate, limits.slack, limits.moved) == (close(3 * 6.3), 1.0, 4.0)
    assert (limits.low, limits.high, limits.joint) == (-inf, inf, False)


@pytest.mark.parametrize(
    ("name", "most"),
    [("bend_torque_1", 8 * 1.01), ("bend_current_1", 2 * 0.3), ("wheel_current_1", 2 * 0.54)],
)
def test_torques_and_currents_are_within_some_times_those_at_stall(name: str, most: float) -> None:
    limits = watch(load_robot(SIX_WHEELED), name)

    assert (limits.low, limits.high) == (close(-most), close(most))


def test_another_robot_has_thresholds_of_its_own_and_the_usual_ones_beside() -> None:
    robot = load_robot(NEWT)
    limits = watch(robot, "neck")

    assert (limits.rate, limits.slack) == (close(1.2), close(radians(5)))
    assert limits.moved == close(radians(15))
    assert limits.load == -1, "nobody measures that current"
    assert robot.normal.plausibility == PlausibilitySpec(
        hold_back=2, spikes=5, spikes_within_s=10.0, stuck_after_s=1.0, unloaded=0.4,
        settle_s=1.5, moved_readings=2, repeats_s=0.2,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("folder", "messages", "cycle_s"), [(SIX_WHEELED, 6, 0.016), (NEWT, 9, 0.01)]
)
def test_a_boards_period_is_a_round_of_messages(
    folder: Path, messages: int, cycle_s: float
) -> None:
    """The small robot sends one message per value."""
    assert load_robot(folder).normal.link.period_s == close(messages * cycle_s)
