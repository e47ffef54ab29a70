"""A list of runs says of each what it was and how it ended, and nothing that it says is markup."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.views.report.run_list import ListedRun, index_html, listed, unreadable

Recordings = Callable[[str], Path]
RUN = ListedRun(
    name="a.mcap", outcome="failed", message="why", link="a.html", mission="m", robot="r",
    backend="sim", began="2026-01-02T03:04:05+00:00", seed=7, conditions=("dead", "x = 3 s"),
    duration_s=61.5, faults={"wheel.dead": 2, "robot.stuck": 1},
)  # fmt: skip


class _Table(HTMLParser):
    """The cells of each row by their column, all tags, and where links lead."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows: list[dict[str, str]] = []
        self.tags: set[str] = set()
        self.links: list[str | None] = []
        self._cell = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        named = dict(attrs)
        if tag == "tr" and "data-ended" in named:
            self.rows.append({})
        elif tag == "td":
            self._cell = named["data-name"] or ""
            self.rows[-1][self._cell] = ""
        elif tag == "a":
            self.links.append(named["href"])

    def handle_data(self, data: str) -> None:
        if self._cell:
            self.rows[-1][self._cell] += data

    def handle_endtag(self, tag: str) -> None:
        if tag == "td":
            self._cell = ""


def test_a_run_is_listed_without_executing_it_again(recording: Recordings) -> None:
    found = listed(read_recording(recording("dead")), "dead.html")

    assert (found.mission, found.robot, found.backend, found.seed) == (
        "mitre_bend", "pirate_ii", "sim", 0,
    )  # fmt: skip
    assert (found.outcome, found.link) == ("failed", "dead.html")
    assert "robot.stuck" in found.message
    assert found.faults["robot.stuck"] == 1
    assert found.conditions == ("wheels_3_4_dead", "gamma_2_stiff")
    assert 15 < found.duration_s < 60


def test_a_trace_has_no_seed_and_a_torn_recording_no_end(
    recording: Recordings, tmp_path: Path
) -> None:
    whole = recording("bend").read_bytes()
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(whole[: len(whole) * 2 // 3])

    assert listed(read_recording(recording("trace")), "").seed is None
    assert listed(read_recording(torn), "").outcome == "unfinished"


def test_every_column_is_filled() -> None:
    ((row),) = _Table(index_html([RUN])).rows

    assert row == {
        "Outcome": "✗ Failed", "Mission": "m a.mcap", "Robot": "r", "Backend": "sim", "Seed": "7",
        "With": "dead, x = 3 s", "Began": "2026-01-02 03:04:05", "Duration": "61.5 s",
        "Faults": "wheel.dead × 2, robot.stuck", "Message": "why",
    }  # fmt: skip


def test_the_newest_run_stands_first_and_what_cannot_be_read_last() -> None:
    older = replace(RUN, mission="older", began="2025-01-02T03:04:05+00:00")

    found = _Table(index_html([unreadable(Path("x/bad.mcap"), "no"), older, RUN]))

    names = [row["Mission"].strip() for row in found.rows]
    assert names == ["m a.mcap", "older a.mcap", "bad.mcap"]
    assert found.rows[-1]["Message"] == "no"
    assert found.links == ["a.html", "a.html"]


@pytest.mark.parametrize(
    "field", ["name", "message", "link", "mission", "robot", "backend", "began"]
)
def test_what_a_run_says_is_text(field: str) -> None:
    evil = "\"><img src=x onerror=alert(1)> & '</script>$title"

    text = index_html([replace(RUN, **{field: evil})])

    assert "img" not in _Table(text).tags
    assert text.count("</script>") == 1


def test_the_list_asks_for_nothing() -> None:
    text = index_html([RUN])

    assert "default-src 'none'" in text
    assert "src=" not in text.replace("default-src", "")
    assert re.findall(r"@import|url\((?!#)", text) == []
