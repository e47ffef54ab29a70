"""What is sent for each state, as section 4 of the decisions has it, in both polarities."""

from __future__ import annotations

import math

import pytest
from driving import (
    BOTH_CLAMPED,
    DRIVING_FORWARD,
    FRONT_CLAMPED,
    IDLE,
    REAR_CLAMPED,
    changed_newt,
    command,
)

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.robot.robot_state import RESTORING
from pirate_sm.core._model import events as ev

CLAMP = {"bend_1": -0.7, "bend_2": 0.7}
HOLD = {"bend_3": -0.7, "bend_4": 0.7}
FRONT_AHEAD = {"wheel_1": 1, "wheel_2": -1, "wheel_3": 1}
REAR_AHEAD = {"wheel_4": -1, "wheel_5": 1, "wheel_6": -1}
NOT_MIRRORED = {"rotate", "led_front", "led_rear"}


REACHED = "done: {kind: reached}"


def turned(values: dict[str, float]) -> dict[str, float]:
    return {name: -value for name, value in values.items()}


def near(values: dict[str, float]) -> object:
    return pytest.approx({name: float(value) for name, value in values.items()})


@pytest.mark.parametrize("polarity", ["normal", "mirrored"])
@pytest.mark.parametrize(
    ("states", "name", "sent"),
    [
        ({}, "ClampFront", CLAMP),
        ({}, "ClampRear", HOLD),
        (FRONT_CLAMPED, "ClampRear", CLAMP | HOLD),
        (BOTH_CLAMPED, "RelaxFront", HOLD),
        (BOTH_CLAMPED, "RelaxRear", CLAMP),
        (BOTH_CLAMPED, "DriveForward", CLAMP | HOLD | FRONT_AHEAD | REAR_AHEAD),
        (BOTH_CLAMPED, "DriveBackward", CLAMP | HOLD | turned(FRONT_AHEAD) | turned(REAR_AHEAD)),
        (REAR_CLAMPED, "DriveForward", HOLD | REAR_AHEAD),
        (FRONT_CLAMPED, "DriveForward", CLAMP | FRONT_AHEAD),
        (DRIVING_FORWARD, "Brake", CLAMP | HOLD),
        (DRIVING_FORWARD, "DriveBackward", CLAMP | HOLD | turned(FRONT_AHEAD | REAR_AHEAD)),
        ({}, "AlignLeft", {"rotate": -math.pi / 2}),
        ({}, "AlignRight", {"rotate": math.pi / 2}),
        ({"RotationState": "AlignedLeft"}, "AlignStraight", {}),
        ({}, "ToggleLighting", {"led_front": 1, "led_rear": 1}),
        ({"LightingState": "On"}, "ToggleLighting", {}),
    ],
)
def test_the_first_array_of_a_command_puts_its_states_in_force(drive, states, name, sent, polarity):
    driver = drive(f"polarity: {polarity}\n{IDLE}", states=states)

    command(driver, name)

    sign = -1 if polarity == "mirrored" else 1
    expected = {
        slot: value if slot in NOT_MIRRORED else sign * value for slot, value in sent.items()
    }
    assert driver.nonzero == near(expected)
    assert driver.setpoints.setpoint_id == 1
    assert len(driver.array) == 18


def bending(driver, joints: dict[str, float]) -> dict[str, float]:
    """The array after the joints have been seen at these angles."""
    driver.signals |= joints
    driver.report_all(driver.now + 0.1)
    while driver.in_flight:
        driver.accept()
    return driver.nonzero


@pytest.mark.parametrize(("polarity", "sign"), [("normal", 1), ("mirrored", -1)])
def test_bending_into_goes_to_its_angles_then_pushes(drive, polarity, sign):
    driver = drive(f"polarity: {polarity}\n{IDLE}", states=REAR_CLAMPED)
    goal = sign * math.radians(-45)
    hold = {name: sign * value for name, value in HOLD.items()}
    driver.show(0.1, gamma_1=0.0, gamma_2=0.0)

    command(driver, "BendInto")
    assert driver.nonzero == near(hold | {"bend_1": sign * -0.5, "bend_2": sign * -0.5})
    driver.accept()
    assert driver.states["BendingState"] == "RearClampedFrontBending"

    one_there = bending(driver, {"gamma_1": goal, "gamma_2": goal / 2})
    assert one_there == near(hold | {"bend_2": sign * -0.5})
    assert ("BendInto", "done") not in driver.statuses

    both_there = bending(driver, {"gamma_1": goal, "gamma_2": goal})
    assert both_there == near(hold | {"bend_2": sign * -0.35})
    assert driver.last_status.status == "done", driver.last_status
    assert driver.last_status.reason == "every joint has come to its angle"
    assert driver.unconfirmed == set()


def test_bending_back_ends_with_the_loops_at_zero(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    driver.show(0.1, gamma_3=0.0, gamma_4=0.0)
    command(driver, "BendBack")
    driver.accept()

    there = bending(driver, {"gamma_3": math.radians(-30), "gamma_4": math.radians(-30)})

    assert there == near(CLAMP)
    assert driver.last_status.status == "done", driver.last_status


def test_a_loop_drives_in_proportion_with_a_least_and_a_largest_duty(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    driver.show(0.1, gamma_3=0.0, gamma_4=0.0)
    command(driver, "BendBack")
    driver.accept()
    goal = math.radians(-30)

    def duty_at(error_deg: float) -> float:
        return bending(driver, {"gamma_3": goal - math.radians(error_deg)}).get("bend_3", 0.0)

    for _ in range(40):  # so many reports without a gap are a line that loses nothing
        assert duty_at(-30) == pytest.approx(-0.5)
    assert duty_at(-5) == pytest.approx(-4 * math.radians(5), abs=0.001)
    assert duty_at(+5) == pytest.approx(4 * math.radians(5), abs=0.001)
    assert duty_at(-3.1) == pytest.approx(-4 * math.radians(3.1), abs=0.001)
    assert duty_at(-2.9) == 0
    assert duty_at(math.nan) == 0, "a blind loop does not drive"


def test_a_loop_slows_down_earlier_where_reports_are_lost(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    driver.loss = 0.5
    driver.show(0.1, gamma_3=0.0, gamma_4=0.0)
    command(driver, "BendBack")
    driver.accept()
    goal = math.radians(-30)

    def bend_3(error_deg: float) -> float:
        driver.signals["gamma_3"] = goal - math.radians(error_deg)
        driver.report_all(driver.now + 0.2)
        while driver.in_flight:
            driver.accept()
        return driver.nonzero.get("bend_3", 0.0)

    assert bend_3(-30) == pytest.approx(-0.5), "far away it is as fast as ever"
    assert bend_3(-5) == pytest.approx(-2 * math.radians(5), abs=0.01), "half its gain"
    assert bend_3(-3.1) == pytest.approx(-0.15), "and never below what turns the worm"
    assert bend_3(-2.9) == 0


def test_a_joint_that_the_wall_stops_counts_when_it_bears_the_push(drive):
    driver = drive(IDLE, states=REAR_CLAMPED)
    driver.show(0.1, gamma_1=0.0, gamma_2=0.0)
    command(driver, "BendInto")
    driver.accept()
    bending(driver, {"gamma_1": math.radians(-45), "gamma_2": math.radians(-20)})

    stuck = {"gamma_1": math.radians(-45), "gamma_2": math.radians(-20)}
    for _ in range(10):
        bending(driver, stuck)  # it stands still, but its spring is not wound
    assert ("BendInto", "done") not in driver.statuses
    for _ in range(5):
        bending(driver, stuck | {"bend_torque_2": -0.5})  # 0.7 * 50 % of 1.01 Nm are enough
    assert driver.last_status.reason == "gamma_2 stopped by the wall, standing still under torque"


def test_the_other_way_round_is_no_push(drive):
    driver = drive(IDLE, states=REAR_CLAMPED)
    driver.show(0.1, gamma_1=0.0, gamma_2=0.0)
    command(driver, "BendInto")
    driver.accept()
    for _ in range(10):
        stuck = {"gamma_1": math.radians(-45), "gamma_2": math.radians(-20)}
        bending(driver, stuck | {"bend_torque_2": 0.9})

    assert ("BendInto", "done") not in driver.statuses


def test_nothing_is_sent_while_an_array_of_a_loop_is_in_flight(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    driver.show(0.1, gamma_3=0.0, gamma_4=0.0)
    command(driver, "BendBack")
    driver.accept()
    driver.show(0.2, gamma_3=math.radians(-26))
    assert driver.in_flight
    before = len(driver.of(fx.Setpoints))

    driver.show(0.3, gamma_3=math.radians(-27))
    assert len(driver.of(fx.Setpoints)) == before

    driver.accept()
    assert len(driver.of(fx.Setpoints)) == before + 1


def test_unaligned_keeps_the_angle_that_is_measured(drive):
    driver = drive(IDLE)
    driver.show(0.1, phi=0.4)

    command(driver, "ClampFront")

    assert driver.array["rotate"] == pytest.approx(0.4, abs=1e-3)


def test_an_angle_to_keep_that_nobody_has_measured_is_zero(drive):
    driver = drive(IDLE)

    command(driver, "ClampFront")

    assert driver.array["rotate"] == 0


def test_an_angle_once_sent_is_kept_even_when_the_sensor_says_otherwise(drive):
    driver = drive(IDLE)
    driver.show(0.1, phi=0.4)
    command(driver, "ClampFront")
    driver.accept()
    driver.show(0.2, phi=0.9)
    driver.run(45.0)

    command(driver, "ClampFront")

    assert driver.array["rotate"] == pytest.approx(0.4, abs=1e-3)


def test_a_duty_is_a_whole_number_of_steps_of_the_wire(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    driver.show(0.1, gamma_3=math.radians(-25.123), gamma_4=0.0)

    command(driver, "BendBack")

    steps = driver.array["bend_3"] / 0.001
    assert steps == pytest.approx(round(steps), abs=1e-9)
    assert steps == pytest.approx(-4 * math.radians(30 - 25.123) / 0.001, abs=0.5)


def test_a_later_stage_may_have_angles_of_its_own(drive, tmp_path):
    staged = """
      - {fold_neck: 20 deg, fold_hip: 0 %}
      - {fold_neck: 40 deg, fold_hip: 0 %}
      - {fold_neck: 0 %, fold_hip: 10 %}"""
    robot = changed_newt(
        tmp_path,
        (" {fold_neck: 0 deg, fold_hip: 0 deg}", staged),
        ("done: {kind: below, signals: [neck, hip], limit: 6 deg, for: 0.2 s}", REACHED),
    )
    driver = drive(IDLE, robot, states={"Grip": "NoseHeld"})
    driver.show(0.1, neck=0.0)
    command(driver, "Home")
    driver.accept()

    assert bending(driver, {"neck": math.radians(20)}) == near({"fold_neck": 0.5})
    assert driver.last_status.status == "accepted"
    assert bending(driver, {"neck": math.radians(40)}) == near({"fold_hip": 0.1})
    assert driver.last_status.status == "done", driver.last_status


def test_reset_lets_go_of_everything_by_angle(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED | {"LightingState": "On"})
    driver.show(0.1, gamma_1=-1.0, gamma_2=1.0, gamma_3=-1.0, gamma_4=1.0)

    command(driver, "Reset")

    assert driver.nonzero == near({"bend_1": 0.5, "bend_2": -0.5, "bend_3": 0.5, "bend_4": -0.5})


def test_a_board_of_another_robot_says_nothing(drive):
    driver = drive(IDLE)
    before = driver.engine.signals(driver.state)

    driver.give(ev.SensorFrame(99, (1.0,) * 9), 0.1)

    assert repr(driver.engine.signals(driver.state)) == repr(before)


def test_the_next_command_waits_for_the_last_array_of_the_one_before(drive):
    driver = drive(
        "start: a\nphases: {a: {do: [BendBack, ToggleLighting], go: e}}\n"
        "ends: {e: {succeed: ok}}\n",
        states=FRONT_CLAMPED,
    )
    driver.show(0.1, gamma_3=0.0, gamma_4=0.0)
    driver.accept()
    driver.signals |= {"gamma_3": math.radians(-30), "gamma_4": math.radians(-30)}
    driver.report_all(0.2)
    while ("BendBack", "done") not in driver.statuses:
        driver.accept()
        driver.report_all(driver.now + 0.1)

    assert driver.statuses[-1] == ("BendBack", "done")
    driver.accept()
    assert driver.statuses[-1] == ("ToggleLighting", "sent")


def test_belief_that_a_wall_stopped_a_joint_ends_where_the_joint_has_not_moved(drive):
    """Braked wheels hold the rear where it is: it is pushed harder, then the bend has failed."""
    driver = drive(IDLE, states=FRONT_CLAMPED)
    held = {"gamma_3": math.radians(-120), "gamma_4": math.radians(107)}
    driver.show(0.1, **held, bend_torque_3=-0.5, bend_torque_4=0.7)
    command(driver, "BendBack")
    driver.accept()
    assert driver.nonzero["bend_3"] == pytest.approx(0.5)

    wound = {"gamma_4": math.radians(103), "bend_torque_3": 0.4, "bend_torque_4": -0.4}
    for _ in range(5):
        bending(driver, held | wound)
    assert driver.nonzero["bend_3"] == pytest.approx(1.0), "once, with all that the motor gives"
    assert driver.nonzero["bend_4"] == pytest.approx(-1.0)
    assert driver.last_status.status == "accepted"

    for _ in range(30):
        bending(driver, held | wound)
    assert driver.last_status.status == "failed"
    assert driver.last_status.reason.startswith("not moved, though pushed: gamma_3, gamma_4;")


def test_a_bend_that_a_resumed_run_restores_finds_its_joints_moved(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    bent = {"gamma_3": math.radians(-100), "gamma_4": math.radians(-20)}
    driver.show(0.1, **bent, bend_torque_3=0.4, bend_torque_4=-0.4)
    command(driver, "BendBack")
    motion = driver.state.robot.motion._replace(place=RESTORING)
    driver.state = driver.state._replace(robot=driver.state.robot._replace(motion=motion))
    driver.accept()
    for _ in range(30):
        bending(driver, bent)
    assert driver.last_status.status == "done", driver.last_status


def test_a_joint_that_gives_way_to_a_harder_push_is_bent(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    held = {"gamma_3": math.radians(-120), "gamma_4": math.radians(107)}
    driver.show(0.1, **held, bend_torque_3=-0.5, bend_torque_4=0.7)
    command(driver, "BendBack")
    driver.accept()
    for _ in range(5):
        bending(driver, held | {"bend_torque_3": 0.4, "bend_torque_4": -0.4})
    assert driver.nonzero["bend_3"] == pytest.approx(1.0)

    bent = {"gamma_3": math.radians(-115), "gamma_4": math.radians(-29)}
    for _ in range(30):
        bending(driver, bent | {"bend_torque_3": 0.9})
    assert driver.last_status.reason == "gamma_3 stopped by the wall, standing still under torque"


AT_THE_WALL = {"gamma_3": math.radians(-80), "gamma_4": math.radians(60)}
WEAKLY = {"bend_torque_3": 0.05, "bend_torque_4": -0.05}
PUSHED = {"bend_torque_3": 0.9, "bend_torque_4": -0.9}


def begin_at(driver, **joints: float) -> None:
    driver.show(0.1, **joints, bend_torque_3=-0.5, bend_torque_4=0.7)
    command(driver, "BendBack")
    driver.accept()


def fail_by_time(driver) -> None:
    """Let the bend bear too little until its time is over."""
    while driver.last_status.status == "accepted":
        bending(driver, AT_THE_WALL | WEAKLY)
    assert driver.last_status.status == "failed"


def test_belief_that_a_repeated_bend_has_moved_counts_from_its_first_try(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    begin_at(driver, gamma_3=math.radians(-120), gamma_4=math.radians(107))
    fail_by_time(driver)
    command(driver, "BendBack")
    for _ in range(30):
        bending(driver, AT_THE_WALL | PUSHED)
    assert driver.last_status.status == "done", driver.last_status


def test_belief_that_another_bend_has_moved_counts_from_its_own_beginning(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    begin_at(driver, gamma_3=math.radians(-120), gamma_4=math.radians(107))
    fail_by_time(driver)
    command(driver, "ToggleLighting")
    driver.accept()
    command(driver, "BendBack")
    for _ in range(30):
        bending(driver, AT_THE_WALL | PUSHED)
    assert driver.last_status.reason.startswith("not moved, though pushed: gamma_3, gamma_4;")


def test_a_joint_whose_board_was_silent_at_first_has_moved_from_its_first_known_angle(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    command(driver, "BendBack")
    driver.accept()
    bending(driver, {"gamma_3": math.radians(-120), "gamma_4": math.radians(107)} | WEAKLY)
    for _ in range(30):
        bending(driver, AT_THE_WALL | PUSHED)
    assert driver.last_status.status == "done", driver.last_status
