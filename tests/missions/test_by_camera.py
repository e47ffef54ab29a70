"""Missions by what a synthetic camera sees, from pixels to words, and what is kept of it."""

from __future__ import annotations

import subprocess
import sys
from base64 import b64decode
from math import isnan
from pathlib import Path

import pytest

import pirate_sm
from pirate_sm import LoadError, UsageError
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.views.report.film_strip import seen_words
from pirate_sm.views.report.recording_report import report_of

ROOT = Path(__file__).resolve().parents[2]
SMALL = ROOT / "tests" / "cameras" / "small.yaml"

WITHOUT_OPENCV = """
import sys
sys.modules["cv2"] = None
from pirate_sm.cli.entry import commands
commands(["replay", sys.argv[1]], standalone_mode=False)
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("seen") / "run.mcap"
    run = pirate_sm.run("mitre_bend", detector=f"vision:{SMALL}", seed=2, record=path)
    assert run.outcome == "succeeded", run.message
    return path


@pytest.mark.thorough
def test_one_seed_gives_one_run(recording: Path) -> None:
    again = pirate_sm.run("mitre_bend", detector=f"vision:{SMALL}", seed=2)

    assert again.duration_s == pirate_sm.read(recording).duration_s


@pytest.mark.thorough
def test_a_run_is_replayed_where_opencv_is_not_installed(recording: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_OPENCV, str(recording)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip

    assert done.returncode == 0, done.stderr
    assert "replayed identically" in done.stdout


@pytest.mark.thorough
def test_places_and_pictures_are_recorded(recording: Path) -> None:
    places = [shown.content for shown in read_recording(recording).shown("/vision")]
    pictures = list(read_recording(recording).shown("/camera"))

    assert all(0.0 < each["age_s"] < 0.5 for each in places)
    assert any("wheel_1_m" in each for each in places)
    assert all(b64decode(each.content["data"]).startswith(b"\xff\xd8") for each in pictures)
    lasted_s = pictures[-1].at_s - pictures[0].at_s
    assert lasted_s <= len(pictures) <= 2.2 * lasted_s + 3


@pytest.mark.thorough
def test_the_report_shows_what_was_seen_at_each_word(recording: Path) -> None:
    report = report_of(read_recording(recording))

    assert list(dict.fromkeys(photo.word for photo in report.photos)) == ["close", "in", "past"]
    page = seen_words(report.photos)
    assert page.count("data:image/jpeg;base64,") == len(report.photos)


@pytest.mark.thorough
def test_the_camera_measures_the_speed_against_which_slip_is_judged(recording: Path) -> None:
    run = pirate_sm.read(recording)
    speeds = [each for each in run.signals["ruler_m_per_s"] if not isnan(each)]

    assert max(speeds) == pytest.approx(0.15, abs=0.02)
    assert len(speeds) > len(run.signals["ruler_m_per_s"]) / 10


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (("on: rotation", "on: tail"), "pirate_ii has no module 'tail'"),
        (("speed: ruler", "speed: rulr"), "pirate_ii has no outside signal 'rulr'"),
    ],
)
def test_a_camera_that_does_not_fit_the_robot_is_refused(
    tmp_path: Path, change: tuple[str, str], why: str
) -> None:
    camera = tmp_path / "camera.yaml"
    camera.write_text(SMALL.read_text("utf-8").replace(*change), "utf-8")

    with pytest.raises(LoadError, match=why):
        pirate_sm.run("mitre_bend", detector=f"vision:{camera}")


def test_what_is_missing_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UsageError, match=r"name a camera, vision:NAME; there are .*setup_3"):
        pirate_sm.run("mitre_bend", detector="vision")
    with pytest.raises(UsageError, match="no camera 'sythetic'"):
        pirate_sm.run("mitre_bend", detector="vision:sythetic")
    broken = tmp_path / "camera.yaml"
    broken.write_text("format: 1\ncamera: broken\n", "utf-8")
    with pytest.raises(LoadError):
        pirate_sm.run("mitre_bend", detector=f"vision:{broken}")
    for name in [name for name in sys.modules if name.startswith("pirate_sm.robot.vision")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(UsageError, match="pip install 'pirate-sm\\[vision\\]'"):
        pirate_sm.run("mitre_bend", detector=f"vision:{SMALL}")
