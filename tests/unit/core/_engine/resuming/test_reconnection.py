"""After its controller was away, the robot is another one until its sensors show the known one."""

from __future__ import annotations

import math

import pytest
from driving import BOTH_CLAMPED, FRONT_CLAMPED, IDLE, Driver, command

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.engine import Engine
from pirate_sm.core._engine.robot.robot_state import confirmed_parts
from pirate_sm.core._model import events as ev
from pirate_sm.core._model.events import EVIDENCE_ENDS

ANGLE = 2 * math.asin((0.120 - 0.048) / 0.09)
HOLDING = {
    "gamma_1": -ANGLE,
    "gamma_2": ANGLE,
    "gamma_3": -ANGLE,
    "gamma_4": ANGLE,
    "bend_torque_1": -0.6,
    "bend_torque_2": 0.6,
    "bend_torque_3": -0.6,
    "bend_torque_4": 0.6,
}
STRAIGHT = dict.fromkeys(HOLDING, 0.0)
SLACK = {f"bend_torque_{n}": 0.0 for n in (1, 2, 3, 4)}
BACK = ev.FaultReport("link.interrupted", "the link is back", 2.0)

MISSION = """
pipe: {diameter: 120 mm, segments: [{straight: 1 m}]}
on_fault: [{fault: [link.interrupted, firmware.reset], HANDLED}, {fault: clamp.lost, then: continue}]
start: wait
phases:
  wait: {do: [BEGIN], wait: [{operator: x, go: shift}], within: {time: 1 h, go: late}}
  shift: {do: [RelaxRear], go: done}
ends: {done: {succeed: The rear is free}, late: {fail: Too late}}
"""  # noqa: E501


def holding(drive, handled: str = "go: shift", begin: str = "ToggleLighting") -> Driver:
    """A robot that holds with both parts, as its sensors show, and waits."""
    text = MISSION.replace("HANDLED", handled).replace("BEGIN", begin)
    driver = drive(text, states=BOTH_CLAMPED)
    driver.signals |= HOLDING
    driver.until_waiting("wait")
    driver.signals |= HOLDING
    driver.run(driver.now + 1.0)
    assert not driver.unconfirmed
    return driver


def look(driver: Driver, lasting_s: float = 3.5, **shown: float) -> None:
    """Arrays are accepted and boards report, for as long as the sensors are compared."""
    driver.signals |= shown
    until_s = driver.now + lasting_s
    while driver.now < until_s and not driver.ended:
        if driver.in_flight:
            driver.accept()
        driver.run(driver.now + 0.1)


def test_belief_in_a_clamp_ends_when_the_controller_was_away(drive):
    driver = holding(drive)

    driver.give(BACK)

    assert {"FrontWheelsState", "RearWheelsState", "BendingState"} <= driver.unconfirmed
    look(driver, 0.3)
    assert ("RelaxRear", "sent") not in driver.statuses, "no sensor has shown a clamp since"


@pytest.mark.parametrize("handled", ["go: shift", "then: continue"])
def test_belief_returns_with_the_sensors_and_the_mission_with_it(drive, handled):
    driver = holding(drive, handled)
    driver.give(BACK)

    look(driver)

    assert [code for code, _ in driver.faults] == ["link.interrupted"]
    if handled == "go: shift":
        assert driver.ended == fx.Ended("succeeded", "The rear is free", "done")
    else:
        assert not driver.unconfirmed
        assert not driver.state.mission.paused


@pytest.mark.parametrize("handled", ["go: shift", "then: continue"])
@pytest.mark.parametrize(
    ("shown", "why"),
    [
        (STRAIGHT, "gamma_1 of the front part shows 0.0 deg, before -106.3 deg"),
        ({"gamma_3": -ANGLE + 0.2}, "gamma_3 of the rear part shows -94.8 deg, before -106.3 deg"),
        ({"acc_y": 9.81, "acc_z": 0.0}, "the robot lies 90 deg otherwise than before"),
        ({"theta_2": 40.0}, "no wheel was driven, but wheels have rolled"),
        (
            SLACK,
            "the front part is declared to hold (BendingState DoubleClamped), but bend",
        ),
    ],
    ids=["straight", "joint", "tilt", "counter", "slack"],
)
def test_another_robot_on_the_same_link_ends_the_run(drive, handled, shown, why):
    driver = holding(drive, handled)
    driver.give(BACK)

    look(driver, 4.0, **shown)

    assert [code for code, _ in driver.faults] == ["link.interrupted", "state.contradicted"]
    assert why in driver.ended.message
    assert driver.ended.outcome == "fault"
    assert ("RelaxRear", "sent") not in driver.statuses
    assert "BendingState" in driver.unconfirmed


def test_another_robot_is_told_when_that_has_lasted_and_not_by_one_frame(drive):
    driver = holding(drive)
    driver.give(BACK)
    back_s = driver.now
    look(driver, 0.3, theta_2=40.0)
    assert [code for code, _ in driver.faults] == ["link.interrupted"]

    look(driver, 0.4)
    assert [code for code, _ in driver.faults] == ["link.interrupted", "state.contradicted"]
    assert driver.now < back_s + 1.0


def test_what_looked_like_another_robot_for_a_moment_is_none(drive):
    driver = holding(drive)
    driver.give(BACK)
    look(driver, 0.3, **MOVED)
    look(driver, 0.2, **HOLDING)
    look(driver, 0.3, **MOVED)
    look(driver, 2.0, **HOLDING)

    assert driver.ended == fx.Ended("succeeded", "The rear is free", "done")


def test_counters_that_restart_at_zero_are_no_other_robot(drive):
    driver = holding(drive)
    look(driver, 1.0, **{f"theta_{n}": 0.0 for n in range(1, 7)})
    driver.give(BACK)
    look(driver, **{f"theta_{n}": 0.0 for n in range(1, 7)})

    assert driver.ended.outcome == "succeeded"


HALF_WOUND = {"bend_torque_1": -0.09}
"""Its other joint is not slack, so that the part may hold; but its apex presses too little to."""


def test_unknown_is_no_agreement_what_lets_go_is_refused(drive):
    driver = holding(drive)
    driver.give(BACK)

    look(driver, 4.0, **HALF_WOUND)

    assert "RelaxRear" in [status.name for status in driver.of(fx.CommandStatus)]
    assert driver.last_status.reason.startswith("impossible: it would let go of the last confirmed")
    assert driver.ended.outcome == "failed"


def test_unknown_is_no_agreement_a_mission_that_continues_ends(drive):
    driver = holding(drive, "then: continue")
    driver.give(BACK)

    look(driver, 4.0, **HALF_WOUND)

    assert driver.ended.message == (
        "state.contradicted: after its controller was away, the sensors do not show that the front "
        "part holds"
    )


def test_wheels_turn_again_only_after_the_clamps_have_been_shown(drive):
    driver = holding(drive, "then: continue", "DriveForward")
    assert driver.nonzero["wheel_1"] == 1

    driver.give(BACK)
    assert "wheel_1" not in driver.nonzero
    look(driver, 0.2)
    assert "wheel_1" not in driver.nonzero
    look(driver, 0.6)

    assert driver.nonzero["wheel_1"] == 1
    assert [code for code, _ in driver.faults] == ["link.interrupted"]
    assert not driver.unconfirmed


def test_a_command_whose_fate_is_unknown_is_given_again_after_the_comparison(drive):
    text = MISSION.replace("HANDLED", "then: continue").replace("BEGIN", "ToggleLighting")
    driver = drive(text, states=BOTH_CLAMPED)
    driver.signals |= HOLDING
    driver.until_sent("ToggleLighting")

    driver.give(BACK)

    assert driver.last_status.status == "failed"
    assert driver.last_status.reason == "interrupted by link.interrupted"
    look(driver)
    lights = [status for name, status in driver.statuses if name == "ToggleLighting"]
    assert lights == ["sent", "failed", "sent", "accepted", "done"]
    assert driver.states["LightingState"] == "On"
    assert not driver.unconfirmed


def test_an_operator_who_has_paused_keeps_the_pause_and_is_refused_meanwhile(drive):
    driver = holding(drive, "then: continue")
    driver.give(ev.Pause())
    driver.give(BACK)

    command(driver, "RelaxRear")
    assert driver.last_status.status == "refused"
    assert "still being compared" in driver.last_status.reason
    look(driver)

    assert driver.state.mission.paused
    assert not driver.unconfirmed


def test_nobody_resumes_before_the_clamps_have_been_shown(drive):
    driver = holding(drive, "then: continue", "DriveForward")
    driver.give(BACK)
    driver.accept()

    driver.give(ev.Resume())

    assert driver.state.mission.paused
    assert "still being compared" in driver.messages[-1]
    assert "wheel_1" not in driver.nonzero


def test_a_pause_that_is_asked_for_during_the_comparison_is_not_lost(drive):
    driver = holding(drive, "then: continue", "DriveForward")
    driver.give(BACK)

    driver.give(ev.Pause())
    look(driver)

    assert driver.state.look is None
    assert driver.state.mission.paused
    assert "wheel_1" not in driver.nonzero


def test_a_robot_that_is_away_again_during_the_comparison_is_compared_with_the_known_one(drive):
    for shown, codes in (({}, []), (STRAIGHT, ["state.contradicted"])):
        driver = holding(drive, "then: continue")
        driver.give(BACK)
        look(driver, 0.2)
        driver.give(BACK)

        look(driver, 0.9, **shown)

        assert [code for code, _ in driver.faults[2:]] == codes
        assert not driver.state.mission.paused or codes


def test_the_times_of_two_absences_count_together(drive):
    driver = holding(drive, "then: continue", "DriveForward")
    ways = {
        f"theta_{n}": math.copysign(1, w.metres_per_rad)
        for n, w in enumerate(driver.robot.wheels, 1)
    }
    driver.show(driver.now + 0.1, **{name: 100.0 * way for name, way in ways.items()})
    driver.give(BACK)
    look(driver, 0.2)
    driver.give(BACK)

    size_m = abs(driver.robot.wheels[0].metres_per_rad)
    on_rad = 1.5 * driver.robot.sight.dark.top_m_s * BACK.away_s / size_m
    look(driver, **{name: (100.0 + on_rad) * way for name, way in ways.items()})

    assert [code for code, _ in driver.faults] == ["link.interrupted"] * 2


def test_a_robot_to_which_nothing_was_sent_is_compared_and_not_paused(drive):
    text = MISSION.replace("HANDLED", "then: continue").replace("BEGIN", "ToggleLighting")
    driver = drive(text, states=BOTH_CLAMPED, declared=True)
    driver.signals |= HOLDING
    driver.run(0.2)

    driver.give(BACK)
    look(driver)

    assert not driver.state.mission.paused
    assert ("ToggleLighting", "done") in driver.statuses


@pytest.mark.parametrize("code", ["link.lost", "link.silent"])
def test_belief_ends_with_a_lost_link_so_that_the_next_run_looks_at_the_robot(drive, code):
    driver = holding(drive)

    driver.give(ev.FaultReport(code, "it has gone"))

    assert {"FrontWheelsState", "RearWheelsState", "BendingState"} <= driver.unconfirmed
    driver.accept()
    body = driver.state.robot.at_rest()
    following, _ = driver.engine.start(driver.now, body=body)
    assert following.look is not None
    assert not confirmed_parts(driver.robot, following.robot)


def test_belief_ends_when_no_board_reports_any_more(drive):
    driver = holding(drive)
    driver.tick(driver.now + 2.0)

    assert [code for code, _ in driver.faults] == ["link.silent"]
    assert "BendingState" in driver.unconfirmed


COUNTING = """
pipe: {diameter: 120 mm, segments: [{straight: 1 m}]}
on_fault: [{fault: firmware.reset, then: continue}]
start: wait
phases:
  wait:
    do: [ToggleLighting]
    wait: [{when: abs(change(theta_1)) > 3 rad, go: done}]
    within: {time: 1 h, go: late}
ends: {done: {succeed: It has turned}, late: {fail: Too late}}
"""


def test_belief_in_a_counter_ends_a_restart_from_zero_is_no_turn(drive):
    driver = drive(COUNTING, states=BOTH_CLAMPED)
    driver.signals |= HOLDING | {"theta_1": 12.0}
    driver.report_all(0.1)
    driver.until_waiting("wait")
    assert driver.state.mission.origin[driver.robot.wheels[0].angle] == pytest.approx(12.0)

    driver.give(BACK._replace(code="firmware.reset"))
    look(driver, theta_1=0.0)

    assert not driver.ended


def test_belief_in_a_word_ends_with_the_connection(drive):
    driver = holding(drive, "then: continue")
    driver.give(ev.DetectorWord("close", 60.0))
    assert driver.state.outside("detector") == "close"

    driver.give(BACK)

    assert driver.state.outside("detector") is None
    assert driver.state.surveyed.felt_s == -math.inf


def test_an_unknown_place_stays_unknown_when_the_controller_restarts(drive):
    driver = holding(drive, "then: continue")
    adrift = frozenset({driver.robot.odometry})
    sensing = driver.state.sensing._replace(adrift=adrift)
    driver.state = driver.state._replace(sensing=sensing)

    driver.give(BACK._replace(code="firmware.reset"))
    look(driver, 1.0)

    assert math.isnan(driver.engine.signals(driver.state)["odometry"])


def test_a_recording_of_before_replays_by_its_own_rules(drive):
    driver = holding(drive)
    driver.engine = Engine(driver.robot, driver.engine.program, nominal=False, alphabet=9)

    driver.give(BACK)

    assert not driver.unconfirmed
    look(driver, 0.3)
    assert driver.ended == fx.Ended("succeeded", "The rear is free", "done")


@pytest.mark.parametrize(("nominal", "alphabet"), [(True, EVIDENCE_ENDS), (False, 9)])
def test_belief_lasts_where_nothing_is_seen_and_in_recordings_of_before(drive, nominal, alphabet):
    driver = holding(drive)
    driver.engine = Engine(driver.robot, driver.engine.program, nominal=nominal, alphabet=alphabet)

    driver.give(ev.FaultReport("link.lost", "it has gone"))

    assert not driver.unconfirmed


def test_nothing_follows_the_end_even_if_the_link_is_silent_at_that_moment(drive):
    driver = drive(IDLE)
    driver.report_all(0.1)

    driver.give(ev.Abort("enough"), at=5.0)

    assert isinstance(driver.effects[-1], fx.Ended)


MOVED = {"gamma_3": -ANGLE + 0.1}
"""A joint is 6 degrees off, which the comparison of a robot at rest does not pass over."""


def test_joints_may_have_moved_while_wheels_were_driven(drive):
    driver = holding(drive, "then: continue", "DriveForward")
    assert driver.state.robot.motion is None
    driver.give(BACK)

    look(driver, **MOVED)

    assert [code for code, _ in driver.faults] == ["link.interrupted"]
    assert not driver.state.mission.paused


def clamping(drive) -> Driver:
    """The front holds, as its sensors show, and the rear is being clamped."""
    text = MISSION.replace("HANDLED", "then: continue").replace("BEGIN", "ClampRear")
    driver = drive(text, states=FRONT_CLAMPED)
    driver.signals |= HOLDING | {"bend_torque_4": 0.0}
    driver.run(0.5)
    driver.until_sent("ClampRear")
    driver.accept()
    driver.run(driver.now + 0.5)
    assert driver.state.robot.motion is not None
    return driver


def test_joints_may_have_moved_while_a_command_was_under_way(drive):
    driver = clamping(drive)
    driver.give(BACK)

    look(driver, gamma_2=ANGLE - 0.1)

    assert [code for code, _ in driver.faults] == ["link.interrupted"]


def test_belief_that_a_command_is_nearly_done_ends_with_the_connection(drive):
    driver = clamping(drive)
    driver.signals |= HOLDING
    driver.run(driver.now + 0.1)
    motion = driver.state.robot.motion
    assert motion is not None
    assert not math.isnan(motion.since_s)
    assert not math.isnan(motion.settled_s)

    driver.give(BACK)

    motion = driver.state.robot.motion
    assert motion is not None
    assert math.isnan(motion.since_s)
    assert math.isnan(motion.settled_s)
    look(driver, 4.0)
    assert ("ClampRear", "done") in driver.statuses


def test_a_mission_that_was_held_continues_to_its_end(drive):
    driver = holding(drive, "then: continue")
    driver.give(BACK)
    look(driver)

    driver.give(ev.Answer("x"))
    look(driver, 1.0)

    assert driver.ended == fx.Ended("succeeded", "The rear is free", "done")


def test_an_operator_who_resumes_during_the_comparison_changes_nothing(drive):
    driver = holding(drive, "then: continue")
    driver.give(BACK)
    driver.give(ev.Resume())
    look(driver)

    assert not driver.state.mission.paused
    driver.give(ev.Answer("x"))
    look(driver, 1.0)
    assert driver.ended == fx.Ended("succeeded", "The rear is free", "done")


def test_a_pause_that_is_pending_stays(drive):
    text = MISSION.replace("HANDLED", "then: continue").replace("BEGIN", "ToggleLighting")
    driver = drive(text, states=BOTH_CLAMPED)
    driver.signals |= HOLDING
    driver.until_sent("ToggleLighting")
    driver.give(ev.Pause())
    assert not driver.state.mission.paused

    driver.give(BACK)
    look(driver)

    assert driver.state.mission.paused


def test_belief_in_a_clamp_ends_in_a_pause_too_and_that_is_reported(drive):
    driver = holding(drive, "then: continue")
    driver.give(ev.Pause())

    told = [each for each in driver.give(BACK) if isinstance(each, fx.StateChange)]

    assert "BendingState" in told[-1].unconfirmed


def test_wheels_that_a_pause_has_stopped_stay_stopped_until_it_ends(drive):
    driver = holding(drive, "then: continue", "DriveForward")
    driver.give(ev.Pause())
    driver.accept()
    wheels = {"FrontWheelsState", "RearWheelsState"}
    assert driver.unconfirmed == wheels

    driver.give(BACK)
    look(driver)

    assert driver.unconfirmed == wheels
    driver.give(ev.Resume())
    assert driver.nonzero["wheel_1"] == 1


def test_an_operators_command_under_way_has_failed(drive):
    driver = holding(drive, "then: continue")
    driver.give(ev.Pause())
    command(driver, "DriveForward")
    driver.accept()
    assert driver.last_status.status == "accepted"

    driver.give(BACK)

    assert driver.last_status.status == "failed"
    assert driver.last_status.reason == "interrupted by link.interrupted"
    assert "wheel_1" not in driver.nonzero


def test_a_run_that_is_ending_does_not_compare_any_more(drive):
    driver = holding(drive)
    driver.give(ev.Abort("enough"))
    assert not driver.ended

    driver.give(BACK)

    assert driver.state.look is None
    driver.accept()
    assert driver.ended.outcome == "interrupted"


def test_wheels_that_a_command_was_to_drive_are_not_confirmed_by_a_new_connection(drive):
    text = MISSION.replace("HANDLED", "then: continue").replace("BEGIN", "DriveForward")
    driver = drive(text, states=BOTH_CLAMPED)
    driver.signals |= HOLDING
    driver.until_sent("DriveForward")
    driver.accept()

    driver.give(BACK)

    waiting_for = {
        driver.robot.regions[mark.which]
        for mark in driver.state.robot.marks
        if mark.command == driver.robot.table.command_index["DriveForward"]
    }
    assert waiting_for == {"FrontWheelsState", "RearWheelsState"}
    look(driver)
    assert ("DriveForward", "done") not in driver.statuses, "no wheel has turned"
