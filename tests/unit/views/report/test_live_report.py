"""A page during a run, after it and of a recording is made by the same code, and is the same."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from pirate_sm.running.recording.read import growing
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.views.report import live_report
from pirate_sm.views.report.changes import changes
from pirate_sm.views.report.contents import Report
from pirate_sm.views.report.live_report import Edition, LiveReport
from pirate_sm.views.report.report_page import fragments, report_json
from tests.representative import thorough_but

from .test_changes import applied


def followed(path: Path, source: Path, *, steps: int = 6) -> list[Edition]:
    """The editions of a page while the file grows in so many steps."""
    pieces = read_recording(source).content.pieces
    whole, marks = source.read_bytes(), [piece.at + piece.size for piece in pieces]
    lengths = [*marks[:: max(1, len(marks) // steps)], len(whole)]
    path.write_bytes(whole[: lengths.pop(0)])
    found: list[Edition] = []
    ended = threading.Event()

    def publish(edition: Edition) -> None:
        found.append(edition)
        if lengths:
            path.write_bytes(whole[: lengths.pop(0)])
        elif edition.report.outcome != "running":
            ended.set()

    live = LiveReport(path, publish)
    live.start()
    assert ended.wait(60.0), live.problem
    live.close()
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
    found: list[Edition] = []
    published = threading.Event()
    live = LiveReport(tmp_path / "run.mcap", lambda each: (found.append(each), published.set()))

    live.start()
    assert published.wait(60.0)
    live.close()

    assert found[0].report.outcome == "unfinished"
    assert "the recording ends early" in found[0].parts["words"].lower()
