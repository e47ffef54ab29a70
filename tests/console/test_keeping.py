"""Which recordings a session leaves behind."""

from __future__ import annotations

from contextlib import AbstractContextManager
from csv import DictReader
from datetime import datetime
from pathlib import Path

import pytest
from representative import thorough_but

from pirate_sm.cli.run_recording import RecordingOptions, recorded
from pirate_sm.cli.settings import RUNS_VARIABLE
from pirate_sm.core.events import GoTo, OperatorCommand
from pirate_sm.running.recording.compare import compared_run
from pirate_sm.running.recording.csv_files import write_tables
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import replay
from pirate_sm.running.recording.write.recording_file import NS_PER_S, RecordingFile
from pirate_sm.running.wiring import Prepared
from pirate_sm.running.wiring.run_recorder import Kept
from pirate_sm.views.console.recording_viewer import recorded_snapshots
from pirate_sm.views.report.recording_report import report_of
from pirate_sm.views.report.run_list import listed

from .driving import Operator, operator, played, with_mission


@pytest.fixture
def runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(RUNS_VARIABLE, str(tmp_path))
    return tmp_path


def keep(prepared: Prepared) -> AbstractContextManager[Kept]:
    return recorded(prepared, RecordingOptions(), 1.0)


async def leave(me: Operator) -> None:
    me.clock.free()
    me.session.quit()
    assert me.session.join(10.0)


def test_a_run_in_which_nothing_was_asked_for_leaves_no_recording(runs: Path) -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace"), keep=keep) as me:
            me.wait(1.0)
            assert list(runs.glob("*.mcap"))
            await leave(me)

    played(story)
    assert not list(runs.iterdir())


def test_after_a_stop_the_run_that_was_begun_is_left_and_not_the_one_that_waits(
    runs: Path,
) -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace"), keep=keep) as me:
            await me.look()
            await me.press("R")
            me.until(lambda: me.states[2] == "DoubleClamped")
            await me.press("space")
            me.until(lambda: any("ended interrupted: stopped" in each for each in me.told()))
            me.until(lambda: me.latest.state.mission.paused)
            await leave(me)

    played(story)
    (left,) = runs.glob("*.mcap")
    assert read_recording(left).complete


async def clamp_in_a_second_run(me: Operator) -> None:
    """The first run is stopped after 20 s; by hand the robot clamps in the next one."""
    me.wait(20.0)
    me.session.stop()
    me.wait(1.0)
    me.until(lambda: me.latest.state is not None and me.latest.state.look is None)
    me.session.give_event(OperatorCommand("ClampFront"))
    me.until(lambda: me.states[2] == "FrontClampedRearRelaxed")
    await leave(me)


def test_the_duration_of_a_later_run_is_its_own(runs: Path) -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace"), keep=keep) as me:
            await clamp_in_a_second_run(me)

    played(story)
    (left,) = runs.glob("*.mcap")
    recording = read_recording(left)
    (*_, last) = recording.steps()
    assert last.at_s > 20.0
    assert 0.0 < listed(recording, "").duration_s < 10.0


def as_before(file: RecordingFile, at_s: float) -> int:
    """How the messages of a recording once got their times."""
    return file._zero_ns + round(at_s * NS_PER_S)


@pytest.fixture(scope="module", params=thorough_but(["now"], ["now", "before"]))
def later(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The recording of a run that began 20 s after its session, as it is made now or once was."""
    folder = tmp_path_factory.mktemp("runs")

    async def story() -> None:
        async with operator(with_mission("mitre_bend"), keep=keep) as me:
            await clamp_in_a_second_run(me)

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(RUNS_VARIABLE, str(folder))
        if request.param == "before":
            patch.setattr(RecordingFile, "time_ns", as_before)
        played(story)
    (left,) = folder.glob("*.mcap")
    return left


@pytest.mark.thorough
def test_the_report_of_a_later_run_counts_time_from_its_own_start(later: Path) -> None:
    report = report_of(read_recording(later))

    assert report.duration_s == pytest.approx(listed(read_recording(later), "").duration_s)
    assert 0.0 < report.duration_s < 10.0
    spans = [span for lane in report.lanes for span in lane.spans]
    assert min(span.start_s for span in spans) == 0.0
    assert max(span.end_s for span in spans) <= report.duration_s
    for chart in report.charts:
        assert all(0.0 <= at_s <= report.duration_s for s in chart.series for at_s in s.times_s)
    assert report.scene is not None
    assert 0.0 <= report.scene.times_s[0] < 1.0
    assert report.scene.times_s[-1] <= report.duration_s
    assert report.story[-1].at_s == report.duration_s


def test_the_tables_of_a_later_run_count_time_from_its_own_start(
    later: Path, tmp_path: Path
) -> None:
    recording = read_recording(later)
    with recorded_mission(recording.header) as loaded:
        write_tables(recording, loaded, tmp_path / "tables")

    for table in (tmp_path / "tables").glob("*.csv"):
        with table.open(encoding="utf-8", newline="") as file:
            times = [float(row["time_s"]) for row in DictReader(file)]
        assert all(0.0 <= at_s < 10.0 for at_s in times), table.name
    with (tmp_path / "tables" / "signals.csv").open(encoding="utf-8", newline="") as file:
        assert float(next(DictReader(file))["time_s"]) < 0.5


def test_a_later_run_is_replayed_and_scrubbed_from_its_own_start(later: Path) -> None:
    recording = read_recording(later)
    with recorded_mission(recording.header) as loaded:
        again = replay(recording, loaded)
        course = compared_run(recording, loaded)
    assert again.difference is None
    assert 0.0 < again.until_s < 10.0
    assert course.until_s == again.until_s == recording.until_s

    reel = recorded_snapshots(recording)
    assert reel.length_s == recording.until_s
    first, last = reel.at(0.0), reel.at(reel.length_s)
    assert first.now_s < 0.5
    assert last.now_s == pytest.approx(reel.length_s)
    assert all(0.0 <= told.now_s < 10.0 for told in last.story.recent)
    assert last.truth is not None


@pytest.mark.parametrize("later", ["now"], indirect=True)
def test_viewers_see_a_later_run_when_it_was(later: Path) -> None:
    recording = read_recording(later)
    began_ns = round(datetime.fromisoformat(recording.header.began).timestamp() * 1e9)

    assert recording.content.pieces[0].start_ns == began_ns


@pytest.mark.thorough
def test_a_mission_that_is_chosen_is_not_recorded_with_the_options_of_the_one_before(
    runs: Path,
) -> None:
    async def story() -> None:
        driving = dict.fromkeys(("FrontWheelsState", "RearWheelsState"), "DrivingForward")
        states = {"BendingState": "DoubleClamped", **driving}
        first = with_mission("mitre_bend", "trace", start_phase="prepare", states=states)
        async with operator(first, keep=keep) as me:
            await me.look()
            await me.press("R")
            me.until(lambda: me.latest.story.spent_s)
            assert next(iter(me.latest.story.spent_s)) == "prepare"
            me.wait(1.0)
            await me.press("M")
            await me.look()
            await me.choose("enter_2d")
            assert me.latest.scene.mission == "enter_2d"
            me.session.give_event(OperatorCommand("ToggleLighting"))
            me.wait(1.0)
            await leave(me)

    played(story)
    for each in sorted(runs.glob("*.mcap")):
        recording = read_recording(each)
        asked = "prepare" if recording.header.mission == "mitre_bend" else None
        assert recording.header.options.get("start_phase") == asked
        with recorded_mission(recording.header) as loaded:
            assert replay(recording, loaded).difference is None
    assert {read_recording(each).header.mission for each in runs.glob("*.mcap")} == {
        "mitre_bend",
        "enter_2d",
    }


def test_a_series_of_commands_is_something_that_was_asked_for(runs: Path) -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace"), keep=keep) as me:
            me.session.give(("ClampFront",), GoTo("prepare", ()))
            me.until(lambda: me.states[2] == "FrontClampedRearRelaxed")
            await leave(me)

    played(story)
    assert len(list(runs.glob("*.mcap"))) == 1
