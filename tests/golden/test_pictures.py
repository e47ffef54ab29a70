"""The pictures of the documents are current. `make pictures` takes them anew."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from pirate_sm.robot.vision.opencv import cv2
from website.bend import PICTURE, drawn
from website.camera_pictures import MOMENTS, seen
from website.editor_pictures import made_of_answers
from website.margins_picture import MARGINS, made_of_margins
from website.pictures import MADE_OF, PICTURES, SHOTS, made_of, page_of

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.thorough
@pytest.mark.parametrize("name", SHOTS)
def test_a_picture_of_a_page_was_taken_of_the_page_as_it_is(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    known = json.loads(MADE_OF.read_text("utf-8"))

    assert made_of(page_of(SHOTS[name], tmp_path)) == known[name], "another page: make pictures"


def test_the_picture_of_margins_was_taken_of_what_its_page_says() -> None:
    known = json.loads(MADE_OF.read_text("utf-8"))
    assert made_of_margins() == known[MARGINS], "other results or another drawing: make pictures"


@pytest.mark.thorough
def test_a_picture_of_an_editor_was_taken_of_what_the_server_answers(tmp_path: Path) -> None:
    pytest.importorskip("pygls")
    known = json.loads(MADE_OF.read_text("utf-8"))

    assert made_of_answers(tmp_path).items() <= known.items(), "other answers: make pictures"


@pytest.mark.thorough
@pytest.mark.parametrize("name", MOMENTS)
def test_a_picture_of_a_camera_shows_what_it_sees(name: str) -> None:
    stored, found = cv2.imread(str(PICTURES / name)), seen(MOMENTS[name])

    apart = np.abs(stored.astype(float) - found.astype(float))
    assert apart.mean() < 2.0, "the camera sees something else: make pictures"  # JPEG: below 1


@pytest.mark.thorough
def test_the_animated_bend_is_the_simulators() -> None:
    if os.environ.get("GOLDEN") == "write":
        PICTURE.write_text(drawn(), encoding="utf-8")
    stored = PICTURE.read_text("utf-8")

    assert stored == drawn()
    assert len(stored) < 100_000
    assert "http" not in stored.replace("http://www.w3.org/2000/svg", "")


def test_every_picture_that_is_no_drawing_is_taken_by_a_command() -> None:
    taken = {file.name for file in PICTURES.iterdir() if file.suffix not in (".svg", ".json")}

    assert taken == SHOTS.keys() | MOMENTS.keys() | {MARGINS}
