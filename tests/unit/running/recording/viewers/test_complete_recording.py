"""A run at full speed is made complete for viewers later, as if it had been in real time."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from math import inf
from pathlib import Path
from typing import Any

import pytest
from recording_runs import ROOT, record_as_asked, record_with_viewers
from representative import thorough_but

from pirate_sm.core.errors import RecordingError
from pirate_sm.core.events import Sighting
from pirate_sm.robot.detectors.vision_detector import CameraView, SeenWheels
from pirate_sm.running.recording.csv_files import write_tables
from pirate_sm.running.recording.read.places import recorded_places
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import replay
from pirate_sm.running.recording.viewers import complete_recording
from pirate_sm.running.recording.viewers.complete_recording import write_complete
from pirate_sm.running.wiring import Order
from pirate_sm.views.report.recording_report import known_poses

NEWT = ROOT / "tests" / "robots" / "newt"
RUNS = {
    "sim": Order("mitre_bend"),
    "trace": Order("mitre_bend", backend="trace"),
    "odometry": Order("enter_2d", detector="odometry"),
    "turned parts": Order("enter_3d"),
    "another robot": Order(str(NEWT / "patrol.yaml")),
}


@pytest.fixture(scope="module", params=thorough_but({"another robot"}, RUNS))
def runs(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Recording]:
    """The same run at full speed, made complete from that, and paced."""
    folder: Path = tmp_path_factory.mktemp("runs")
    order = RUNS[request.param]
    record_as_asked(folder / "fast.mcap", order, inf)
    record_with_viewers(folder / "paced.mcap", order)
    fast = read_recording(folder / "fast.mcap")
    with recorded_mission(fast.header) as loaded:
        write_complete(fast, loaded, folder / "completed.mcap")
    return {
        name: read_recording(folder / f"{name}.mcap") for name in ("fast", "completed", "paced")
    }


def for_viewers(recording: Recording) -> dict[str, list[Any]]:
    """Every message for viewers without the wall clock's time, by its topic."""
    found: dict[str, list[Any]] = {}
    for shown in recording.shown():
        found.setdefault(shown.topic, []).append((shown.at_s, timeless(shown.content)))
    return found


def timeless(content: Any) -> Any:
    if isinstance(content, dict):
        return {key: timeless(each) for key, each in content.items() if key != "timestamp"}
    return list(map(timeless, content)) if isinstance(content, list) else content


@pytest.mark.thorough
def test_a_run_at_full_speed_has_no_messages_for_viewers(runs: dict[str, Recording]) -> None:
    assert not runs["fast"].header.viewers
    assert for_viewers(runs["fast"]) == {}
    assert runs["paced"].header.viewers
    assert runs["fast"].content.size < 0.8 * runs["paced"].content.size


def test_what_viewers_are_shown_is_the_same_as_of_a_paced_run(runs: dict[str, Recording]) -> None:
    made, expected = for_viewers(runs["completed"]), for_viewers(runs["paced"])

    assert made.keys() == expected.keys()
    assert {"/tf", "/scene", "/places", "/signals", "/log", "/state"} <= made.keys()
    for topic, messages in expected.items():
        assert made[topic] == messages, topic


def test_everything_else_is_the_same_too(runs: dict[str, Recording]) -> None:
    fast, completed = runs["fast"], runs["completed"]

    assert list(completed.steps()) == list(fast.steps())
    assert completed.header == replace(fast.header, viewers=True)
    assert completed.notices == ()
    with recorded_mission(completed.header) as loaded:
        assert replay(completed, loaded).difference is None


@pytest.mark.thorough
def test_tables_and_reports_do_not_tell_them_apart(
    runs: dict[str, Recording], tmp_path: Path
) -> None:
    texts, poses = {}, {}
    for name, recording in runs.items():
        with recorded_mission(recording.header) as loaded:
            files = write_tables(recording, loaded, tmp_path / name)
            poses[name] = known_poses(recording, loaded)
        texts[name] = {file.name: file.read_text("utf-8") for file in files}
    assert texts["fast"] == texts["paced"] == texts["completed"]
    assert "places.csv" in texts["fast"]
    assert poses["fast"] == poses["paced"] == poses["completed"]


def test_places_are_read_from_the_middle_on(runs: dict[str, Recording]) -> None:
    fast = runs["fast"]
    with recorded_mission(fast.header) as loaded:
        body = loaded.loaded_robot.profile.body
    every = list(recorded_places(fast, body))
    assert list(recorded_places(runs["paced"], body)) == every

    late = list(recorded_places(fast, body, since_s=every[len(every) // 2].at_s))

    assert every[len(every) // 2 :] == late[-len(every[len(every) // 2 :]) :]
    assert all(len(placed.wheels) == len(body.wheels) for placed in every)


@pytest.mark.thorough
def test_what_a_camera_saw_is_kept_and_handed_on(tmp_path: Path) -> None:
    seen = iter(range(1_000_000))

    def view() -> CameraView:
        number = next(seen)
        sighting = Sighting(0.01 * number, (), None, 100.0, 0)
        jpeg = b"jpeg" if number % 7 == 0 else b""
        return CameraView(SeenWheels((0.1 * number,) * 6, ()), sighting, jpeg)

    path = tmp_path / "fast.mcap"
    record_as_asked(path, Order("mitre_bend"), inf, camera=view)
    fast = read_recording(path)
    with recorded_mission(fast.header) as loaded:
        write_complete(fast, loaded, tmp_path / "all.mcap")
    completed = read_recording(tmp_path / "all.mcap")

    for topic in ("/vision", "/camera"):
        messages = [each.data for each in fast.messages(topic)]
        assert messages
        assert messages == [each.data for each in completed.messages(topic)]
    assert json.loads(next(fast.messages("/camera")).data)["format"] == "jpeg"


@pytest.mark.thorough
def test_a_torn_recording_is_completed_up_to_its_end(tmp_path: Path) -> None:
    path = tmp_path / "fast.mcap"
    record_as_asked(path, Order("mitre_bend"), inf)
    last = read_recording(path).content.pieces[-1]
    path.write_bytes(path.read_bytes()[: last.at + last.size])
    torn = read_recording(path)

    with recorded_mission(torn.header) as loaded:
        write_complete(torn, loaded, tmp_path / "all.mcap")
    completed = read_recording(tmp_path / "all.mcap")

    assert not completed.complete
    assert len(completed.notices) == 1
    assert list(completed.steps()) == list(torn.steps())


def test_a_recording_that_has_everything_is_copied(tmp_path: Path) -> None:
    path = tmp_path / "paced.mcap"
    record_with_viewers(path, RUNS["trace"])
    paced = read_recording(path)

    with recorded_mission(paced.header) as loaded:
        write_complete(paced, loaded, tmp_path / "all.mcap")

    assert (tmp_path / "all.mcap").read_bytes() == path.read_bytes()


@pytest.mark.thorough
def test_a_message_that_cannot_be_made_leaves_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, place = tmp_path / "fast.mcap", tmp_path / "all.mcap"
    record_as_asked(path, RUNS["trace"], inf)
    fast = read_recording(path)
    monkeypatch.setattr(complete_recording.ViewerMessages, "sample", lambda *_: 1 / 0)

    with (
        recorded_mission(fast.header) as loaded,
        pytest.raises(RecordingError, match="ZeroDivisionError"),
    ):
        write_complete(fast, loaded, place)

    assert not place.exists()


def test_times_of_samples_do_not_depend_on_the_pieces(runs: dict[str, Recording]) -> None:
    times = [shown.at_s for shown in runs["completed"].shown("/signals")]
    steps = {round(step.at_s, 9) for step in runs["fast"].steps()}

    assert times == sorted(times)
    assert {round(at_s, 9) for at_s in times} <= steps
    assert all(after >= before + 0.1 - 1e-9 for before, after in pairwise(times))
    assert len(times) > 1
