"""Pause, resume and step, at every point of a mission."""

from __future__ import annotations

import math

import pytest
from driving import BOTH_CLAMPED, FRONT_CLAMPED, IDLE, command

from pirate_sm.core import effects as fx
from pirate_sm.core._model import events as ev

HELD = {"bend_1": -0.7, "bend_2": 0.7, "bend_3": -0.7, "bend_4": 0.7}
ROLLING = {f"theta_{n}": 3.0 if n % 2 else -3.0 for n in range(1, 7)}
MISSION = """
start: a
phases:
  a:
    do: [ClampFront, ClampRear, DriveForward]
    wait: [{when: detector == close, held: 1 s, go: b}, {operator: on, go: b}]
    within: {time: 20 s, go: late}
  b: {do: [Brake, {log: one}, {log: two}], go: e}
ends: {e: {succeed: ok}, late: {fail: late}}
time_limit: 2 min
"""


def test_pause_stops_the_wheels_and_holds_the_clamps(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")

    driver.give(ev.Pause())

    assert driver.nonzero == pytest.approx(HELD)
    assert driver.states["FrontWheelsState"] == "DrivingForward"
    assert driver.messages == ["paused: wheels stopped, deadlines frozen"]


def test_resume_puts_the_same_actuation_in_force_again(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")
    driving = driver.setpoints.values
    driver.give(ev.Pause())
    driver.accept()

    driver.give(ev.Resume(), driver.now + 0.5)

    assert driver.setpoints.values == driving
    assert driver.messages[-1] == "resumed"


def test_deadlines_are_later_by_the_length_of_the_pause(drive):
    driver = drive(MISSION, nominal=True)
    while not driver.of(fx.WaitArmed):
        if driver.in_flight:
            driver.accept()
        driver.tick(driver.wake_at)
    armed = driver.now
    driver.give(ev.Pause(), armed + 5)
    driver.accept()
    assert driver.wake_at == math.inf, "in a pause nothing comes due"
    driver.tick(armed + 1000)
    assert driver.ended is None

    driver.give(ev.Resume(), armed + 1000)
    driver.accept()
    assert driver.wake_at == pytest.approx(armed + 1000 + 15)
    driver.tick(armed + 1014.9)
    assert driver.fired == []
    driver.tick(armed + 1015)
    assert driver.fired == ["within"]


def test_the_time_limit_stands_still_too(drive):
    driver = drive(MISSION, nominal=True)
    driver.accept()
    driver.give(ev.Pause(), 1.0)
    driver.tick(1000.0)
    assert driver.ended is None

    driver.give(ev.Resume(), 1000.0)
    driver.tick(1000.0 + 119 - 1)

    assert not driver.state.mission.ending


def test_what_has_been_held_goes_on_counting(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")
    driver.give(ev.DetectorWord("close", 1e6))
    start = driver.now
    driver.run(start + 0.5, **ROLLING)
    driver.give(ev.Pause())
    driver.accept()
    driver.run(start + 50)

    driver.give(ev.Resume())
    driver.accept()
    driver.run(start + 50.4)
    assert driver.fired == []
    driver.run(start + 50.6)
    assert driver.fired == ["b"]


def test_a_wait_fires_nothing_during_a_pause(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")
    driver.give(ev.Pause())
    driver.accept()

    driver.give(ev.DetectorWord("close", 1e6))
    driver.give(ev.Answer("on"))
    driver.give(ev.Skip())
    driver.run(driver.now + 5)

    assert driver.fired == []
    assert driver.messages[1:] == [
        "no answer is taken while paused",
        "nothing is passed over while paused",
    ]


def test_with_an_array_in_flight_the_pause_waits_for_its_fate(drive):
    driver = drive(MISSION)
    assert driver.in_flight

    driver.give(ev.Pause(), 0.1)
    assert driver.messages == []
    driver.accept()

    assert driver.messages == ["paused: wheels stopped, deadlines frozen"]
    assert driver.states["BendingState"] == "FrontClampedRearRelaxed"
    assert driver.statuses == [("ClampFront", "sent"), ("ClampFront", "accepted")]


def test_a_command_under_way_is_suspended_and_its_timeout_too(drive):
    driver = drive(MISSION)
    driver.accept()
    driver.run(5.0)
    driver.give(ev.Pause())
    driver.run(500.0, every=0.4)
    assert driver.statuses == [("ClampFront", "sent"), ("ClampFront", "accepted")]
    assert driver.state.wake_at_s > driver.now

    driver.give(ev.Resume())
    driver.run(534.9)
    assert len(driver.statuses) == 2
    driver.run(535.1)
    assert driver.statuses[-1] == ("ClampFront", "failed")


def test_nothing_wakes_for_a_suspended_command(drive):
    driver = drive(MISSION, nominal=True)
    driver.accept()
    driver.give(ev.Pause(), 1.0)

    assert driver.state.wake_at_s == math.inf


def test_a_position_loop_stops_and_goes_on(drive):
    driver = drive(
        """
starts_in: {BendingState: FrontClampedRearRelaxed, FrontWheelsState: Fixed}
start: a
phases: {a: {do: [BendBack], go: e}}
ends: {e: {succeed: ok}}
"""
    )
    driver.report_all(0.1)
    driver.accept()
    driver.report_all(0.2)
    driver.accept()
    driver.give(ev.Pause())
    assert driver.nonzero == pytest.approx({"bend_1": -0.7, "bend_2": 0.7})
    driver.accept()
    driver.run(1.0)
    assert driver.nonzero == pytest.approx({"bend_1": -0.7, "bend_2": 0.7})

    driver.give(ev.Resume())
    assert driver.nonzero == pytest.approx(
        {"bend_1": -0.7, "bend_2": 0.7, "bend_3": -0.5, "bend_4": -0.5}
    )
    driver.accept()
    driver.until_done("BendBack")


def test_a_loop_that_stood_at_zero_is_not_lost_by_a_pause(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    driver.signals |= {"gamma_3": math.radians(-30), "gamma_4": math.nan}
    mission = "on_fault: [{fault: sensor.silent, then: continue}]\n" + IDLE
    driver = drive(mission, states=FRONT_CLAMPED)
    driver.signals |= {"gamma_3": math.radians(-30), "gamma_4": math.nan}
    driver.report_all(0.1)
    command(driver, "BendBack")
    driver.accept()
    driver.give(ev.Pause())
    if driver.in_flight:
        driver.accept()

    driver.give(ev.Resume())
    if driver.in_flight:
        driver.accept()

    assert driver.last_status.status == "accepted", "gamma_4 has not come to its angle"


def test_wheels_that_a_pause_has_stopped_are_not_stuck(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")
    driver.run(driver.now + 1, **ROLLING)
    driver.give(ev.Pause())
    driver.accept()

    driver.run(driver.now + 60)
    assert driver.faults == []

    driver.give(ev.Resume())
    driver.accept()
    resumed = driver.now
    driver.run(resumed + 5.9)
    assert driver.faults == []
    driver.run(resumed + 6.3)
    assert driver.faults == [("robot.stuck", "stop")], "now they are driven and do not turn"


def test_in_another_configuration_the_mission_stays_paused(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")
    driver.give(ev.Pause())
    driver.accept()
    command(driver, "Brake")
    driver.until_done("Brake")

    driver.give(ev.Resume())

    assert driver.messages[-1] == "still paused: the configuration has been changed"
    assert driver.nonzero == pytest.approx(HELD)
    command(driver, "DriveForward")
    driver.until_done("DriveForward", 2)
    driver.give(ev.Resume())
    assert driver.messages[-1] == "resumed"


def test_it_stays_paused_while_the_stop_is_in_flight(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")
    driver.give(ev.Pause())

    driver.give(ev.Resume())

    assert driver.messages[-1] == "still paused: setpoints are in flight"


def test_it_stays_paused_while_the_operators_command_is_under_way(drive):
    driver = drive(
        """
start: a
phases:
  a: {do: [{command: ClampFront, timeout: 1 s, on_failure: continue}], wait: [{after: 9 s, go: e}]}
ends: {e: {succeed: ok}}
"""
    )
    driver.accept()
    driver.run(2.0)
    driver.give(ev.Pause())
    command(driver, "ClampFront")
    driver.accept()
    assert driver.states["BendingState"] == "FrontClampedRearRelaxed", "as before the pause"

    driver.give(ev.Resume())

    assert driver.messages[-1] == "still paused: a command is under way"


def test_a_refused_stop_is_no_pause(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")
    driver.give(ev.Pause())

    driver.accept("rejected", "queue full")

    assert driver.faults == [("backend.failed", "stop")]


def test_a_pause_before_anything_was_sent_sends_nothing(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.give(ev.Pause(), 0.1)
    driver.give(ev.Resume(), 0.2)

    assert driver.of(fx.Setpoints) == []
    assert driver.messages[-1] == "resumed"


def test_a_pause_of_a_robot_that_drives_from_the_start_knows_every_value_again(drive):
    driver = drive(
        """
starts_in:
  {BendingState: DoubleClamped, FrontWheelsState: DrivingForward, RearWheelsState: DrivingForward}
start: a
phases: {a: {wait: [{operator: x, go: e}], within: {time: 1 h, go: e}}}
ends: {e: {succeed: ok}}
"""
    )
    driver.show(0.1, phi=0.3)
    driver.give(ev.Pause(), 0.2)
    assert driver.array["rotate"] == pytest.approx(0.3, abs=1e-3)
    driver.accept()

    driver.give(ev.Resume(), 0.4)

    assert driver.array["rotate"] == pytest.approx(0.3, abs=1e-3)
    assert driver.array["wheel_1"] == 1


def test_a_fault_in_a_pause_is_handled_but_the_wheels_stay_stopped_on_resume(drive):
    driver = drive("on_fault: [{fault: robot.stuck, go: b}]\n" + MISSION)
    driver.until_waiting("a")
    driver.give(ev.Pause())
    driver.accept()

    driver.give(ev.FaultReport("robot.stuck", "stuck"), driver.now + 1)
    driver.accept()
    assert driver.phases == ["a"]
    driver.give(ev.Resume())

    assert driver.phases == ["a", "b"]
    assert driver.array["wheel_1"] == 0
    assert driver.statuses[-1] == ("Brake", "sent")


def test_an_abort_in_a_pause_ends_safely(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")
    driver.give(ev.Pause())

    driver.give(ev.Abort("enough"))
    driver.accept()

    assert driver.ended == fx.Ended("interrupted", "enough")
    assert driver.nonzero == pytest.approx(HELD)


def test_resume_without_a_pause_changes_nothing(drive):
    driver = drive(MISSION)
    before = driver.state.mission

    assert driver.give(ev.Resume(), 0.1) == []

    assert driver.state.mission == before


def test_resume_takes_back_a_pause_that_has_not_begun(drive):
    driver = drive(MISSION)
    driver.give(ev.Pause(), 0.1)
    driver.give(ev.Resume(), 0.2)

    driver.accept()

    assert driver.messages == []


def test_step_does_one_step_and_pauses_again(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")
    driver.give(ev.Pause())
    driver.accept()
    driver.give(ev.Step())
    driver.accept()
    driver.give(ev.Answer("on"))
    assert driver.fired == ["b_2"]
    assert driver.messages[-1] == "paused: wheels stopped, deadlines frozen"
    driver.accept()

    driver.give(ev.Step())
    driver.accept()
    driver.until_done("Brake")
    assert driver.messages[-1].startswith("paused")
    assert "one" not in driver.messages

    driver.give(ev.Step())
    assert [m for m in driver.messages if m in ("one", "two")] == ["one"]
    driver.give(ev.Step())
    assert [m for m in driver.messages if m in ("one", "two")] == ["one", "two"]


def test_step_of_a_running_mission_pauses_it(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")

    driver.give(ev.Step())

    assert driver.messages == ["paused: wheels stopped, deadlines frozen"]


# --- what a pause leaves unconfirmed, and taking over a command


def bends_paused(drive):
    """A paused mission whose BendInto has been accepted and is not done."""
    driver = drive(
        "start: a\nphases: {a: {do: [BendInto], go: e}}\n"
        "on_failure: f\nends: {e: {succeed: ok}, f: {fail: '{cause}'}}",
        states={"BendingState": "RearClampedFrontRelaxed", "RearWheelsState": "Fixed"},
    )
    driver.report_all()
    driver.accept()
    driver.report_all(0.2)
    driver.accept() if driver.in_flight else None
    driver.give(ev.Pause())
    driver.accept() if driver.in_flight else None
    return driver


def test_a_pause_leaves_the_states_unconfirmed_whose_wheels_it_stops(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")
    assert driver.unconfirmed == set()

    driver.give(ev.Pause())
    driver.accept()

    assert driver.unconfirmed == {"FrontWheelsState", "RearWheelsState"}
    assert driver.of(fx.StateChange)[-1].unconfirmed == ("FrontWheelsState", "RearWheelsState")


def test_after_a_pause_driving_is_taken_and_confirms_itself(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")
    driver.give(ev.Pause())
    driver.accept()

    command(driver, "DriveForward")

    assert driver.statuses[-1] == ("DriveForward", "sent")
    assert driver.nonzero["wheel_1"] == 1
    driver.until_done("DriveForward", times=2)
    assert driver.unconfirmed == set()


def test_a_resumed_mission_drives_on_and_its_states_are_as_they_were(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")
    driver.give(ev.Pause())
    driver.accept()

    driver.give(ev.Resume(), driver.now + 1)
    driver.accept()

    assert driver.nonzero["wheel_1"] == 1
    assert driver.unconfirmed == set()


def test_braking_stays_unneeded_after_a_pause_of_a_standing_robot(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.give(ev.Pause())

    command(driver, "Brake")

    assert driver.last_status.reason == "unneeded: it is so already"


def test_the_operator_takes_over_a_command_that_the_pause_suspended(drive):
    driver = drive(MISSION)
    driver.until_sent("DriveForward")
    driver.accept()
    driver.give(ev.Pause())
    driver.accept()

    command(driver, "Brake")

    assert driver.statuses[-2:] == [("DriveForward", "failed"), ("Brake", "sent")]
    assert driver.of(fx.CommandStatus)[-2].reason == "the operator took over"
    driver.until_done("Brake")
    assert driver.states["FrontWheelsState"] == "Fixed"
    assert driver.state.mission.paused


def test_a_refused_command_takes_nothing_over(drive):
    driver = bends_paused(drive)

    command(driver, "RelaxRear")

    assert driver.last_status.status == "refused"
    assert driver.state.robot.motion is not None


def test_a_command_that_was_taken_over_has_failed_when_the_mission_goes_on(drive):
    driver = bends_paused(drive)
    command(driver, "BendInto")
    driver.until_done("BendInto")
    driver.accept()
    in_force = driver.state.robot.values

    driver.give(ev.Resume(), driver.now + 1)
    driver.accept() if driver.in_flight else None

    assert "BendInto" in driver.ended.message
    assert driver.ended.message.endswith("failed: the operator took over")
    assert driver.state.robot.values == in_force, "no loop of the suspended command goes on"


def test_an_operators_command_is_not_the_result_of_the_missions_own(drive):
    driver = bends_paused(drive)
    command(driver, "ToggleLighting")
    driver.until_done("ToggleLighting")
    command(driver, "ToggleLighting")
    driver.until_done("ToggleLighting", times=2)

    driver.give(ev.Resume(), driver.now + 1)
    driver.accept() if driver.in_flight else None

    assert driver.ended.outcome == "failed"


def test_the_clock_of_a_suspended_command_stands_still(drive):
    driver = bends_paused(drive)

    assert driver.state.mission.motion_clock(driver.now + 30) == driver.state.mission.paused_s
    command(driver, "BendInto")
    assert driver.state.mission.motion_clock(driver.now + 30) == driver.now + 30
