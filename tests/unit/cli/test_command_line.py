"""What a command line gives is the same when it is kept as when it is read."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pirate_sm.cli import command_line

from .conftest import ROOT

CODE = """
import sys
sys.argv = ["pirate", *sys.argv[1:]]
from pirate_sm.cli import command_line
package, name = command_line.COMMANDS[sys.argv[1]][1].split(":")
work = __import__("importlib").import_module(f"pirate_sm.cli.commands.{package}")
setattr(work, name, lambda options: print(options, "typer" in sys.modules) or 0)
from pirate_sm.cli.start import main
main()
"""
LINES = [
    ("run mitre_bend --seed 3 --speed 2 --json", True),
    *(
        pytest.param(*each, marks=pytest.mark.thorough)
        for each in (
            ("check --fail-on warning sequences", True),
            ("run mitre_bend --backend serial --port loop://", False),
            ("demo", False),
            ("campaign campaigns/bend.yaml --cell one", True),
            ("campaign campaigns/bend.yaml -o results", False),
            ("console", True),
        )
    ),
]


@pytest.mark.parametrize(("words", "is_kept"), LINES)
def test_a_line_gives_the_same_again(words: str, is_kept: bool, tmp_path: Path) -> None:
    """Lines with what JSON does not give back, or with a robot's backend, are read each time."""

    def given() -> tuple[str, bool]:
        done = subprocess.run(
            [sys.executable, "-c", CODE, *words.split()],
            capture_output=True, text=True, check=False, cwd=ROOT,
            env={**os.environ, "PIRATE_SM_CACHE": str(tmp_path)},
        )  # fmt: skip
        assert (done.returncode, done.stderr) == (0, "")
        options, _, read = done.stdout.rpartition(" ")
        return options, read == "True\n"

    first, was_read = given()
    again, read_again = given()

    assert was_read
    assert again == first
    assert read_again is not is_kept


def test_another_interrupt_while_one_is_reported_ends_the_command_quietly() -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    with pytest.raises(SystemExit) as ended:
        command_line.enter(interrupted)

    assert ended.value.code == 130
