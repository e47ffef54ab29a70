from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from .conftest import NEWT


@pytest.fixture
def run(pirate_run: Any, tmp_path: Path) -> Path:
    path = tmp_path / "run.mcap"
    pirate_run(NEWT / "patrol.yaml", "--backend", "trace", "--quiet", "--record", path)
    return path


def test_a_report_stands_beside_its_recording_or_where_it_was_wanted(
    pirate: Any, run: Path, tmp_path: Path
) -> None:
    assert pirate("report", run).stdout == f"{tmp_path / 'run.html'}\n"
    assert pirate("report", run, "-o", tmp_path / "other.html").exit_code == 0

    assert (tmp_path / "run.html").read_text("utf-8").startswith("<!doctype html>")
    assert (tmp_path / "other.html").read_bytes() == (tmp_path / "run.html").read_bytes()


def test_a_report_does_not_overwrite_its_recording(pirate: Any, run: Path) -> None:
    before = run.read_bytes()
    result = pirate("report", run, "-o", run)

    assert (result.exit_code, run.read_bytes()) == (2, before)
    assert "is the recording itself" in result.stderr


@pytest.mark.parametrize("content", [None, b"", b"no recording", b"\x89MCAP0\r\n"])
def test_what_is_no_recording_is_refused_in_one_line(
    pirate: Any, tmp_path: Path, content: bytes | None
) -> None:
    path = tmp_path / "broken.mcap"
    if content is not None:
        path.write_bytes(content)
    result = pirate("report", path)

    assert result.exit_code == 2
    assert "broken.mcap" in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert not (tmp_path / "broken.html").exists()


def test_a_page_that_cannot_be_written_is_told(pirate: Any, run: Path, tmp_path: Path) -> None:
    result = pirate("report", run, "-o", tmp_path / "nowhere" / "a.html")

    assert result.exit_code == 2
    assert "cannot be written" in result.stderr
