"""The documents' pictures that are no drawings: pages in Chromium, an editor, and what cameras see.

`make pictures` takes them anew. A picture of a page depends on the browser and its fonts, so tests
do not compare it: `made_of.json` beside it says of which page it was taken, and they compare that.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import NamedTuple

from typer.testing import CliRunner

from pirate_sm.cli.entry import commands, only_run
from website.camera_pictures import MOMENTS, QUALITY, seen
from website.editor_pictures import take_editor_pictures
from website.margins_picture import MARGINS, made_of_margins, take_margins_picture

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
MADE_OF = PICTURES / "made_of.json"
CHROMIUM = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
PAGE = ROOT / "pirate_sm" / "views" / "report" / "page"

_NEWT = str(ROOT / "tests" / "robots" / "newt" / "patrol.yaml")


class Shot(NamedTuple):
    """A picture of a report, or of the list of several.

    Attributes:
        runs: What is run, as arguments of `pirate-run`.
        size: Width and height of the window, px.
        at_s: The time that the report shows; None in a list.
    """

    runs: tuple[tuple[str, ...], ...]
    size: tuple[int, int]
    at_s: float | None = None


SHOTS: Mapping[str, Shot] = MappingProxyType(
    {
        "report.png": Shot((("mitre_bend",),), (1280, 1572), 16.0),
        "report_network.png": Shot(
            (("mitre_bend", "--pipe", str(ROOT / "tests" / "pipes" / "house.yaml")),),
            (1280, 1500),
            15.0,
        ),
        "mitre_bend_wide.png": Shot(
            (("mitre_bend", "--seed", "0", "--number", "pipe.diameter=122.9mm"),), (1280, 640), 71.4
        ),
        "runs.png": Shot(
            (
                ("mitre_bend", "--seed", "1"),
                ("mitre_bend", "--seed", "2"),
                ("mitre_bend", "--defect", "wheels_3_4_dead", "--defect", "gamma_2_stiff"),
                ("enter_2d", "--backend", "trace"),
                (_NEWT,),
            ),
            (1280, 430),
        ),
    }
)


def page_of(shot: Shot, folder: Path) -> Path:
    """Return the page of which a picture is taken, made now in this folder."""
    for number, arguments in enumerate(shot.runs, 1):
        recording = str(folder / f"{number}.mcap")
        CliRunner().invoke(only_run(), [*arguments, "--quiet", "--record", recording])
    what, page = (folder / "1.mcap" if len(shot.runs) == 1 else folder), folder / "page.html"
    result = CliRunner().invoke(commands, ["report", str(what), "-o", str(page)])
    assert result.exit_code == 0, result.output
    return page


def made_of(page: Path) -> str:
    """Return a hash of what determines the looks of a page, but for numbers.

    It is that of its words, without the hashes of the files that were run, and of the styles and
    scripts of all pages of reports.
    """
    text = re.sub(r"<(script|style|svg)\b.*?</\1>", "", page.read_text("utf-8"), flags=re.DOTALL)
    words = re.sub(r"\b[0-9a-f]{64}\b|\s+|[\d.:,-]+", " ", re.sub(r"<[^>]*>", " ", text))
    digest = hashlib.sha256(" ".join(words.split()).encode())
    for file in sorted(each for each in PAGE.iterdir() if each.suffix in (".css", ".html", ".js")):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def take() -> None:
    """Take every picture anew.

    Raises:
        SystemExit: There is no Chromium, Neovim or tmux.
    """
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - tests need none

    browser = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, CHROMIUM)), None)
    if browser is None:
        sys.exit("there is no Chromium: apt-get install chromium, or set CHROMIUM")
    known = {MARGINS: made_of_margins()}
    before = json.loads(MADE_OF.read_text("utf-8"))
    with sync_playwright() as driver, TemporaryDirectory() as place:
        chromium = driver.chromium.launch(executable_path=browser)
        for name, shot in SHOTS.items():
            folder = Path(place) / name
            folder.mkdir()
            page = page_of(shot, folder)
            known[name] = made_of(page)
            width, height = shot.size
            window = chromium.new_page(viewport={"width": width, "height": height})
            window.goto(page.as_uri())
            if shot.at_s is not None:
                window.wait_for_selector("html[data-ready=yes]", state="attached")
                window.locator("#slider").evaluate(
                    "(it, at) => { it.value = at; it.dispatchEvent(new Event('input')); }",
                    shot.at_s,
                )
                window.wait_for_timeout(300)  # the page draws with the screen
            window.screenshot(path=PICTURES / name)
        if before.get(MARGINS) != known[MARGINS]:
            take_margins_picture(chromium, Path(place), PICTURES / MARGINS)
        chromium.close()
    known |= take_editor_pictures(PICTURES)
    MADE_OF.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    write_camera_pictures()


def write_camera_pictures() -> None:
    """Write what the synthetic cameras see."""
    from pirate_sm.robot.vision.opencv import cv2  # noqa: PLC0415 - the pages need no OpenCV

    for name, moment in MOMENTS.items():
        cv2.imwrite(str(PICTURES / name), seen(moment), [cv2.IMWRITE_JPEG_QUALITY, QUALITY])


if __name__ == "__main__":
    take()
