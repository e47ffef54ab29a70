"""The picture of how far the bend holds, made by the command on the page about margins.

The command takes some ten minutes, so the picture is only taken again if the page has another
command or other results, or if margins are drawn in another way.
"""

from __future__ import annotations

import hashlib
import re
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from typer.testing import CliRunner

from pirate_sm.cli.entry import commands
from pirate_sm.lab.campaign.margins import FactorMargin, PairMap, TriedValue
from pirate_sm.lab.campaign.margins_page import MARGINS_STYLE, margins_markup
from pirate_sm.views.report.figure_page import figure_page

if TYPE_CHECKING:
    from playwright.sync_api import Browser

MARGINS = "margins.png"
"""The name of the picture."""

_PAGE = Path(__file__).resolve().parents[1] / "docs" / "margins.md"
_BLOCK = re.compile(
    r"^```text\n\$ pirate (margins \S+ [^\n]*--pair [^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL
)
_WINDOW = {"width": 1000, "height": 900}


def _documented() -> tuple[list[str], list[str]]:
    """Return the words of the command on the page, and the lines that it prints."""
    found = _BLOCK.search(_PAGE.read_text("utf-8"))
    assert found is not None, "the page about margins has no command with a map"
    return shlex.split(found[1]), found[2].splitlines()


def made_of_margins() -> str:
    """Return a hash of what determines the picture: the results on the page, and their looks."""
    tried = [TriedValue(n, kind, 1, 2, other=1.0) for n, kind in enumerate(("holds", "fails"))]
    factor = FactorMargin("a", "", 0, 0, 1, 0, 0.5, None, 1, (), tuple(tried), ())
    drawn = margins_markup([factor], [PairMap(("a", "b"), ("", ""), (0, 0), tuple(tried))])
    said = (MARGINS_STYLE, figure_page("", []), drawn, *map(str, _documented()))
    return hashlib.sha256("\n".join(said).encode()).hexdigest()[:16]


def take_margins_picture(chromium: Browser, folder: Path, picture: Path) -> None:
    """Run the command of the page and take the picture of its results.

    Args:
        chromium: The browser.
        folder: For the results.
        picture: The file of the picture.

    Raises:
        SystemExit: The page says that something else comes of it.
    """
    words, lines = _documented()
    place = folder / "margins"
    said = CliRunner().invoke(commands, [*words, "--output", str(place)])
    if wrong := list(_not_said(lines, said.stdout.splitlines())):
        sys.exit("\n".join([f"{_PAGE}: not what comes of it:", *wrong, "It is:", said.output]))
    CliRunner().invoke(commands, ["report", str(place)])
    window = chromium.new_page(viewport=_WINDOW)
    window.goto((place / "index.html").as_uri())
    window.locator("section", has=window.locator("svg.margins")).screenshot(path=picture)


def _not_said(lines: list[str], said: list[str]) -> Iterator[str]:
    """Yield the lines that were not printed; what follows an ellipsis is left out on the page."""
    for line in lines:
        if not any(each.startswith(line.removesuffix("…").rstrip()) for each in said):
            yield line
