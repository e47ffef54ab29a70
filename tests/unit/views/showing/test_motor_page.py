"""Setpoints next to what is measured, with the last minute of both."""

from __future__ import annotations

from dataclasses import replace
from math import nan

import pytest

from pirate_sm.robot.backends.serial.link.health import LinkHealth
from pirate_sm.views.showing.body_panel import motors, motors_heading
from pirate_sm.views.showing.snapshot import TREND_LENGTH, Snapshot, sent_name

from .test_panels import beginning


@pytest.fixture(scope="module")
def snapshot() -> Snapshot:
    return beginning("mitre_bend", "sim")


def sending(snapshot: Snapshot, value: float) -> Snapshot:
    """The same moment, with this setpoint in every slot."""
    assert snapshot.state is not None
    robot = snapshot.state.robot
    values = (value,) * len(robot.values)
    flight = robot.flight and robot.flight._replace(values=values)
    body = robot._replace(values=values, flight=flight)
    return replace(snapshot, state=snapshot.state._replace(robot=body))


def test_each_motor_has_its_setpoint_and_its_measurement(snapshot: Snapshot) -> None:
    wheel = snapshot.scene.anatomy.wheels[0]
    found = [each.plain for each in motors(sending(snapshot, -0.5), 80, 11)]
    (line,) = [each for each in found if each.startswith(wheel.name)]

    assert len(found) == len(snapshot.scene.anatomy.motors)
    assert "-50 %" in line
    assert line[17:31].strip() == "–"  # a speed needs a second report
    assert "mA" in line


def test_an_angle_that_is_kept_and_not_measured_yet_has_no_number(snapshot: Snapshot) -> None:
    found = [each.plain for each in motors(sending(snapshot, nan), 80, 11)]

    assert not any("nan°" in each for each in found)


@pytest.mark.parametrize(("width", "height"), [(36, 4), (78, 18), (118, 33), (158, 44)])
def test_it_fits(snapshot: Snapshot, width: int, height: int) -> None:
    lines = motors(snapshot, width, height)

    assert all(len(each) <= max(width, 40) for each in (motors_heading(width), *lines))
    assert len(lines) <= max(height, len(snapshot.scene.anatomy.motors))


def test_the_last_minute_has_a_curve_with_a_gap_where_nothing_was_known(
    snapshot: Snapshot,
) -> None:
    motor = snapshot.scene.anatomy.wheels[0]
    known = (motor.limit,) * (TREND_LENGTH // 2)
    trends = {
        motor.value: (*known, *(nan,) * (TREND_LENGTH // 2)),
        sent_name(motor.slot): (1.0,) * TREND_LENGTH,
    }
    at = snapshot.scene.anatomy.motors.index(motor)
    line = motors(replace(snapshot, trends=trends), 100, 11)[at].plain
    sent, measured = line[41:70], line[71:100]

    assert set(sent) == {"⠉"}
    assert set(measured.rstrip()) <= {"⠉", "⠁"}
    assert len(measured.rstrip()) == pytest.approx(len(measured) / 2, abs=1)


def test_what_a_silent_robot_measured_is_marked_and_has_its_age(snapshot: Snapshot) -> None:
    health = LinkHealth(9, 0, 3, 0, 0, nan, 3.2, "nothing comes", 7.6, stopped=False)

    for line in motors(replace(snapshot, link=health), 80, 11):
        assert "┄" in line.plain
        assert "3s" in line.plain
