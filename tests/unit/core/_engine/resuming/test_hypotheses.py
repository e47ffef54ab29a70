"""Where a robot may be whose run was cut off."""

from __future__ import annotations

import pytest
from driving import BOTH_CLAMPED, IDLE, Driver, command

from pirate_sm.core._engine.resuming.hypotheses import Hypothesis, hypotheses
from pirate_sm.core._engine.robot.robot_state import DECLARED, DENIED, STOPPED, Mark
from pirate_sm.core._engine.unwatched import denied, unproven


def found(driver: Driver, maybe: str = "", **body) -> tuple[Hypothesis, ...]:
    last = driver.state._replace(robot=driver.state.robot._replace(**body))
    index = driver.robot.table.command_index[maybe] if maybe else None
    return hypotheses(driver.robot, driver.engine.program, last, index)


def commands_of(each: tuple[Hypothesis, ...]) -> list[str]:
    return [it.command for it in each]


@pytest.fixture
def clamped(drive) -> Driver:
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.run(0.4)
    return driver


@pytest.fixture
def going_on(clamped) -> Driver:
    """A robot whose wheels are driven."""
    command(clamped, "DriveForward")
    clamped.accept()
    return clamped


def test_a_command_in_flight_counts_and_not_the_one_that_may_have_been_sent(clamped):
    command(clamped, "RelaxRear")

    assert commands_of(found(clamped, "DriveForward")) == ["", "RelaxRear"]
    assert commands_of(found(clamped)) == ["", "RelaxRear"]


def test_an_array_of_a_loop_leads_nowhere_else(clamped):
    command(clamped, "RelaxRear")
    flight = clamped.state.robot.flight

    assert commands_of(found(clamped, flight=flight._replace(purpose="loop"))) == [""]


def test_a_first_array_without_its_command_leads_nowhere(clamped):
    command(clamped, "RelaxRear")

    assert commands_of(found(clamped, motion=None)) == [""]


@pytest.mark.parametrize(("name", "drives"), [("DriveForward", True), ("RelaxRear", False)])
def test_it_says_whether_its_array_drives_wheels(clamped, name, drives):
    command(clamped, name)

    assert [each.drives for each in found(clamped)] == [False, drives]
    assert [each.name for each in found(clamped)] == ["recorded", "sent"]


def test_the_array_that_holds_the_robot_stops_its_wheels(going_on):
    (recorded,) = found(going_on)
    wheels = going_on.robot.safe_zero
    assert any(going_on.state.robot.values[slot] for slot in wheels)

    assert all(recorded.body.values[slot] == 0.0 for slot in wheels)
    others = set(range(len(recorded.body.values))) - set(wheels)
    assert all(recorded.body.values[slot] == going_on.state.robot.values[slot] for slot in others)


def test_the_array_that_holds_it_has_a_number_that_none_in_flight_has(clamped):
    assert found(clamped)[0].body.next_id == clamped.state.robot.next_id
    command(clamped, "RelaxRear")
    body = clamped.state.robot

    assert [each.body.next_id for each in found(clamped)] == [body.next_id + 1] * 2


def test_wheels_that_are_driven_are_marked_as_stopped(going_on):
    robot, body = going_on.robot, going_on.state.robot
    driven = robot.driven[body.configuration]

    marks = unproven(robot, body)

    assert {mark for mark in marks if mark.command == STOPPED} == {
        Mark("region", each, STOPPED) for each in driven
    }
    assert driven


def test_wheels_that_turned_may_have_come_to_rest_and_are_not_denied(clamped):
    clamped.run(1.0, **{f"theta_{number}": 3.0 for number in range(1, 7)})
    (recorded,) = found(clamped)
    names = clamped.robot.regions

    marks = {
        names[mark.which]: mark.command
        for mark in denied(clamped.robot, clamped.engine.program, clamped.state, recorded.body)
        if mark.kind == "region"
    }

    assert marks["FrontWheelsState"] == marks["RearWheelsState"] == DECLARED


def test_a_clamp_that_the_last_signals_contradict_is_denied(clamped):
    clamped.run(2.0)
    clamped.signals |= {"bend_torque_1": 0.0, "bend_torque_2": 0.0}
    clamped.run(4.0)

    (recorded,) = found(clamped)

    parts = {mark.which: mark.command for mark in recorded.body.marks if mark.kind == "part"}
    assert parts[0] == DENIED
