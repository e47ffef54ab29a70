"""Arrays of setpoints: which one is awaited, what becomes of it, and when the link is broken."""

from __future__ import annotations

from dataclasses import replace

import pytest
from driving import Driver, command
from rolling_newt import DRIVE, HELD
from test_loops_of_states import SEEKING, SLOW, driving

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot.robot_state import RobotState
from pirate_sm.core._engine.robot.setpoint_arrays import (
    overtaken_result,
    resend,
    send_if_new,
    stream,
    why_unconfirmed,
)
from pirate_sm.core._model import events as ev


def moment(driver: Driver) -> Moment:
    return Moment(driver.robot, driver.engine.program, False, driver.now)


def test_a_robot_knows_whether_anything_was_ever_sent_to_it(newt):
    driver = newt()
    assert not driver.state.robot.sent

    command(driver, "GoAhead")

    assert driver.state.robot.sent


def test_what_brings_nothing_new_leaves_the_very_same_state(newt):
    driver = driving(newt(DRIVE))
    now, robot = moment(driver), driver.state.robot

    assert send_if_new(now, robot, robot.motion, robot.latest, robot.loops) is robot
    assert now.effects == []


def test_loops_that_end_without_another_duty_end(newt):
    driver = driving(newt(DRIVE))
    now, robot = moment(driver), driver.state.robot

    after = send_if_new(now, robot, robot.motion, robot.latest, ())

    assert after == robot._replace(loops=())
    assert now.effects == []


def test_a_command_that_ends_without_another_array_ends(newt):
    driver = newt(DRIVE)
    driver.accept()
    now, robot = moment(driver), driver.state.robot
    assert robot.motion is not None

    assert send_if_new(now, robot, None, robot.latest, robot.loops) == robot._replace(motion=None)
    assert now.effects == []


def seeking(driver: Driver) -> Driver:
    """The tracks are kept at a speed while a position loop clamps the nose."""
    driver = driving(driver)
    driver.give(ev.Answer("clamp"))
    driver.accept()
    driver.run(driver.now + 0.1, **SLOW)
    assert driver.array["fold_neck"] == pytest.approx(-0.5)
    return driver


def clamping_newt(newt) -> Driver:
    return newt(DRIVE, *SEEKING, states=HELD | {"Grip": "TailHeld"})


@pytest.mark.parametrize("self_locking", [True, False])
def test_the_safe_array_ends_the_current_of_a_position_loop(newt, self_locking):
    engine = clamping_newt(newt).engine
    slots = [
        replace(each, self_locking=self_locking) if each.name == "fold_neck" else each
        for each in engine.robot.slots
    ]
    driver = seeking(Driver(replace(engine.robot, slots=tuple(slots)), engine.program))
    driver.accept()

    driver.give(ev.Abort("enough"))

    assert driver.array["fold_neck"] == 0


def test_while_a_position_loop_runs_every_array_is_of_its_command_and_awaited(newt):
    driver = seeking(clamping_newt(newt))

    for _ in range(4):
        assert driver.state.robot.awaited.purpose == "loop"
        driver.accept()
        driver.run(driver.now + 0.1, **SLOW)
    driver.accept()
    now, robot = moment(driver), driver.state.robot
    changed = robot._replace(values=(0.0,) * len(robot.values))
    assert stream(now, changed, driver.state.sensing) is changed
    without = changed._replace(loops=tuple(set(robot.loops) - set(robot.seekers)))
    assert stream(now, without, driver.state.sensing).flight.purpose == "stream"


def test_the_late_result_of_a_command_that_the_safe_array_has_overtaken_changes_nothing(newt):
    driver = newt()
    driver.report_all(0.1)
    command(driver, "GoAhead")
    gate = driver.setpoints
    driver.give(ev.Abort("enough"))
    assert driver.setpoints != gate
    before = driver.state.robot

    driver.give(ev.SubmitResult(gate.setpoint_id, "accepted"))

    assert before.overtaken == ()
    assert driver.state.robot.values == before.values
    assert driver.states["Crawl"] == "Resting"


def test_a_command_is_given_up_after_its_array_was_repeated_as_often_as_the_link_allows(newt):
    driver = newt()
    driver.report_all(0.1)
    command(driver, "GoAhead")
    array = driver.setpoints

    while not driver.faults:
        driver.accept("unknown")
        if not driver.faults:
            driver.tick(driver.wake_at)

    limit = driver.robot.link.resend_limit
    assert driver.faults[0] == ("link.no_echo", "stop")
    assert driver.of(fx.Setpoints).count(array) == 1 + limit


def test_an_array_is_repeated_when_that_is_due_and_not_before(newt):
    driver = newt()
    driver.report_all(0.1)
    command(driver, "GoAhead")
    driver.accept("unknown")
    due_s = driver.state.robot.flight.resend_at_s
    sent = len(driver.of(fx.Setpoints))

    driver.tick(due_s - 0.01)
    assert len(driver.of(fx.Setpoints)) == sent
    driver.tick(due_s)
    assert len(driver.of(fx.Setpoints)) == sent + 1
    driver.tick(due_s + 0.05)
    assert len(driver.of(fx.Setpoints)) == sent + 1, "its result is awaited"


def test_where_no_array_is_in_flight_none_is_repeated(newt):
    driver = newt()
    now = moment(driver)

    assert resend(now, driver.state.robot, driver.state.sensing) is driver.state.robot
    assert now.effects == []


def streaming(newt) -> Driver:
    """Loops whose arrays nobody confirms; the last one is in flight, others are overtaken."""
    driver = driving(newt(DRIVE))
    driver.run(driver.now + 0.3, **SLOW)
    assert driver.state.robot.flight.purpose == "stream"
    return driver


def test_an_accepted_array_of_a_stream_shows_that_the_link_is_alive_since_now(newt):
    driver = streaming(newt)
    robot = driver.state.robot
    first, second, *_ = robot.overtaken
    assert robot.flight.since_s == first.since_s < driver.now

    after = overtaken_result(moment(driver), robot, ev.SubmitResult(second.setpoint_id, "accepted"))

    assert after.flight.since_s == driver.now
    assert after.seeking == second.seeking
    accepted = ev.SubmitResult(second.setpoint_id, "accepted")
    landed = robot._replace(flight=None)
    assert overtaken_result(moment(driver), landed, accepted).values == second.values
    refused = ev.SubmitResult(second.setpoint_id, "rejected", "not now")
    assert overtaken_result(moment(driver), robot, refused).flight.since_s == first.since_s


def test_the_result_of_an_array_that_nobody_has_sent_changes_nothing(newt):
    driver = streaming(newt)

    found = overtaken_result(moment(driver), driver.state.robot, ev.SubmitResult(99, "accepted"))

    assert found is driver.state.robot


def test_only_its_own_results_make_an_awaited_array_unconfirmed(newt):
    driver = newt()
    driver.report_all(0.1)
    command(driver, "GoAhead")
    link, robot = driver.robot.link, driver.state.robot
    often = robot._replace(flight=robot.flight._replace(tries=link.resend_limit + 1))

    def why(robot: RobotState, number: int) -> str:
        return why_unconfirmed(link, robot, ev.SubmitResult(number, "unknown"), driver.now)

    assert "not confirmed" in why(often, robot.flight.setpoint_id)
    assert why(often, 99) == ""
    assert why(robot, robot.flight.setpoint_id) == ""
    assert why(robot._replace(flight=None), 99) == ""


@pytest.mark.parametrize("which", ["newest", "overtaken", "of nobody"])
def test_a_stream_may_stay_unconfirmed_for_as_long_as_a_board_may_be_silent(newt, which):
    driver = streaming(newt)
    robot, link = driver.state.robot, driver.robot.link
    number = {
        "newest": robot.flight.setpoint_id,
        "overtaken": robot.overtaken[0].setpoint_id,
        "of nobody": 99,
    }[which]
    due_s = robot.flight.since_s + link.silent_after_s

    def why(status: ev.SubmitStatus, now_s: float) -> str:
        return why_unconfirmed(link, robot, ev.SubmitResult(number, status), now_s)

    assert why("unknown", due_s - 0.01) == ""
    assert why("accepted", due_s) == ""
    found = why("unknown", due_s)
    assert found.startswith("the setpoints of loops were not confirmed") == (which != "of nobody")
