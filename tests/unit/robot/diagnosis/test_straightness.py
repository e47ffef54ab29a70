"""Zeros are taken from a robot that lies straight and still, and from no other."""

from __future__ import annotations

from math import degrees, radians

import pytest

from pirate_sm.robot.diagnosis.facts import ExpectedRobot
from pirate_sm.robot.diagnosis.judgement import JointReading, objections, read_joints

from .conftest import Connect

JOINTS = ("gamma_4", "gamma_1")
LIMIT_RAD = radians(15)


def reading(mean_deg: float = 1.0, spread_deg: float = 0.2, taken: int = 30) -> JointReading:
    return JointReading("gamma_1", radians(mean_deg), radians(spread_deg), taken, 0.0)


def test_a_straight_robot_shows_zeros_in_the_order_asked_for(
    connect: Connect, subject: ExpectedRobot
) -> None:
    with connect() as listening:
        listening.listen(3.0)
        readings = read_joints(subject, listening.records, JOINTS)

    assert [each.name for each in readings] == list(JOINTS)
    assert all(abs(degrees(each.mean)) < 0.1 for each in readings)
    assert all(0 < degrees(each.spread) < 1 for each in readings)
    assert objections(readings, LIMIT_RAD) == []


def test_a_zero_that_jumped_is_measured(connect: Connect, subject: ExpectedRobot) -> None:
    with connect(defects=("gamma_1_zero_jumps",)) as listening:
        listening.listen(10.0)
        listening.listen(3.0)
        (jumped,) = read_joints(subject, listening.records, ("gamma_1",))

    assert degrees(jumped.mean) == pytest.approx(10.0, abs=0.1)


@pytest.mark.parametrize(
    ("bad", "told"),
    [
        (reading(taken=9), "gamma_1 was read 9 times only"),
        (reading(spread_deg=1.5), "gamma_1 is not still: it moved by 1.5 deg"),
        (reading(mean_deg=-15.5), "gamma_1 shows -15.5 deg, more than 15 deg from zero"),
        (reading(spread_deg=0.0), "gamma_1 shows exactly the same all the time"),
    ],
)
def test_what_must_not_become_a_zero_is_reported(bad: JointReading, told: str) -> None:
    (objection,) = objections([reading(), bad], LIMIT_RAD)

    assert objection.startswith(told)


def test_silence_is_no_zero(connect: Connect, subject: ExpectedRobot) -> None:
    with connect(sensors_started=False) as listening:
        listening.listen(2.0)
        readings = read_joints(subject, listening.records, JOINTS)

    assert len(objections(readings, LIMIT_RAD)) == len(JOINTS)
