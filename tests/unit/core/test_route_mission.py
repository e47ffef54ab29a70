"""Missions along a route, composed of those that pass its joints."""

from __future__ import annotations

from math import pi

import pytest

from pirate_sm.core import library
from pirate_sm.core._loading.robot.loader import load_robot
from pirate_sm.core._loading.yaml.document import parse_document
from pirate_sm.core._loading.yaml.validation import validate
from pirate_sm.core._model.mission import CallStep, Mission
from pirate_sm.core._model.pipe import Pipe
from pirate_sm.core._model.robot.profile import Profile
from pirate_sm.core.errors import UsageError
from pirate_sm.core.generated_missions import (
    RouteCourse,
    UndrivableError,
    course_along,
    mission_along,
)


@pytest.fixture(scope="module")
def profile() -> Profile:
    return load_robot(library.find_robot("pirate_ii")).profile


def called(course: RouteCourse) -> list[list[str]]:
    return [[step.call for step in steps] for _, steps in course.calls]


def straights(*fittings: object) -> list[object]:
    found: list[object] = [{"straight": "1.2 m"}]
    for fitting in fittings:
        found += [fitting, {"straight": "1.2 m"}]
    return found


def bars(*fittings: object, **more: object) -> Pipe:
    segments = straights(*fittings)
    return Pipe.model_validate({"diameter": "120 mm", "segments": segments, **more})


def round_pipe(*fittings: object, **more: object) -> Pipe:
    return bars(*fittings, section="round", **more)


def test_each_bend_is_passed_by_its_mission(profile: Profile) -> None:
    course = course_along(bars({"mitre": "90 deg"}, {"mitre": "60 deg"}), profile)
    assert called(course) == [["take_bend"], ["take_bend"]]
    assert course.polarity == "normal"
    assert 0.5 < course.last_m < 1.0


def test_bends_to_the_other_side_are_passed_in_mirrored_polarity(profile: Profile) -> None:
    course = course_along(bars({"mitre": "-90 deg"}), profile)
    assert course.polarity == "mirrored"
    text = mission_along("m", "", "p", "pirate_ii", course, profile.travel)
    assert "polarity: mirrored\n" in text


@pytest.mark.parametrize(
    "fittings",
    [
        [{"mitre": "90 deg", "roll": "45 deg"}],
        [{"mitre": "90 deg"}, {"tee": "90 deg", "take": "on", "roll": "45 deg"}],
    ],
)
def test_a_joint_that_nothing_passes_is_named(profile: Profile, fittings: list[object]) -> None:
    with pytest.raises(UsageError, match=r"pirate_ii does not get past the \w+ at \d+ mm"):
        course_along(round_pipe(*fittings), profile)


def test_a_robot_that_is_rolled_passes_what_lies_in_its_plane(profile: Profile) -> None:
    start = {"at": "700 mm", "roll": "90 deg"}
    pipe = round_pipe({"mitre": "90 deg", "roll": "90 deg"}, start=start)
    assert len(course_along(pipe, profile).calls) == 1


def test_it_turns_by_a_quarter_before_what_lies_square_to_it(profile: Profile) -> None:
    elbow = {"elbow": "90 deg", "radius": "180 mm", "roll": "90 deg"}
    pipe = round_pipe({"mitre": "90 deg"}, elbow, {"mitre": "90 deg", "roll": "90 deg"})
    course = course_along(pipe, profile)
    assert called(course) == [["take_bend"], ["turn_right", "take_elbow"], ["take_bend"]]


def test_it_turns_by_a_quarter_before_an_opening_in_its_plane(profile: Profile) -> None:
    course = course_along(round_pipe({"mitre": "90 deg"}, {"tee": "90 deg", "take": "on"}), profile)
    assert called(course) == [["take_bend"], ["turn_right"]]


def test_it_drives_clear_of_an_opening_before_it_turns_back(profile: Profile) -> None:
    pipe = round_pipe({"tee": "90 deg", "take": "on"}, {"mitre": "90 deg"}, start={"at": "700 mm"})
    course = course_along(pipe, profile)
    assert called(course) == [["turn_right"], ["drive_on", "turn_left", "take_bend"]]
    way_m = course.calls[1][1][0].way_m
    assert way_m is not None
    assert 700 < 1e3 * (0.7 + way_m) - 1260 + 200 < 800  # the last wheel is behind the mouth


def test_it_turns_by_a_half_before_a_bend_to_the_other_side(profile: Profile) -> None:
    course = course_along(round_pipe({"mitre": "90 deg"}, {"mitre": "-90 deg"}), profile)
    assert called(course)[1][-1] == "take_bend"
    assert len(called(course)[1]) == 3


def test_a_half_turn_in_an_upright_leg_is_refused_with_its_place(profile: Profile) -> None:
    pipe = round_pipe({"mitre": "90 deg", "roll": "90 deg"}, {"mitre": "-90 deg", "roll": "90 deg"})
    with pytest.raises(UndrivableError, match="one quarter at most") as refused:
        course_along(pipe, profile)
    assert refused.value.path == ("segments", 3)


def test_a_robot_between_bars_does_not_turn(profile: Profile) -> None:
    with pytest.raises(UndrivableError, match="it cannot turn there"):
        course_along(bars({"mitre": "90 deg"}, {"mitre": "-90 deg"}), profile)


def test_it_drives_on_past_square_openings_and_through_reducers(profile: Profile) -> None:
    pipe = round_pipe(
        {"tee": "90 deg", "take": "on", "roll": "90 deg"}, {"reducer": "60 mm", "to": "110 mm"}
    )
    course = course_along(pipe, profile)
    assert course.calls == ()
    assert course.last_m > 2.0


def test_joints_behind_the_start_are_not_passed(profile: Profile) -> None:
    pipe = bars({"mitre": "90 deg"}, {"mitre": "-90 deg"}, start={"at": "2 m"})
    course = course_along(pipe, profile)
    assert [abs(joint.towards_rad) for joint, _ in course.calls] == [pytest.approx(pi)]


def test_a_route_that_ends_in_its_last_joint_is_refused(profile: Profile) -> None:
    pipe = Pipe.model_validate(
        {
            "diameter": "120 mm",
            "segments": [{"straight": "1 m"}, {"mitre": "90 deg"}, {"straight": "400 mm"}],
        }
    )
    with pytest.raises(UsageError, match="no room behind the last joint"):
        course_along(pipe, profile)


def test_a_robot_that_does_not_say_how_it_travels_is_told_so(profile: Profile) -> None:
    still = profile.model_copy(update={"travel": None})
    with pytest.raises(UsageError, match="does not say how it travels"):
        course_along(bars(), still)


def test_the_text_is_a_mission_that_calls_them_in_order(profile: Profile) -> None:
    course = course_along(bars({"mitre": "90 deg"}, {"mitre": "60 deg"}), profile)
    text = mission_along("m", "main", "p", "pirate_ii", course, profile.travel)
    mission = validate(parse_document(text, "m.yaml"), Mission)
    calls = [
        step.call
        for phase in mission.phases.values()
        for step in phase.do
        if isinstance(step, CallStep)
    ]
    assert calls == ["take_bend", "take_bend", "drive_on"]
    assert (mission.route, mission.start) == ("main", "joint_1")
