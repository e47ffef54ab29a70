"""The conditions that a failed command has awaited, and what the sensors show instead."""

import math
from math import inf, nan

import pytest
from driving import IDLE, command
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._engine.robot.actuation_spec import PositionSpec
from pirate_sm.core._engine.robot.criteria import (
    AngleSet,
    Bound,
    CriterionSpec,
    JointsArrived,
    TorqueBorne,
    WheelTurning,
    only,
    standing,
)
from pirate_sm.core._engine.robot.loops import RunningPositionLoop
from pirate_sm.core._expressions import BooleanType, Expression
from pirate_sm.core._model.events import Abort

LOOP = RunningPositionLoop(0, 0, 1, 2, PositionSpec(1.0, 0.5, 0.1, 1.0, 2.0), 1.0)

CRITERIA = {
    "accepted": (),
    "stalled": (*(only(Bound(at, "<", 0.5)) for at in (0, 1)), TorqueBorne(2, 0, 0.7, 0.4)),
    "reached": (JointsArrived(0.5, 0.4),),
    "reached by a weak motor": (JointsArrived(0.5, 0.0, least_nm=0.4),),
    "turning": (WheelTurning(((0, 1), (1, 2)), 0.5),),
    "stopped": (*standing((0, 1), 0.5), *standing((2,), 0.5)),
    "aligned": (AngleSet(0, 1, 0.5), AngleSet(1, 2, 0.5)),
    "below": tuple(only(Bound(at, "<", 0.5)) for at in (0, 2)),
}

numbers = st.tuples(*[st.sampled_from([nan, -1.0, -0.5, 0.0, 0.4, 0.5, 1.0])] * 3)
setpoints = st.tuples(*[st.sampled_from([-1.0, 0.5, 1.0])] * 2)


@pytest.mark.parametrize("kind", CRITERIA)
@given(numbers=numbers, setpoints=setpoints)
def test_a_criterion_holds_where_its_condition_in_chunks_is_true(kind, numbers, setpoints):
    criterion = CriterionSpec(kind, "", "", CRITERIA[kind])
    condition = Expression("", BooleanType(), criterion.condition(setpoints, (LOOP,)))

    expected = condition.evaluate(numbers, ()) is True
    assert criterion.holds(numbers, setpoints, (LOOP,)) == expected


def test_wheels_that_others_push_are_not_driven():
    criterion = CriterionSpec("turning", "", "", CRITERIA["turning"])

    assert not criterion.holds((nan, 3.0, 3.0), (0.0, 0.0), ())


def clamping(drive, mission=IDLE):
    driver = drive(mission)
    driver.signals |= {"gamma_1": math.radians(20), "bend_torque_1": -0.1, "bend_torque_2": 0.6}
    driver.report_all(0.1)
    command(driver, "ClampFront")
    driver.accept()
    return driver


def test_a_failed_command_reports_the_sensors_that_do_not_show_it_done(drive):
    driver = clamping(drive)
    driver.signals["bend_torque_1"] = -0.3

    driver.run(40.2)

    status = driver.last_status
    assert status.status == "failed"
    (unmet,) = status.unmet
    assert (unmet.signal, unmet.unit, unmet.magnitude) == ("bend_torque_1", "Nm", True)
    assert (unmet.least, unmet.most) == (pytest.approx(0.311, abs=1e-3), inf)
    assert unmet.value == pytest.approx(-0.3, abs=0.01)
    assert unmet.change == pytest.approx(-0.2, abs=0.01)
    assert (unmet.unknown, unmet.board) == ("", "board 22 (bend_1)")
    assert 0 <= unmet.age_s <= 0.1
    assert "bend_torque_1 should be at least 311 mNm in either direction" in status.reason
    assert status.reason.endswith("then repeat it")


def test_a_silent_board_is_named_with_the_time_since_its_last_report(drive):
    driver = clamping(drive, f"on_fault: [{{fault: sensor.silent, then: continue}}]\n{IDLE}")
    while driver.now < 40.2:
        driver.now += 0.1
        for board in driver.robot.boards:
            if board != 22:
                driver.report(board)

    found = {each.signal: each for each in driver.last_status.unmet}
    assert found["gamma_rate_1"].unknown == "silent"
    assert found["gamma_rate_1"].age_s > 39
    assert math.isnan(found["gamma_rate_1"].value)
    assert "gamma_rate_1 should be within" in driver.last_status.reason
    assert "has had no value for 40" in driver.last_status.reason
    assert "the cable of board 22 (bend_1)" in driver.last_status.reason


def test_a_condition_that_has_not_held_long_enough_is_said_with_its_time(drive):
    driver = clamping(drive)
    driver.run(39.9)
    driver.signals["bend_torque_1"] = -0.6

    driver.run(40.2)

    assert driver.last_status.unmet == ()
    assert "it has held for" in driver.last_status.reason


def test_a_command_that_a_fault_interrupts_says_what_it_still_awaited(drive):
    driver = clamping(drive)
    driver.run(1.0)

    driver.give(Abort("enough"))

    assert [each.signal for each in driver.last_status.unmet] == ["bend_torque_1"]
    assert driver.last_status.reason.startswith(
        "the mission ended; it was not done yet: bend_torque_1 should be at least 311 mNm"
    )


def test_a_trace_without_sensors_awaits_none_of_them(drive):
    driver = drive(IDLE, nominal=True)
    command(driver, "ClampFront")
    driver.accept()

    driver.give(Abort("enough"))

    assert driver.last_status == ("ClampFront", "failed", "the mission ended", "", ())
