"""The camera's place is surveyed; places that were measured wrongly are named."""

from __future__ import annotations

import numpy as np
import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.robot.vision.calibration import KnownPlace, Survey, known_points, known_tags, survey

from .small_setup import POSE, camera, drawn, scene

EYE, PICTURES = drawn()
LENS = EYE.view.lens


@pytest.fixture(scope="module")
def known() -> dict[str, KnownPlace]:
    return known_tags(EYE.camera, PICTURES.picture(scene(), 0))


def test_the_place_is_found_from_the_tags_in_a_picture(known: dict[str, KnownPlace]) -> None:
    found = survey(LENS, known)

    assert list(known) == ["tag 10", "tag 11", "tag 12", "tag 13", "tag 14"]
    assert isinstance(found, Survey)
    assert found.pose.at == pytest.approx(POSE["at"], abs=2e-3)
    assert found.rms_px < 1.0
    assert found.each_px.keys() == known.keys()


def test_two_exchanged_tags_are_named(known: dict[str, KnownPlace]) -> None:
    wrong = dict(known)
    one, other = known["tag 10"], known["tag 12"]
    wrong["tag 10"] = KnownPlace(other.points, one.pixels)
    wrong["tag 12"] = KnownPlace(one.points, other.pixels)

    said = str(survey(LENS, wrong))

    assert "more than 3 px" in said
    assert "tag 10 and tag 12 are exchanged" in said


def test_a_tag_that_is_30_mm_off_is_named(known: dict[str, KnownPlace]) -> None:
    at = known["tag 11"]
    wrong = known | {"tag 11": KnownPlace(at.points + np.array([0.03, 0.0, 0.0]), at.pixels)}

    assert "measure tag 11 again" in str(survey(LENS, wrong))


def test_a_tag_that_a_picture_shows_twice_is_named(known: dict[str, KnownPlace]) -> None:
    frame = PICTURES.picture(scene(), 0).copy()
    corners = known["tag 10"].pixels
    (left, top), (right, bottom) = corners.min(axis=0) - 12, corners.max(axis=0) + 12
    tag = frame[int(top) : int(bottom), int(left) : int(right)].copy()
    middle = np.array(frame.shape[:2]) // 2
    frame[middle[0] : middle[0] + tag.shape[0], middle[1] : middle[1] + tag.shape[1]] = tag

    with pytest.raises(UsageError, match="shows tag 10 more than once"):
        known_tags(EYE.camera, frame)


def test_three_tags_are_too_few(known: dict[str, KnownPlace]) -> None:
    few = {name: known[name] for name in ("tag 10", "tag 11", "tag 12")}

    said = survey(LENS, few)
    assert said == (
        "of the setup's known places tag 10, tag 11, tag 12 is seen: at least 4 are needed"
    )


def test_the_points_of_a_file_are_known_by_their_numbers() -> None:
    points = [{"at": (0.1, 0.2, 0.0), "seen": (10.0, 20.0)}]
    setup = camera().setup.model_validate({"points": points, "pose": POSE})

    known = known_points(camera().model_copy(update={"setup": setup}))

    assert list(known) == ["point 1"]
    assert known["point 1"].pixels.tolist() == [[10.0, 20.0]]


def test_points_in_a_line_are_refused_although_they_fit() -> None:
    points = np.array([(x / 10 - 0.2, 0.002 * (x % 2), 0.0) for x in range(6)])
    pixels = EYE.view.project(points)
    known = {
        f"point {n}": KnownPlace(points[n : n + 1], pixels[n : n + 1]) for n in range(len(points))
    }

    assert "nearly in a line" in str(survey(LENS, known))
