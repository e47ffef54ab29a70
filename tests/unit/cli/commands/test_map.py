from __future__ import annotations

from pathlib import Path

from pirate_sm.api import run


def test_a_recording_becomes_a_pipe_file(pirate, tmp_path: Path) -> None:
    recording, file = tmp_path / "run.mcap", tmp_path / "found.yaml"
    run("enter_2d", record=recording)
    done = pirate("map", recording, "--start-at", "500 mm", "-o", file)
    assert done.exit_code == 0
    text = file.read_text(encoding="utf-8")
    assert "pipe: found\n" in text
    assert "start: {at: 500.0 mm}\n" in text
    assert pirate("check", file).exit_code == 0
    assert pirate("map", recording).output.endswith("\n")
    again = pirate("map", recording, "-o", file)
    assert (again.exit_code, file.read_text(encoding="utf-8")) == (2, text)
    assert "found.yaml' exists and was not written by this program" in again.stderr


def test_a_trace_has_nothing_to_map(pirate, tmp_path: Path) -> None:
    recording = tmp_path / "trace.mcap"
    run("enter_2d", backend="trace", record=recording)
    done = pirate("map", recording)
    assert (done.exit_code, done.stdout) == (2, "")
    assert "nothing to map: the recording shows no angle of any wheel" in done.stderr


def test_a_wrong_length_and_no_recording_are_refused(pirate, tmp_path: Path) -> None:
    assert pirate("map", tmp_path / "none.mcap").exit_code == 2
    assert pirate("map", tmp_path / "none.mcap", "--start-at", "5 s").exit_code == 2
