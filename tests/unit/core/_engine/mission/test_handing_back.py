"""Taken over by hand and handed back: a mission goes on at another of its phases."""

from __future__ import annotations

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.robot.robot_state import state_change
from pirate_sm.core._model import events as ev

MISSION = """
start: a
phases:
  a:
    do: [ClampFront, ClampRear, DriveForward]
    wait: [{when: detector == close, go: b}]
    within: {time: 20 s, go: late}
  b: {do: [Brake, {log: one}], go: e}
ends: {e: {succeed: ok}, late: {fail: late}}
"""


def command(driver, name):
    return [each for each in driver.of(fx.CommandStatus) if each.name == name]


def hand_back(driver, phase):
    """The operator, who has looked at the robot as it is."""
    driver.give(ev.GoTo(phase, *state_change(driver.robot, driver.state.robot)))


def paused_while_driving(drive):
    driver = drive(MISSION, nominal=True)
    driver.until_waiting("a")
    driver.give(ev.Pause())
    driver.accept()
    return driver


def test_it_goes_on_at_the_phase(drive):
    driver = paused_while_driving(drive)

    hand_back(driver, "b")

    assert driver.of(fx.PhaseChange)[-1].phase == "b"
    assert not driver.state.mission.paused
    assert command(driver, "Brake")[-1].status == "sent"


def test_it_stays_paused_where_the_robot_is_not_as_it_was_looked_at(drive):
    driver = paused_while_driving(drive)
    before = state_change(driver.robot, driver.state.robot)
    driver.give(ev.OperatorCommand("Brake"))
    driver.accept()

    driver.tick(driver.now + 1)
    driver.give(ev.GoTo("b", *before))

    assert driver.state.mission.paused
    assert "states have changed since they were checked" in driver.messages[-1]


def test_an_unknown_phase_and_a_running_mission_are_reported(drive):
    driver = drive(MISSION, nominal=True)
    driver.until_waiting("a")

    hand_back(driver, "b")
    hand_back(driver, "nowhere")

    assert driver.messages[-2:] == [
        "b does not begin: pause the mission first",
        "nowhere does not begin: the mission has no such phase",
    ]


def test_a_command_that_the_pause_suspended_is_given_up(drive):
    driver = drive(MISSION, nominal=True)
    driver.accept()
    driver.give(ev.Pause())

    hand_back(driver, "a")

    states = [each.status for each in command(driver, "ClampFront")]
    assert states[-2:] == ["failed", "sent"], "the same again is a retry"


def test_an_engine_can_begin_with_the_operator_and_where_another_left_the_robot(drive):
    first = paused_while_driving(drive)

    second = drive(MISSION, nominal=True)
    second.state, effects = second.engine.start(5.0, body=first.state.robot, paused=True)

    assert second.state.robot.configuration == first.state.robot.configuration
    assert second.state.mission.paused
    assert not [each for each in effects if isinstance(each, fx.CommandStatus)]


def test_handing_back_does_not_drop_the_operators_command_under_way(drive):
    driver = paused_while_driving(drive)
    driver.give(ev.OperatorCommand("Brake"))
    driver.accept()

    hand_back(driver, "b")

    assert driver.state.mission.paused
    assert driver.messages[-1] == "b does not begin: a command is under way"
    assert driver.state.robot.motion is not None
    driver.tick(driver.now + 1)
    assert command(driver, "Brake")[-1].status == "done"
