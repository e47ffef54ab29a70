"""A command's life: sent, accepted, done or failed; and what becomes of its array."""

from __future__ import annotations

import math

import pytest
from driving import BOTH_CLAMPED, DRIVING_FORWARD, FRONT_CLAMPED, IDLE, NEWT, REAR_CLAMPED, command

from pirate_sm.core import effects as fx
from pirate_sm.core._model import events as ev

CLAMPING = """\
start: hold
phases:
  hold: {do: [{command: ClampFront, timeout: 4 s, retry: 1}], go: held}
ends: {held: {succeed: Held}}
"""


def test_the_states_move_when_the_array_is_accepted_and_not_before(drive):
    driver = drive(IDLE)
    command(driver, "ClampFront")
    driver.report_all(0.5)
    assert driver.states["BendingState"] == "Unclamped"

    driver.accept()

    assert driver.states["BendingState"] == "FrontClampedRearRelaxed"
    change = driver.of(fx.StateChange)[-1]
    assert change.states == ("Fixed", "Free", "FrontClampedRearRelaxed", "Unaligned", "Off")
    assert change.unconfirmed == ("FrontWheelsState", "BendingState")


@pytest.mark.parametrize("status", ["rejected", "superseded"])
def test_an_array_that_is_not_accepted_moves_nothing(drive, status):
    driver = drive(IDLE)
    command(driver, "ClampFront")

    driver.accept(status, "the bus is gone")

    assert driver.states["BendingState"] == "Unclamped"
    assert driver.last_status.status == "failed"
    assert driver.last_status.reason == f"setpoints {status}: the bus is gone"
    assert driver.unconfirmed == set()
    assert driver.ended is None


def test_a_rejected_reset_lets_go_of_nothing(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.show(0.1, gamma_1=-1.0, gamma_2=1.0, gamma_3=-1.0, gamma_4=1.0)
    command(driver, "Reset")

    driver.accept("rejected")

    assert len(driver.of(fx.Setpoints)) == 1, "what is in force is left as it is"
    assert driver.engine.safe_values(driver.state)[4] == pytest.approx(-0.7)


def test_a_result_for_another_array_means_nothing(drive):
    driver = drive(IDLE)
    command(driver, "ClampFront")

    driver.give(ev.SubmitResult(7, "accepted"))
    assert driver.states["BendingState"] == "Unclamped"
    driver.accept()
    driver.give(ev.SubmitResult(1, "rejected"))
    assert driver.states["BendingState"] == "FrontClampedRearRelaxed"


def test_after_unknown_the_same_array_is_sent_again_when_that_is_due(drive):
    driver = drive(IDLE)
    command(driver, "ClampFront")
    first = driver.setpoints

    driver.accept("unknown")
    assert driver.wake_at == pytest.approx(0.2)
    driver.tick(0.19)
    assert driver.of(fx.Setpoints) == [first]
    driver.tick(0.2)
    assert driver.of(fx.Setpoints) == [first, first]

    driver.accept()
    assert driver.states["BendingState"] == "FrontClampedRearRelaxed"


def test_the_wake_for_sending_again_is_told_at_once_where_nothing_else_wakes(drive):
    driver = drive(IDLE, nominal=True)
    command(driver, "ClampFront")

    effects = driver.accept("unknown")

    assert fx.WakeAt(0.2) in effects


def test_an_array_that_is_never_confirmed_is_a_lost_link(drive):
    driver = drive(IDLE, nominal=True)
    command(driver, "ClampFront")
    for _ in range(5):
        driver.accept("unknown")
        driver.tick(driver.wake_at)
    assert driver.faults == []
    assert len(driver.of(fx.Setpoints)) == 6

    driver.accept("unknown")

    assert driver.faults == [("link.no_echo", "stop")]
    assert driver.setpoints.setpoint_id == 2, "the safe stop may follow"
    driver.accept()
    assert driver.ended.outcome == "fault"


def test_a_command_neither_ends_nor_goes_on_while_its_loop_is_unanswered(drive):
    driver = drive(IDLE, states=REAR_CLAMPED)
    driver.show(0.1, gamma_1=0.0, gamma_2=0.0)
    command(driver, "BendInto")
    driver.accept()
    driver.show(0.2, gamma_1=math.radians(-42.5), gamma_2=0.0)
    driver.accept("unknown")
    sent = driver.setpoints
    goal = math.radians(-45)

    driver.show(0.3, gamma_1=goal, gamma_2=goal)
    assert driver.setpoints == sent
    driver.tick(0.4)
    assert driver.setpoints == sent, "the same array again"
    driver.accept()
    assert driver.last_status.status == "done"
    assert driver.setpoints != sent, "only now the push"


def test_a_command_does_not_time_out_either_while_its_loop_is_unanswered(drive):
    driver = drive(IDLE, states=REAR_CLAMPED)
    driver.report_all(0.1)
    command(driver, "BendInto")
    driver.accept()
    while driver.now < 39.9:
        driver.report_all(driver.now + 0.1)
        if driver.in_flight:
            driver.accept()
    driver.signals["gamma_1"] = math.radians(-42.5)
    driver.report_all(40.0)
    assert driver.in_flight

    driver.report_all(40.3)
    assert driver.last_status.status == "accepted"
    driver.accept()
    assert driver.last_status.status == "failed"


def test_what_was_so_before_acceptance_does_not_count(drive):
    driver = drive(IDLE)
    driver.signals |= {"bend_torque_1": -0.6, "bend_torque_2": 0.6}
    command(driver, "ClampFront")
    for at in (0.1, 0.2, 0.3, 0.4):
        driver.report_all(at)

    driver.accept()
    driver.report_all(0.5)
    assert driver.last_status.status == "accepted"
    driver.report_all(0.6)
    assert driver.last_status.status == "done"


def test_a_timeout_counts_from_acceptance(drive):
    driver = drive(CLAMPING)
    driver.run(3.0)
    driver.accept()

    driver.run(6.9)
    assert driver.statuses == [("ClampFront", "sent"), ("ClampFront", "accepted")]
    driver.run(7.0)
    assert driver.statuses[2] == ("ClampFront", "failed")


def test_retry_gives_the_same_command_again_and_then_fails(drive):
    driver = drive(CLAMPING)
    driver.accept()
    driver.run(4.0)
    assert driver.statuses[2:] == [("ClampFront", "failed"), ("ClampFront", "sent")]

    driver.accept()
    driver.run(8.0)
    driver.accept()

    assert driver.statuses[-1] == ("ClampFront", "failed")
    assert driver.ended.outcome == "failed"
    assert driver.ended.message.startswith("ClampFront (")
    assert "failed: not done within 4 s because the joints do not" in driver.ended.message


def test_a_retry_that_succeeds_confirms(drive):
    driver = drive(CLAMPING)
    driver.accept()
    driver.run(4.0)

    driver.until_done("ClampFront")
    driver.obey()

    assert driver.ended.end == "held"
    assert driver.unconfirmed == set()


def test_a_timeout_leaves_no_duty_of_a_position_loop(drive):
    mission = """\
starts_in: {BendingState: RearClampedFrontRelaxed, RearWheelsState: Fixed}
start: bend
phases: {bend: {do: [BendInto], go: bent}}
ends: {bent: {succeed: Bent}}
"""
    driver = drive(mission)
    driver.report_all(0.1)
    driver.accept()
    while driver.now < 42 and not driver.ended:
        driver.report_all(driver.now + 0.1)
        if driver.in_flight:
            driver.accept()

    assert driver.ended.outcome == "failed"
    assert driver.nonzero == pytest.approx({"bend_3": -0.7, "bend_4": 0.7})


@pytest.mark.parametrize(
    ("states", "name", "shown", "reason"),
    [
        (
            {},
            "ClampFront",
            {"bend_torque_1": -0.6, "bend_torque_2": 0.6},
            "the joints stand still under torque",
        ),
        (BOTH_CLAMPED, "RelaxRear", {}, "setpoints accepted"),
        ({}, "AlignRight", {"phi": math.radians(88)}, "the angle is at its setpoint"),
        (DRIVING_FORWARD, "Brake", {}, "the wheels stand still"),
        (FRONT_CLAMPED, "Reset", {"gamma_1": 0.1}, "near zero"),
    ],
)
def test_done_says_what_showed_it(drive, states, name, shown, reason):
    driver = drive(IDLE, states=states)
    driver.report_all(0.1)
    command(driver, name)
    driver.accept()
    driver.signals |= shown

    while driver.last_status.status == "accepted" and driver.now < 3:
        driver.report_all(driver.now + 0.1)
        if driver.in_flight:
            driver.accept()

    assert (driver.last_status.status, driver.last_status.reason) == ("done", reason)


@pytest.mark.parametrize(
    ("states", "name", "shown"),
    [
        ({}, "ClampFront", {"bend_torque_1": -0.6, "bend_torque_2": 0.09}),
        ({}, "ClampFront", {"bend_torque_1": -0.6, "bend_torque_2": math.nan}),
        ({}, "AlignRight", {"phi": math.radians(86)}),
        ({}, "AlignRight", {"phi": math.nan}),
        (BOTH_CLAMPED, "DriveForward", {}),
        (FRONT_CLAMPED, "Reset", {"gamma_1": 0.2}),
    ],
)
def test_not_done_while_it_does_not_show(drive, states, name, shown):
    mission = f"on_fault: [{{fault: sensor.silent, then: continue}}]\n{IDLE}"
    driver = drive(mission, states=states)
    driver.report_all(0.1)
    command(driver, name)
    driver.accept()
    driver.signals |= shown

    while driver.last_status.status == "accepted":
        driver.report_all(driver.now + 0.1)
        if driver.in_flight:
            driver.accept()

    assert driver.last_status.status == "failed"


def test_one_wheel_that_turns_is_enough_for_driving(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.report_all(0.1)
    command(driver, "DriveForward")
    driver.accept()

    driver.run(0.5, theta_5=2.0)

    assert driver.statuses[-1] == ("DriveForward", "done")


def braking(drive, **silent: float):
    """Brake has been accepted, and the wheels that can be heard stand still for a second."""
    driver = drive(
        f"on_fault: [{{fault: sensor.silent, then: continue}}]\n{IDLE}", states=DRIVING_FORWARD
    )
    driver.report_all(0.1)
    command(driver, "Brake")
    driver.accept()
    driver.signals |= silent
    driver.run(1.1)
    return driver


def test_braking_is_done_although_a_wheel_cannot_be_heard(drive):
    assert braking(drive, theta_1=math.nan).statuses[-1] == ("Brake", "done")


def test_braking_is_not_done_while_no_wheel_of_a_part_can_be_heard(drive):
    front = {f"theta_{n}": math.nan for n in (1, 2, 3)}

    assert braking(drive, **front).statuses[-1] == ("Brake", "accepted")


@pytest.mark.parametrize(("borne", "status"), [(-0.36, "done"), (0.36, "accepted")])
def test_a_joint_is_stopped_by_a_wall_only_when_it_bears_torque_against_its_push(
    drive, borne, status
):
    driver = drive(IDLE, states=REAR_CLAMPED)
    driver.report_all(0.1)
    command(driver, "BendInto")
    driver.accept()
    stopped = {"gamma_1": -0.3, "gamma_2": -0.3, "bend_torque_1": borne, "bend_torque_2": borne}
    driver.signals |= stopped

    while driver.now < 3 and driver.statuses[-1] == ("BendInto", "accepted"):
        driver.report_all(driver.now + 0.1)
        if driver.in_flight:
            driver.accept()

    assert driver.statuses[-1] == ("BendInto", status)


def test_a_wheel_that_is_not_driven_shows_no_driving(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    driver.report_all(0.1)
    command(driver, "DriveForward")
    driver.accept()

    driver.run(2.0, theta_5=2.0)

    assert driver.statuses[-1] == ("DriveForward", "accepted")


def test_standing_still_must_last(drive):
    driver = drive(IDLE)
    driver.signals |= {"bend_torque_1": -0.6, "bend_torque_2": 0.6}
    driver.report_all(0.1)
    command(driver, "ClampFront")
    driver.accept()

    driver.report_all(0.2)
    driver.report_all(0.3)
    driver.signals["bend_torque_1"] = -0.3
    driver.report_all(0.35)
    driver.signals["bend_torque_1"] = -0.6
    driver.report_all(0.4)
    driver.report_all(0.55)
    assert driver.statuses[-1] == ("ClampFront", "accepted")
    driver.tick(0.6)
    assert driver.statuses[-1] == ("ClampFront", "done")


def test_on_paper_a_command_takes_its_nominal_duration(drive):
    driver = drive(CLAMPING, nominal=True)
    driver.tick(1.0)
    driver.accept()
    assert driver.wake_at == 8.0

    driver.tick(7.9)
    assert driver.last_status.status == "accepted"
    driver.tick(8.0)
    assert driver.last_status.status == "done"


def test_a_robot_of_another_make_does_the_same(drive):
    driver = drive(
        "start: hold\nphases: {hold: {do: [HoldNose, HoldTail, GoAhead], go: held}}\n"
        "ends: {held: {succeed: Held}}\n",
        NEWT,
    )
    driver.until_sent("GoAhead")
    assert driver.states == {"Grip": "BothHeld", "Crawl": "Resting", "Lamp": "Dark"}
    assert driver.nonzero == pytest.approx(
        {
            "fold_neck": -0.5,
            "fold_hip": 0.5,
            "drive_a": 0.8,
            "drive_b": -0.8,
            "drive_c": 0.8,
            "drive_d": -0.8,
        }
    )
