"""Taken over by hand and handed back: a mission goes on at a phase that it could have come to."""

from __future__ import annotations

from dataclasses import replace

from pirate_sm.engine.engine import Engine
from pirate_sm.engine.program import Situation
from pirate_sm.model import effects as fx
from pirate_sm.model import events as ev

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


def enterable(driver, **phases):
    """The driver's mission knows in which confirmed configurations its phases begin."""
    table = driver.robot.table
    entries = {
        phase: frozenset(Situation(table.index_of(tuple(states)), frozenset()) for states in each)
        for phase, each in phases.items()
    }
    program = replace(driver.engine.program, entries=entries)
    driver.engine = Engine(driver.robot, program, nominal=driver.engine.nominal)


def command(driver, name):
    return [each for each in driver.of(fx.CommandStatus) if each.name == name]


def messages(driver) -> list[str]:
    return [log.message for log in driver.of(fx.Log)]


def paused_while_driving(drive):
    driver = drive(MISSION, nominal=True)
    driver.until_waiting("a")
    driver.give(ev.Pause())
    driver.accept()
    return driver


def test_it_goes_on_at_a_phase_that_begins_in_the_states_it_has(drive):
    driver = paused_while_driving(drive)
    enterable(driver, b=[driver.states.values()])

    driver.give(ev.GoTo("b"))

    assert driver.of(fx.PhaseChange)[-1].phase == "b"
    assert not driver.state.mission.paused
    assert command(driver, "Brake")[-1].status == "sent"


def test_it_stays_paused_where_the_phase_does_not_begin(drive):
    driver = paused_while_driving(drive)
    standing = {**driver.states, "FrontWheelsState": "Fixed", "RearWheelsState": "Fixed"}
    enterable(driver, b=[standing.values()])

    driver.give(ev.GoTo("b"))

    assert driver.state.mission.paused
    assert "b does not begin: the robot is in" in messages(driver)[-1]
    assert "the phase begins in" in messages(driver)[-1]


def test_it_stays_paused_where_nobody_knows_how_the_phase_begins(drive):
    driver = paused_while_driving(drive)

    driver.give(ev.GoTo("b"))

    assert driver.state.mission.paused
    assert "nobody has found out" in messages(driver)[-1]


def test_an_unknown_phase_and_a_running_mission_are_told(drive):
    driver = drive(MISSION, nominal=True)
    driver.until_waiting("a")

    driver.give(ev.GoTo("b"))
    driver.give(ev.GoTo("nowhere"))

    assert messages(driver)[-2:] == [
        "b does not begin: pause the mission first",
        "nowhere does not begin: the mission has no such phase",
    ]


def test_a_command_that_the_pause_suspended_is_given_up(drive):
    driver = drive(MISSION, nominal=True)
    driver.accept()
    driver.give(ev.Pause())
    before = driver.states
    enterable(driver, a=[before.values()])
    table = driver.robot.table
    unsure = Situation(
        table.index_of(tuple(before.values())),
        frozenset({table.regions.index("BendingState"), table.regions.index("FrontWheelsState")}),
    )
    program = replace(driver.engine.program, entries={"a": frozenset({unsure})})
    driver.engine = Engine(driver.robot, program, nominal=True)

    driver.give(ev.GoTo("a"))

    assert command(driver, "ClampFront")[-2].status == "failed"
    assert command(driver, "ClampFront")[-1].status == "sent", "the same again is a retry"


def test_an_engine_can_begin_with_the_operator_and_where_another_left_the_robot(drive):
    first = paused_while_driving(drive)

    second = drive(MISSION, nominal=True)
    second.state, effects = second.engine.start(5.0, body=first.state.robot, paused=True)

    assert second.state.robot.configuration == first.state.robot.configuration
    assert second.state.mission.paused
    assert not [each for each in effects if isinstance(each, fx.CommandStatus)]
