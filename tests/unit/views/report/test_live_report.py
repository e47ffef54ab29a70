"""A page during a run, after it and of a recording is made by the same code, and is the same."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from pirate_sm.running.recording.forecast_file import counted, forecast_of, read_forecast
from pirate_sm.running.recording.read import growing
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.signal_bands import signal_bands
from pirate_sm.views.report import live_report
from pirate_sm.views.report.changes import changes
from pirate_sm.views.report.contents import Report
from pirate_sm.views.report.expectations import with_expectations
from pirate_sm.views.report.expected_signals import run_extremes
from pirate_sm.views.report.live_report import Edition, LiveReport
from pirate_sm.views.report.recording_report import RunContents
from pirate_sm.views.report.report_page import fragments, report_json
from tests.representative import thorough_but

from .test_changes import applied


def followed(
    path: Path, source: Path, *, steps: int = 6, forecast: Path | None = None
) -> list[Edition]:
    """The editions of a page while the file grows in so many steps."""
    pieces = read_recording(source).content.pieces
    whole, marks = source.read_bytes(), [piece.at + piece.size for piece in pieces]
    lengths = [*marks[:: max(1, len(marks) // steps)], len(whole)]
    path.write_bytes(whole[: lengths.pop(0)])
    found: list[Edition] = []
    problems: list[Exception] = []
    ended = threading.Event()

    def publish(edition: Edition) -> None:
        found.append(edition)
        if lengths:
            path.write_bytes(whole[: lengths.pop(0)])
        elif edition.report.outcome != "running":
            ended.set()

    def failed(error: Exception) -> None:
        problems.append(error)
        ended.set()

    live = LiveReport(path, publish, failed, forecast)
    live.start()
    assert ended.wait(60.0)
    live.close()
    assert not problems
    return found


@pytest.fixture(autouse=True)
def no_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    """A computer that is busy with other tests takes nothing for the end of a run."""
    monkeypatch.setattr(growing, "QUIET_S", 1e9)
    monkeypatch.setattr(live_report, "POLL_S", 0.001)


@pytest.mark.parametrize("name", thorough_but({"patrol"}, ("patrol", "dead", "bend")))
def test_the_last_edition_of_a_page_is_the_report_of_its_recording(
    recording: Callable[[str], Path], report: Callable[[str], Report], tmp_path: Path, name: str
) -> None:
    editions = followed(tmp_path / "run.mcap", recording(name))
    last, whole = editions[-1], replace(report(name), recording="")

    assert last.data == report_json(whole)
    assert last.parts == fragments(whole)
    assert [each.version for each in editions] == list(range(len(editions)))
    assert {each.report.outcome for each in editions[:-1]} <= {"running", "failed", "succeeded"}
    assert editions[0].report.outcome == "running"
    assert editions[0].report.duration_s < last.report.duration_s


def test_a_page_under_way_has_what_earlier_runs_let_expect_so_far(
    recording: Callable[[str], Path], report: Callable[[str], Report], tmp_path: Path
) -> None:
    found = counted(read_recording(recording("patrol")))
    signals = signal_bands([run_extremes(report("patrol"))] * 40)
    forecast = forecast_of(found.header, [found.visits] * 40).model_copy(
        update={"signals": signals}
    )
    file = tmp_path / "times.yaml"
    file.write_text(forecast.text(), "utf-8")
    editions = followed(tmp_path / "run.mcap", recording("patrol"), forecast=file)

    whole = with_expectations(replace(report("patrol"), recording=""), read_forecast(file))
    assert editions[-1].data == report_json(whole)
    middle = editions[len(editions) // 2]
    bands = [each.band for chart in middle.report.charts for each in chart.series if each.band]
    assert bands
    assert max(band.times_s[-1] for band in bands) <= middle.report.duration_s


def test_a_page_is_not_compared_with_runs_of_another_mission(
    recording: Callable[[str], Path], tmp_path: Path
) -> None:
    file, problems = tmp_path / "times.yaml", list[Exception]()
    other = counted(read_recording(recording("trace")))
    file.write_text(forecast_of(other.header, [other.visits]).text(), "utf-8")
    ended = threading.Event()

    def failed(error: Exception) -> None:
        problems.append(error)
        ended.set()

    live = LiveReport(recording("patrol"), lambda _: None, failed, file)
    live.start()
    assert ended.wait(60.0)
    live.close()
    assert "is of the mission mitre_bend, not patrol" in str(problems[0])


def test_a_page_that_takes_each_change_has_the_newest_data(
    recording: Callable[[str], Path], tmp_path: Path
) -> None:
    editions = followed(tmp_path / "run.mcap", recording("patrol"))
    has = editions[0].data

    for before, after in pairwise(editions):
        has = applied(has, [*changes({"data": before.data}, {"data": after.data})])
        assert has == after.data


def test_a_run_that_was_killed_is_told_as_unfinished(
    recording: Callable[[str], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(growing, "QUIET_S", -1.0)
    whole = recording("dead").read_bytes()
    (tmp_path / "run.mcap").write_bytes(whole[: len(whole) // 2])
    found = first_told(tmp_path / "run.mcap")

    assert isinstance(found, Edition)
    assert found.report.outcome == "unfinished"
    assert "the recording ends early" in found.parts["words"].lower()


def first_told(path: Path) -> Edition | Exception:
    """What is first told of a recording: an edition, or why there is none."""
    told: list[Edition | Exception] = []
    heard = threading.Event()

    def hear(it: Edition | Exception) -> None:
        told.append(it)
        heard.set()

    live = LiveReport(path, hear, hear)
    live.start()
    assert heard.wait(60.0)
    live.close()
    return told[0]


def test_a_run_that_was_killed_as_it_began_has_a_page_too(
    recording: Callable[[str], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(growing, "QUIET_S", -1.0)
    source = recording("patrol")
    header_ends = read_recording(source).content.pieces[0].at
    (tmp_path / "run.mcap").write_bytes(source.read_bytes()[:header_ends])

    found = first_told(tmp_path / "run.mcap")

    assert isinstance(found, Edition)
    assert found.report.outcome == "unfinished"
    assert "Of the run itself nothing is in the recording" in found.parts["words"]


def damaged(source: Path, path: Path, place: int) -> list[bytes]:
    """Write a recording with one wrong byte in this piece; return it up to there, and whole."""
    pieces = read_recording(source).content.pieces
    whole = bytearray(source.read_bytes())
    whole[pieces[place].at + pieces[place].size // 2] ^= 0xFF
    path.write_bytes(whole)
    return [bytes(whole[: pieces[place - 1].at + pieces[place - 1].size]), bytes(whole)]


def test_of_a_damaged_recording_it_is_told_why_there_is_no_page(
    recording: Callable[[str], Path], tmp_path: Path
) -> None:
    path = tmp_path / "run.mcap"
    damaged(recording("patrol"), path, 3)

    assert "is damaged" in str(first_told(path))


@pytest.mark.parametrize("is_bug", [False, True])
def test_damage_in_mid_run_ends_the_page_with_what_was_read_before(
    recording: Callable[[str], Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    is_bug: bool,
) -> None:
    path = tmp_path / "run.mcap"
    before, whole = damaged(recording("patrol"), path, 3)
    path.write_bytes(before)
    found: list[Edition] = []
    over = threading.Event()

    def publish(edition: Edition) -> None:
        found.append(edition)
        if is_bug:
            monkeypatch.setattr(RunContents, "take", lambda *_: {}["no such key"])
        path.write_bytes(recording("patrol").read_bytes() if is_bug else whole)
        if edition.report.outcome != "running":
            over.set()

    live = LiveReport(path, publish, lambda _: over.set())
    live.start()
    assert over.wait(60.0)
    live.close()

    last = found[-1]
    assert (found[0].data["running"], last.data["running"]) == (True, False)
    assert last.version == len(found) - 1
    assert last.report.duration_s == found[0].report.duration_s
    warning = last.report.warnings[0]
    assert warning.startswith("The page ends here, with what could be read: ")
    assert ("an internal error, KeyError" if is_bug else "is damaged") in warning


def test_closing_does_not_wait_for_the_rest_of_the_recording(
    recording: Callable[[str], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken: list[object] = []
    began = threading.Event()

    def take(_: RunContents, again: object) -> None:
        taken.append(again)
        began.set()
        assert live._closing.wait(60.0)

    monkeypatch.setattr(RunContents, "take", take)
    found: list[object] = []
    live = LiveReport(recording("patrol"), found.append, found.append)
    live.start()
    assert began.wait(60.0)

    live.close()

    assert len(taken) == 1
    assert found == []
