"""A fault is of somebody: of a board, a joint, a wheel or a part."""

from __future__ import annotations

import math

import pytest
from driving import BOTH_CLAMPED, IDLE, NEWT, PIRATE, Driver, command, write_mission

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.engine import Engine
from pirate_sm.core._loading.mission.loader import load_mission
from pirate_sm.core._loading.problems import LoadError
from pirate_sm.core._model import events as ev

DEAD_WHEELS = """
on_fault:
  - {fault: [sensor.silent, wheel.dead], of: [wheel_3, wheel_4], then: continue}
  - {fault: sensor.silent, of: rear, go: rescue}
start: a
phases:
  a: {do: [ClampFront, ClampRear, DriveForward], wait: [{operator: x, go: e}], within: {time: 1 h, go: e}}
  rescue: {wait: [{after: 10 s, go: e}]}
ends: {e: {succeed: "After {cause}"}}
"""  # noqa: E501
EVERYBODY = "on_fault: [{fault: [sensor.silent, clamp.lost], then: continue}]\n"
TURN = 2 * math.asin((0.113 - 0.048) / 0.09)


def holding(drive, body: str = EVERYBODY + IDLE) -> Driver:
    """A robot that holds with both parts, as its sensors show."""
    driver = drive(body, states=BOTH_CLAMPED)
    for n in (1, 2, 3, 4):
        way = 1 if n % 2 == 0 else -1
        driver.signals |= {f"gamma_{n}": way * TURN, f"bend_torque_{n}": way * 0.6}
    driver.run(1.0)
    assert driver.unconfirmed == set()
    return driver


def without(driver: Driver, board: int, until: float) -> None:
    """All boards but one report."""
    while driver.now < until - 1e-9 and not driver.ended:
        driver.now += 0.1
        for each in driver.robot.boards:
            if each != board:
                driver.report(each)
        driver.tick(driver.now)


@pytest.mark.parametrize(
    ("of", "handling"),
    [
        (("wheel_3",), "continue"),
        (("wheel_3", "wheel_4"), "continue"),
        (("board_25",), "stop"),  # it is the roll joint's board too
        (("board_26",), "rescue"),  # a joint and a wheel, both of the rear
        (("gamma_3",), "rescue"),
        (("gamma_1",), "stop"),
        (("wheel_4", "gamma_1"), "stop"),
        ((), "stop"),
    ],
)
def test_belief_a_line_counts_for_the_faults_of_those_that_it_names(drive, of, handling):
    driver = drive(DEAD_WHEELS)
    driver.until_waiting("a")

    driver.give(ev.FaultReport("sensor.silent", "no value", of=of))

    assert driver.of(fx.Fault) == [fx.Fault("sensor.silent", "no value", handling, of)]


@pytest.mark.parametrize(
    ("board", "of"), [(26, ("board_26",)), (24, ("board_24",))], ids=["joint", "imu"]
)
def test_a_silent_board_is_a_fault_of_that_board(drive, board, of):
    driver = holding(drive)

    without(driver, board, 3.0)

    assert [fault.of for fault in driver.of(fx.Fault)] == [of]


def test_a_sensor_without_a_value_is_a_fault_of_what_it_measures(drive):
    driver = holding(drive)

    driver.show(1.1, theta_3=math.nan)
    driver.show(1.2, acc_x=math.nan)

    assert [fault.of for fault in driver.of(fx.Fault)] == [("wheel_3",), ("board_24",)]


def test_belief_that_a_sensor_has_no_value_ends_with_its_next_one(drive):
    driver = holding(drive)

    for at_s in (1.2, 1.4):
        driver.show(at_s, theta_3=math.nan)
        driver.show(at_s + 0.05, theta_3=math.nan)
        driver.show(at_s + 0.1, theta_3=0.0)

    assert [fault.of for fault in driver.of(fx.Fault)] == [("wheel_3",)] * 2


def test_a_rule_says_whose_its_fault_is(drive):
    driver = holding(drive, EVERYBODY + IDLE)

    driver.run(3.0)
    driver.show(gamma_4=math.radians(119))
    driver.run(5.0)

    assert [(fault.code, fault.of) for fault in driver.of(fx.Fault)] == [("clamp.lost", ("rear",))]


@pytest.mark.parametrize("board", [26, 27])
def test_belief_a_clamp_is_not_confirmed_while_what_showed_it_is_silent(drive, board):
    driver = holding(drive)

    without(driver, board, 1.6)  # a signal is unknown after 0.5 s, its board silent after 1 s

    command(driver, "RelaxFront")
    assert driver.faults == []
    assert driver.unconfirmed == {"BendingState"}
    assert driver.statuses == [("RelaxFront", "refused")]
    assert "last confirmed clamp" in driver.last_status.reason


@pytest.mark.parametrize("board", [26, 27])
def test_a_clamp_is_unconfirmed_when_a_board_that_shows_it_is_silent(drive, board):
    driver = holding(drive)

    without(driver, board, 3.0)

    assert driver.unconfirmed == {"BendingState"}
    assert driver.faults == [("sensor.silent", "continue")]


def test_a_part_holds_still_where_a_board_without_its_joints_is_silent(drive):
    driver = holding(drive)

    without(driver, 24, 3.0)

    assert driver.unconfirmed == set()


def test_belief_a_clamp_is_confirmed_again_when_its_sensors_show_it(drive):
    driver = holding(drive)
    without(driver, 26, 3.0)

    driver.run(3.4)
    assert "BendingState" in driver.unconfirmed  # it must be seen for half a second
    driver.run(4.0)

    assert driver.unconfirmed == set()
    command(driver, "RelaxFront")
    assert driver.statuses[-1] == ("RelaxFront", "sent")


def test_a_clamp_stays_unconfirmed_when_its_sensors_come_back_and_show_none(drive):
    driver = holding(drive)
    without(driver, 26, 3.0)

    driver.signals |= {"bend_torque_3": 0.0}
    driver.run(6.0)

    assert "BendingState" in driver.unconfirmed


def test_a_command_confirms_a_clamp_that_was_not_seen(drive):
    driver = holding(drive)
    without(driver, 26, 3.0)

    command(driver, "ClampRear")
    driver.until_done("ClampRear")

    assert driver.unconfirmed == set()


def test_in_a_recording_of_before_faults_are_nobodys_and_clamps_stay_confirmed(drive):
    driver = holding(drive)
    driver.engine = Engine(driver.robot, driver.engine.program, nominal=False, alphabet=9)

    without(driver, 26, 3.0)

    assert [fault.of for fault in driver.of(fx.Fault)] == [()]
    assert driver.unconfirmed == set()
    command(driver, "RelaxFront")
    assert driver.statuses[-1] == ("RelaxFront", "sent")


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("{fault: sensor.silent, of: [wheel_33], then: continue}", "did you mean 'wheel_3'?"),
        ("{fault: sensor.silent, of: board_24, then: continue}", ""),
        ("{fault: sensor.jumped, of: wheel_3, then: continue}", "gamma_1, gamma_2, gamma_3"),
        ("{fault: robot.stuck, of: rear, then: continue}", "it is nobody's"),
        ("{fault: wheel.dead, of: [wheel_3, phi], then: continue}", "a fault of phi"),
        ("{fault: sensor.silent, of: [], then: continue}", "at least one of its entries"),
    ],
)
def test_a_fault_handler_may_only_name_things_that_have_its_fault(tmp_path, line, told):
    path = write_mission(tmp_path, f"on_fault: [{line}]\n{IDLE}")
    if not told:
        load_mission(path)
        return

    with pytest.raises(LoadError) as error:
        load_mission(path)

    assert told in str(error.value)


def test_boards_joints_wheels_and_parts_of_another_robot_have_names(drive):
    things = drive(IDLE, NEWT).robot.owners.things

    assert {"left_fore", "neck"} <= things.keys()
    assert all(each in things for named in things.values() for each in named)
    assert PIRATE.name not in things
