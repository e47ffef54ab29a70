"""Courses of events: read from files, and told in the terms of a robot."""

from __future__ import annotations

from math import isnan
from typing import Any

import pytest

from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._loading.problems import LoadError
from pirate_sm.core._loading.robot.loader import load_robot
from pirate_sm.core._loading.yaml.document import parse_document
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import find_robot
from pirate_sm.robot.backends.trace_script import Happening, read_script, resolve_course


@pytest.fixture(scope="module")
def robot() -> RobotSpec:
    return load_robot(find_robot("pirate_ii")).oriented("normal")


def happening(**signals: Any) -> Happening:
    return Happening(happens="sensors", signals=signals)


def test_a_course_is_read_in_order() -> None:
    text = "format: 1\ncourse: [{happens: start}, {happens: fault, fault: robot.stuck}]\n"

    course = read_script(parse_document(text, "c.yaml")).course

    assert [each.happens for each in course] == ["start", "fault"]
    assert course[1].fault == "robot.stuck"


@pytest.mark.parametrize(
    "entry",
    [
        "{happens: perhaps}", "{happens: answer}", "{happens: fault}",
        "{happens: time, answer: yes}", "{happens: start, signals: {way: [1]}}",
    ],
)  # fmt: skip
def test_what_is_no_course_is_refused(entry: str) -> None:
    with pytest.raises(LoadError):
        read_script(parse_document(f"format: 1\ncourse: [{entry}]\n", "c.yaml"))


def test_signals_are_told_in_si(robot: RobotSpec) -> None:
    (told,) = resolve_course(
        [happening(odometry="50 mm", detector="close", segment="unknown")], robot
    )

    assert told.report is not None
    assert told.report.numbers == (("odometry", pytest.approx(0.05)),)
    assert told.report.words == (("detector", "close"), ("segment", None))


def test_unknown_in_a_course_is_reported_as_nan(robot: RobotSpec) -> None:
    (told,) = resolve_course([happening(phi="unknown")], robot)

    assert told.report is not None
    assert isnan(told.report.numbers[0][1])


def test_without_signals_there_is_no_report(robot: RobotSpec) -> None:
    assert resolve_course([happening()], robot)[0].report is None


@pytest.mark.parametrize(
    ("signals", "said"),
    [
        ({"odometri": "50 mm"}, "did you mean 'odometry'"),
        ({"BendingState": "DoubleClamped"}, "signal 'BendingState'"),  # commands change it
        ({"odometry": "50 s"}, "odometry: 50 s"),
        ({"detector": "clos"}, "detector: clos: expected"),
    ],
)
def test_what_the_robot_does_not_know_is_said(
    robot: RobotSpec, signals: dict[str, str], said: str
) -> None:
    with pytest.raises(UsageError, match=said):
        resolve_course([happening(**signals)], robot)
