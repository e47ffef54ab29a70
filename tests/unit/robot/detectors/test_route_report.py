"""The report of the joint ahead on a known route."""

from __future__ import annotations

from math import isnan, nan, pi

import pytest

from pirate_sm.core.models import Pipe
from pirate_sm.robot.detectors.route_report import RouteReport

PLACES = (0.6, 0.5, 0.4, 0.3, 0.2, 0.1)

HOUSE = {
    "section": "round",
    "diameter": "120 mm",
    "runs": {
        "main": {"from": "entry", "to": "t1", "segments": [{"straight": "1 m"}]},
        "on": {"from": "t1.on", "to": "cap", "segments": [{"straight": "1 m"}]},
        "branch": {
            "from": "t1.branch",
            "to": "exit",
            "diameter": "110 mm",
            "segments": [
                {"straight": "1 m"},
                {"mitre": "90 deg", "roll": "90 deg"},
                {"straight": "1 m"},
            ],
        },
    },
    "junctions": {"t1": {"tee": "90 deg", "roll": "90 deg"}},
    "ends": {"entry": "open", "cap": "closed", "exit": "open"},
    "routes": {"in": ["main", "branch"], "past": ["main", "on"]},
}


def report_in(pipe: Pipe) -> RouteReport:
    return RouteReport(pipe.route(), 1.0)


def at(first_m: float) -> tuple[float, ...]:
    return tuple(first_m - 0.6 + place for place in PLACES)


def test_the_next_joint_is_that_which_the_last_wheel_has_not_passed() -> None:
    looking = report_in(Pipe.model_validate(HOUSE))
    found = []
    for first_m in (0.6, 1.2, 1.7, 2.0, 2.7):
        report = looking.look(first_m, at(first_m), 0.0)
        assert report is not None
        found.append((report.joint, report.junction, round(report.distance_m, 6), report.run))
    assert found == [
        ("tee", "t1", 0.4, "main"),
        ("tee", "t1", -0.2, "branch"),
        ("mitre", "", 0.3, "branch"),
        ("mitre", "", 0.0, "branch"),
        ("end", "", 0.3, "branch"),
    ]


def test_the_opening_is_told_against_the_robots_own_plane() -> None:
    looking = report_in(Pipe.model_validate(HOUSE))
    upright = looking.look(0.0, PLACES, 0.0)
    turned = looking.look(1.0, PLACES, pi / 2)
    unknown = looking.look(2.0, PLACES, nan)
    assert upright is not None
    assert turned is not None
    assert unknown is not None
    assert upright.opening_roll_rad == pytest.approx(pi / 2)  # the tee opens upwards
    assert turned.opening_roll_rad == pytest.approx(0.0)  # and side A of this robot is up
    assert isnan(unknown.opening_roll_rad)
    over = looking.look(3.0, PLACES, -pi)
    assert over is not None
    assert over.opening_roll_rad == pytest.approx(-pi / 2)  # never more than half a turn
    assert upright.diameter_ahead_m == pytest.approx(0.11)


def test_a_tee_straight_on_is_told_with_its_opening() -> None:
    pipe = Pipe.model_validate(HOUSE).along("past")
    report = report_in(pipe).look(0.0, PLACES, 0.0)
    assert report is not None
    assert (report.joint, report.junction) == ("tee", "t1")
    assert report.opening_roll_rad == pytest.approx(pi / 2)
    assert report.diameter_ahead_m == pytest.approx(0.12)


NARROWING = Pipe.model_validate(
    {
        "section": "round",
        "diameter": "120 mm",
        "segments": [
            {"straight": "1 m"},
            {"reducer": "200 mm", "to": "110 mm"},
            {"straight": "1 m"},
            {"reducer": "0 mm", "to": "100 mm"},
            {"straight": "1 m"},
        ],
    }
)


@pytest.mark.parametrize(
    ("last_m", "joint", "ahead_m", "distance_m"),
    [
        (0.5, "reducer", 0.11, 0.0),
        (1.19, "reducer", 0.11, -0.69),
        (1.2, "reducer", 0.1, 0.5),
        (2.19, "reducer", 0.1, -0.49),
        (2.2, "end", nan, 1.5 - 1.0),
    ],
)
def test_a_joint_is_ahead_until_the_last_wheel_is_beyond_it(
    last_m: float, joint: str, ahead_m: float, distance_m: float
) -> None:
    report = report_in(NARROWING).look(0.0, (last_m + 0.5, last_m), 0.0)

    assert report is not None
    assert report.joint == joint
    assert report.diameter_ahead_m == pytest.approx(ahead_m, nan_ok=True)
    assert report.distance_m == pytest.approx(distance_m)


def test_another_joint_is_told_at_once_and_after_a_place_that_was_lost_too() -> None:
    looking = RouteReport(NARROWING.route(), 2.0)
    assert looking.look(0.0, (1.69, 1.19), 0.0) is not None
    assert looking.look(0.1, (1.695, 1.195), 0.0) is None
    assert looking.look(0.2, (1.71, 1.21), 0.0) is not None
    assert looking.look(0.3, (nan, nan), 0.0) is None
    assert looking.look(0.4, (1.71, 1.21), 0.0) is not None


def test_it_is_told_again_after_exactly_half_of_its_validity_and_a_tenth_of_a_metre() -> None:
    looking = RouteReport(NARROWING.route(), 2.0)
    assert looking.look(0.0, (0.0,), 0.0) is not None
    assert looking.look(0.999, (0.0,), 0.0) is None
    assert looking.look(1.0, (0.0,), 0.0) is not None
    assert looking.look(1.5, (0.099,), 0.0) is None
    assert looking.look(1.5, (0.1,), 0.0) is not None


def test_it_is_told_again_after_a_piece_of_way_and_before_it_expires() -> None:
    looking = report_in(Pipe.model_validate(HOUSE))
    assert looking.look(0.0, at(0.6), 0.0) is not None
    assert looking.look(0.1, at(0.64), 0.0) is None
    assert looking.look(0.2, at(0.72), 0.0) is not None
    assert looking.look(0.6, at(0.72), 0.0) is None
    assert looking.look(0.75, at(0.72), 0.0) is not None


def test_a_lost_robot_is_told_nothing() -> None:
    looking = report_in(Pipe.model_validate(HOUSE))
    assert looking.look(0.0, (nan, *PLACES[1:]), 0.0) is None


def test_another_pipe_is_told_at_once() -> None:
    looking = report_in(Pipe.model_validate(HOUSE))
    assert looking.look(0.0, at(0.99), 0.0) is not None
    assert looking.look(0.1, at(0.995), 0.0) is None
    report = looking.look(0.2, at(1.01), 0.0)
    assert report is not None
    assert (report.joint, report.run) == ("tee", "branch")


@pytest.mark.parametrize(
    ("first_m", "last_m", "away_m"),
    [
        (0.7, 0.3, 0.3),  # to the reducer
        (1.5, 0.95, 0.05),  # the last wheel to it
        (1.9, 1.32, 0.12),  # the last wheel behind its end
        (2.19, 1.7, 0.01),
        (2.9, 2.23, 0.03),
    ],
)
def test_no_other_joint_is_told_before_a_wheel_can_have_reached_it(
    first_m: float, last_m: float, away_m: float
) -> None:
    looking = report_in(NARROWING)

    assert looking.wait_s((first_m, last_m), 0.1) == pytest.approx(away_m / 0.1)
    assert looking.wait_s((last_m, first_m), 0.2) == pytest.approx(away_m / 0.2)
