"""The page of each shipped robot is what its files say. `make golden` writes them anew."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pirate_sm.cli.entry import commands
from pirate_sm.core import library

PAGES = Path(__file__).parents[2] / "docs" / "robots"
ROBOTS = [folder.name for folder in library.robots()]


@pytest.mark.parametrize("robot", ROBOTS)
def test_the_page_is_as_the_robot_is(robot: str) -> None:
    result = CliRunner().invoke(commands, ["robot", robot])
    assert (result.exit_code, result.stderr) == (0, "")
    page = PAGES / f"{robot}.md"
    if os.environ.get("GOLDEN") == "write":
        page.write_text(result.stdout, encoding="utf-8")

    assert page.exists(), "there is no page yet: make golden"
    assert result.stdout == page.read_text("utf-8")


def test_there_is_no_page_of_a_robot_that_is_not_shipped() -> None:
    assert sorted(page.stem for page in PAGES.glob("*.md")) == sorted(ROBOTS)
