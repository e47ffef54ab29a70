"""Where a run is kept, and what is said when it cannot be."""

from __future__ import annotations

import errno
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from representative import thorough_but
from typer.testing import Result

from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.viewers import live_server as live
from pirate_sm.running.recording.write import recorder
from pirate_sm.running.recording.write.recording_file import DiskFile, RecordingFile
from pirate_sm.running.wiring import Order
from tests.unit.running.recording.recording_runs import beginning_of

TRACE = ("mitre_bend", "--backend", "trace", "--quiet")
Run = Callable[..., Result]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PIRATE_SM_RUNS")
    return tmp_path


def test_a_run_is_kept_in_runs_unless_told_otherwise(here: Path, pirate_run: Run) -> None:
    for _ in range(3):
        assert pirate_run(*TRACE).exit_code == 0

    kept = sorted((here / "runs").iterdir())
    assert len(kept) == 3
    assert all("_mitre_bend_trace" in path.name and path.suffix == ".mcap" for path in kept)
    assert all(read_recording(path).complete for path in kept)


def test_the_run_says_where_it_is_kept(here: Path, pirate_run: Run) -> None:
    result = pirate_run(*TRACE[:-1], "--plain")

    assert "recording: runs/" in result.stdout
    assert result.stderr == ""


def test_the_options_are_kept(here: Path, pirate_run: Run) -> None:
    pirate_run(
        "mitre_bend", "--seed", "7", "--set", "give_up=30s", "--record", "a.mcap", "--no-check"
    )

    header = read_recording(here / "a.mcap").header
    assert header.options["seed"] == 7
    assert header.options["settings"] == {"give_up": "30s"}
    assert header.options["check"] is False
    assert header.options["speed"] == "max"
    assert (header.mission, header.backend, header.detector) == ("mitre_bend", "sim", "sim")
    assert header.parameters["give_up"] == "30s"


def test_nothing_is_kept_where_nobody_wants_it(here: Path, pirate_run: Run) -> None:
    pirate_run(*TRACE, "--no-record")

    assert list(here.iterdir()) == []


@pytest.mark.parametrize(("folder", "found"), [("", None), ("kept", "kept")])
def test_the_environment_names_another_folder_or_none(
    folder: str, found: str | None, here: Path, pirate_run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PIRATE_SM_RUNS", folder)
    pirate_run(*TRACE)

    assert [path.name for path in here.iterdir()] == ([found] if found else [])


def test_a_file_that_was_asked_for_is_written_though_the_environment_says_none(
    here: Path, pirate_run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PIRATE_SM_RUNS", "")
    pirate_run(*TRACE, "--record", "it.mcap")

    assert read_recording(here / "it.mcap").complete


def test_a_recording_is_never_overwritten(here: Path, pirate_run: Run) -> None:
    (here / "a.mcap").write_text("mine")
    result = pirate_run(*TRACE, "--record", "a.mcap")

    assert result.exit_code == 2
    assert result.stderr == "a.mcap exists already; nothing has moved\n"
    assert (here / "a.mcap").read_text() == "mine"


def test_two_wishes_that_exclude_each_other_are_refused(here: Path, pirate_run: Run) -> None:
    result = pirate_run(*TRACE, "--record", "a.mcap", "--no-record")

    assert result.exit_code == 2
    assert "exclude each other" in result.stderr


def test_a_folder_that_cannot_be_written_is_told_and_the_mission_runs(
    here: Path, pirate_run: Run
) -> None:
    (here / "runs").write_text("a file")
    result = pirate_run(*TRACE)

    assert result.exit_code == 0
    assert result.stderr.startswith("warning: nothing is recorded: runs/")
    assert result.stderr.count("\n") == 1


def test_a_file_that_was_asked_for_and_cannot_be_written_stops_the_mission_before_it_begins(
    here: Path, pirate_run: Run
) -> None:
    (here / "runs").write_text("a file")
    result = pirate_run(*TRACE, "--record", "runs/a.mcap")

    assert result.exit_code == 2
    assert "nothing has moved" in result.stderr


@pytest.mark.parametrize("backend", thorough_but(["trace"], ["trace", "sim"]))
def test_a_disk_that_fills_up_is_told_once_and_the_mission_runs(
    backend: str, here: Path, pirate_run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    writes = 0
    right = DiskFile.write

    def full(self: DiskFile, data: bytes, /) -> None:
        nonlocal writes
        writes += 1
        if writes > 1:
            raise OSError(errno.ENOSPC, "No space left on device")
        right(self, data)

    monkeypatch.setattr(DiskFile, "write", full)
    result: Any = pirate_run("mitre_bend", "--backend", backend, "--plain")

    told = (result.stdout + result.stderr).count("No space left on device")
    assert result.exit_code == 0
    assert told == 1
    assert "nothing of the run is recorded" in result.stdout + result.stderr
    assert "succeeded" in result.stdout


@pytest.mark.parametrize("output", thorough_but(["--json"], ["", "--plain", "--quiet", "--json"]))
def test_a_recording_that_ends_before_its_run_is_told_once_by_every_output(
    output: str, here: Path, pirate_run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder, "_HELP_AT", 50)
    monkeypatch.setattr(recorder, "_MOST_STEPS", 100)
    monkeypatch.setattr(RecordingFile, "cut", broken)
    result: Any = pirate_run("mitre_bend", *output.split(), "--record", "a.mcap")

    told = result.stderr if output == "--quiet" else result.stdout + result.stderr
    assert result.exit_code == 5
    assert result.stderr.endswith("succeeded, but its recording a.mcap is incomplete\n")
    assert told.count("nothing of the run is recorded: the disk is gone") == 1


def broken(self: object) -> bytes:
    raise OSError(errno.EIO, "the disk is gone")


@pytest.mark.parametrize("room", thorough_but([100_000], [90_000, 100_000, 110_000]))
def test_until_when_a_recording_holds_is_said_as_a_reader_finds_it(
    room: int, here: Path, pirate_run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    right = DiskFile.write
    monkeypatch.setattr(recorder, "_HELP_AT", 50)
    monkeypatch.setattr(recorder, "_MOST_STEPS", 100)

    def full(self: DiskFile, data: bytes, /) -> None:
        nonlocal room
        right(self, data[: max(room, 0)])
        room -= len(data)
        if room < 0:
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(DiskFile, "write", full)
    result: Any = pirate_run("mitre_bend", "--plain", "--record", "a.mcap")

    (said,) = re.findall(r"the recording holds until ([\d.]+) s", result.stdout + result.stderr)
    recording = read_recording(here / "a.mcap")
    assert result.exit_code == 5
    assert f"{recording.until_s:.3f}" == said
    assert recording.until_s > 0.5
    assert not recording.complete


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("more", "code"),
    [
        (("--record", "a.mcap"), 5),
        ((), 5),
        (("--record", "a.mcap", "--defect", "gamma_2_sticks"), 1),
    ],
)
def test_a_lost_recording_that_was_asked_for_gives_a_code_to_a_mission_that_succeeds(
    more: tuple[str, ...], code: int, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PIRATE_SM_RUNS", "kept")
    said = on_a_disk_that_fills_up("mitre_bend", *more)

    assert said.returncode == code
    assert "warning: " in said.stderr
    assert ("is incomplete" in said.stderr) == (code == 5)


@pytest.mark.thorough
def test_a_lost_recording_that_nobody_asked_for_is_a_warning(here: Path) -> None:
    said = on_a_disk_that_fills_up("mitre_bend")

    assert said.returncode == 0
    assert said.stderr.startswith("warning: runs/")


def on_a_disk_that_fills_up(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Return the end of a run whose files can be begun, and soon cannot become any larger."""
    room = beginning_of(Order("mitre_bend")) + 5_000
    program = (
        "import resource; from pirate_sm.cli.entry import run_main; "
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({room}, {room})); run_main()"
    )
    command = [sys.executable, "-c", program, *arguments, "--quiet"]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_a_run_that_is_refused_leaves_no_file(here: Path, pirate_run: Run) -> None:
    result = pirate_run(*TRACE[:1], "--quiet", "--detector", "operator", "--record", "a.mcap")

    assert result.exit_code == 2
    assert list(here.rglob("*.mcap")) == []


@pytest.mark.parametrize("asked", [True, False])
def test_a_file_whose_beginning_cannot_be_written_is_not_left_behind(
    asked: bool, here: Path, pirate_run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(self: DiskFile, data: bytes, /) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(DiskFile, "write", full)
    result = pirate_run(*TRACE, *(("--record", "a.mcap") if asked else ()))

    assert result.exit_code == (2 if asked else 0)
    assert "No space left on device" in result.stderr
    assert list(here.rglob("*.mcap")) == []


def test_a_run_can_be_looked_at_without_being_kept(
    here: Path, pirate_run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("foxglove")
    monkeypatch.setattr(live.Live.__init__, "__defaults__", (0,))
    result = pirate_run(*TRACE[:-1], "--plain", "--live", "--no-record")

    assert result.exit_code == 0
    assert "live: open ws://127.0.0.1:" in result.stdout
    assert list(here.iterdir()) == []


def test_looking_on_without_the_extra_says_what_to_install(
    here: Path, pirate_run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "foxglove", None)
    result = pirate_run(*TRACE, "--live")

    assert result.exit_code == 2
    assert "pip install 'pirate-sm[live]'" in result.stderr


def test_a_recording_named_by_hand_makes_no_folder(pirate_run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "mistyped"

    result = pirate_run(*TRACE, "--record", folder / "a.mcap")

    assert result.exit_code == 2
    assert f"there is no folder '{folder}'; nothing has moved" in result.stderr
    assert not folder.exists()
