"""The stored help texts are what the options say. `make golden` writes them anew."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pirate_sm.cli import start
from pirate_sm.cli.entry import COMMANDS, commands, only_run
from pirate_sm.cli.start import help_name

FOLDER = Path(start.HELP_FOLDER)
GROUPS = ["pirate", "pirate new", "pirate camera"]
LINES = ["pirate-run", *GROUPS, *(f"pirate {command}" for command in COMMANDS)]


@pytest.mark.parametrize("line", LINES)
def test_the_stored_text_is_as_the_options_are(
    line: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    program, *words = line.split()
    monkeypatch.setenv("COLUMNS", str(start.WIDEST_HELP))
    app = only_run() if program == "pirate-run" else commands
    app([*words, "--help"], prog_name=program, standalone_mode=False)
    told = capsys.readouterr().out
    stored = FOLDER / help_name([program, *words])
    if os.environ.get("GOLDEN") == "write":
        stored.write_text(told, encoding="utf-8")

    assert stored.exists(), "there is no text yet: make golden"
    assert told == stored.read_text("utf-8")


def test_there_is_no_text_of_a_command_that_is_not() -> None:
    assert {file.name for file in FOLDER.iterdir()} == {help_name(line.split()) for line in LINES}


@pytest.mark.parametrize("line", GROUPS)
def test_the_summary_of_every_command_fits_into_its_line(line: str) -> None:
    text = (FOLDER / help_name(line.split())).read_text("utf-8")
    summaries = text.partition("Commands:\n")[2].splitlines()

    assert len(summaries) > 1
    assert [each for each in summaries if each.endswith(("...", "…"))] == []
