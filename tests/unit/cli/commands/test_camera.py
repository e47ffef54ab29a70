"""`pirate camera`: what it prints, what it refuses, what it writes into a camera's file."""

from __future__ import annotations

import itertools
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pirate_sm.cli.commands import camera
from pirate_sm.core import library
from pirate_sm.robot.camera_file import load_camera
from pirate_sm.robot.vision.opencv import cv2
from pirate_sm.robot.vision.seeing import eye_of
from pirate_sm.robot.vision.synthetic import ShownLink, ShownScene, SyntheticPictures
from tests.unit.robot.vision.rendered_boards import RenderedLens

ROOT = Path(__file__).resolve().parents[4]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def mine(here: Path) -> Path:
    """A camera of one's own, with pictures in a folder and a wrong pose."""
    text = (ROOT / "cameras" / "setup_3.yaml").read_text("utf-8")
    text = text.replace("setup_3", "mine").replace("at: [-180 mm,", "at: [-100 mm,")
    text = text.replace("device: 0", "images: seen/*.png").replace(", codec: MJPG", "")
    (here / "cameras").mkdir()
    path = here / "cameras" / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def seen(folder: Path, picture: NDArray[np.uint8]) -> None:
    (folder / "seen").mkdir()
    assert cv2.imwrite(str(folder / "seen" / "0.png"), picture)


@pytest.fixture(scope="module")
def picture() -> NDArray[np.uint8]:
    """The robot's first module in the synthetic camera."""
    camera, _ = load_camera(library.find_camera("synthetic"))
    link = ShownLink("bend_1", (-0.2, -0.06), (-0.29, -0.06))
    shown = ShownScene(
        (link,), (((-0.9, 0.0), (0.0, 0.0)), ((-0.9, -0.12), (0.0, -0.12))), 0.024, 0.012
    )
    return SyntheticPictures(camera, eye_of(camera).view, camera.source.synthetic).picture(shown, 0)


@pytest.mark.thorough
def test_a_synthetic_camera_can_be_tried_before_it_is_built(pirate: Any, here: Path) -> None:
    result = pirate("camera", "look", "synthetic", "-o", "found.png")

    assert (result.exit_code, result.stderr) == (0, "")
    lines = result.stdout.splitlines()
    assert lines[0].startswith("  bend_1       x  -28")
    assert "5 of 5 marks of the robot are seen" in lines
    assert cv2.imread("found.png").shape == (1080, 1920, 3)


@pytest.mark.thorough
def test_a_survey_is_written_into_the_file_and_then_used(
    pirate: Any, mine: Path, picture: NDArray[np.uint8]
) -> None:
    seen(mine.parent, picture)
    before = pirate("camera", "look", "mine")
    good = mine.read_text("utf-8")
    mine.write_text(re.sub(r"turn: \[.*?\]", "turn: [0 deg, 0 deg, 0 deg]", good), "utf-8")
    assert mine.read_text("utf-8") != good
    up = pirate("camera", "look", "mine")
    surveyed = pirate("camera", "survey", "mine")
    after = pirate("camera", "look", "mine")

    assert (up.exit_code, up.stderr) == (1, "")
    assert surveyed.exit_code == 0, surveyed.output
    assert "8 known places, off by 0." in surveyed.stdout
    assert load_camera(mine)[0].setup.pose.at == pytest.approx((-0.18, 0.18, 0.55), abs=2e-3)
    assert "# x along the first leg" in mine.read_text("utf-8")
    assert "1 of 5 marks" in after.stdout
    off = [float(r.stdout.split("tags are ")[1].split(" px")[0]) for r in (before, after)]
    assert off[0] > 3
    assert off[1] < 1


@pytest.mark.thorough
def test_an_impossible_survey_writes_nothing(
    pirate: Any, mine: Path, picture: NDArray[np.uint8]
) -> None:
    seen(mine.parent, picture)
    text = mine.read_text("utf-8")
    wrong = text.replace('"10":', '"x":').replace('"15":', '"10":').replace('"x":', '"15":')
    mine.write_text(wrong, encoding="utf-8")

    result = pirate("camera", "survey", "mine")

    assert result.exit_code == 1
    assert "nothing is written" in result.stdout
    assert "tag 10 and tag 15 are exchanged" in result.stdout
    assert mine.read_text("utf-8") == wrong


def test_pictures_without_boards_measure_nothing(pirate: Any, mine: Path) -> None:
    seen(mine.parent, np.full((120, 160, 3), 90, np.uint8))
    before = mine.read_text("utf-8").replace("[1920, 1080]", "[160, 120]")
    mine.write_text(before, encoding="utf-8")

    result = pirate("camera", "calibrate", "mine")

    assert result.exit_code == 1
    assert "0 sharp boards of 9 × 6 corners were found, at least 15" in result.stdout
    assert mine.read_text("utf-8") == before


@pytest.mark.thorough  # it fits a lens several times
def test_a_board_in_a_bad_picture_is_left_out_by_the_name_of_its_file(
    pirate: Any, mine: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (mine.parent / "seen").mkdir()
    mine.write_text(mine.read_text("utf-8").replace("[1920, 1080]", "[480, 360]"), "utf-8")
    lens = RenderedLens("fisheye", 120.0, (-0.02, 0.0))
    for number, picture in enumerate(lens.pictures()):
        if number == 7:  # taken while the board was moved: every column is at another height
            for x in range(480):
                picture[:, x] = np.roll(picture[:, x], round(5 * np.sin(x / 25)))
        assert cv2.imwrite(str(mine.parent / "seen" / f"{number:02}.png"), picture)
    hours = itertools.count(0.0, 3600.0)
    monkeypatch.setattr(camera.time, "monotonic", lambda: next(hours))

    result = pirate("camera", "calibrate", "mine", "--seconds", "1")

    assert result.exit_code == 0, result.output
    used, left_out, _, _ = result.stdout.splitlines()
    assert used.startswith("19 boards, off by 0.")
    assert left_out.startswith("seen/07.png is left out: its corners are off by ")
    assert load_camera(mine)[0].lens.f == pytest.approx([lens.focal_px] * 2, rel=5e-3)


def test_sheets_are_written_for_the_board_the_setup_and_the_robot(pirate: Any, here: Path) -> None:
    result = pirate("camera", "print", "setup_3", "-o", "sheets")

    assert result.exit_code == 0
    assert sorted(path.name for path in (here / "sheets").iterdir()) == [
        "setup_3_board.svg",
        "setup_3_robot_1.svg",
        "setup_3_setup_1.svg",
    ]
    assert pirate("camera", "print", "setup_3", "-o", "sheets").exit_code == 0


def test_sheets_are_not_written_over_somebodys_work(pirate: Any, here: Path) -> None:
    (here / "setup_3_board.svg").write_text("<svg>mine</svg>", "utf-8")

    result = pirate("camera", "print", "setup_3")

    assert result.exit_code == 2
    assert "'setup_3_board.svg' exists and was not written by this program" in result.stderr
    assert [path.name for path in here.glob("setup_3_*.svg")] == ["setup_3_board.svg"]
    assert pirate("camera", "print", "setup_3", "--overwrite").exit_code == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["look", "nothing"], "there is no camera 'nothing'"),
        (["look", "setup_3", "--images", "*.png"], "there are no pictures '*.png'"),
        pytest.param(
            ["look", "synthetic", "-o", "a.gif"],
            "ends in .png or .jpg",
            marks=pytest.mark.thorough,
        ),
        (["survey", "setup_3"], "'setup_3' is a shipped camera: copy"),
        (["calibrate", "synthetic"], "'synthetic' is a shipped camera: copy"),
        (["calibrate", "synthetic", "--no-write"], "no lens to measure"),
        (["survey", "synthetic", "--no-write"], "hangs where its file says"),
        (["survey", "setup_1", "--no-write"], "neither tags nor points"),
        (["print", "setup_3", "--board", "9 by 6"], "corners inside of it, such as 9x6"),
        (["print", "setup_3", "--square", "0 mm"], "a length above zero"),
    ],
    ids=lambda each: each if isinstance(each, str) else " ".join(each),
)
def test_what_cannot_be_done_is_refused(
    pirate: Any, here: Path, arguments: list[str], said: str
) -> None:
    result = pirate("camera", *arguments)

    assert result.exit_code == 2
    assert said in result.stderr


@pytest.mark.thorough
def test_without_opencv_it_says_what_to_install() -> None:
    code = (
        "import sys; sys.modules['cv2'] = None; sys.modules['numpy'] = None;"
        "from pirate_sm.cli.entry import main; main()"
    )
    command = [sys.executable, "-c", code, "camera", "look", "synthetic"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)

    assert done.returncode == 2
    assert done.stderr.endswith("pip install 'pirate-sm[vision]'\n")
    assert "Traceback" not in done.stderr
