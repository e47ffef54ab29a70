"""Pages in the Chromium that is installed; none is ever fetched."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC
from typer.testing import CliRunner

from pirate_sm.cli.entry import commands, only_run
from pirate_sm.running.recording.forecast_file import counted, forecast_of
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.signal_bands import signal_bands
from pirate_sm.views.report.expected_signals import run_extremes
from pirate_sm.views.report.recording_report import report_of

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

ROOT = Path(__file__).resolve().parents[2]
PATROL = ROOT / "tests" / "robots" / "newt" / "patrol.yaml"
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

RUNS = {
    "bend": ("mitre_bend",),
    "dead": ("mitre_bend", "--defect", "wheels_3_4_dead", "--defect", "gamma_2_stiff"),
    "trace": ("mitre_bend", "--backend", "trace"),
    "patrol": (str(PATROL),),
    "house": ("mitre_bend", "--pipe", str(ROOT / "tests" / "pipes" / "house.yaml")),
}
LIST = "list"
"""The page that lists all that were made."""

GAP = "gap"
"""The page of a repaired recording of which a piece was damaged."""

EXPECTED = "expected"
"""The page of the run with defects, with bands of runs that were like the one without."""

CUT_SHORT = {"torn": 7, "empty": 0}
"""How many whole pieces of the run are left in a recording, before one that is torn."""


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Chromium without a window; ``CHROMIUM`` names one that is not on the path."""
    # These tests are collected, though not run, where the driver is not installed.
    from playwright.sync_api import sync_playwright  # noqa: PLC0415

    found = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.fail("there is no Chromium: apt-get install chromium, or set CHROMIUM")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=found)
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def report(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Gives the page of one of ``RUNS``, recorded and told once; of one cut short; or the list."""
    folder = tmp_path_factory.mktemp("reports")
    made: dict[str, Path] = {}

    def get(name: str) -> Path:
        if name in made:
            return made[name]
        if name == EXPECTED:
            return made.setdefault(name, expected())
        run, told = folder / f"{name}.mcap", folder / f"{name}.html"
        if name == LIST:
            for each in ("bend", "dead", "patrol"):
                get(each)
            CliRunner().invoke(commands, ["report", str(folder), "-o", str(told)])
            return made.setdefault(name, told)
        if name in CUT_SHORT:
            get("bend")
            whole = (folder / "bend.mcap").read_bytes()
            run.write_bytes(whole[: _pieces(whole)[CUT_SHORT[name]] + 1_000])
        elif name == GAP:
            get("bend")
            spoilt, torn = bytearray((folder / "bend.mcap").read_bytes()), folder / "spoilt.mcap"
            spoilt[sum(_pieces(spoilt)[5:7]) // 2] ^= 1
            torn.write_bytes(spoilt)
            CliRunner().invoke(commands, ["repair", str(torn), "-o", str(run)])
        else:
            CliRunner().invoke(only_run(), [*RUNS[name], "--quiet", "--record", str(run)])
        assert CliRunner().invoke(commands, ["report", str(run), "-o", str(told)]).exit_code == 0
        made[name] = told
        return told

    def expected() -> Path:
        """The page with bands, with their file next to it."""
        first, told = read_recording(get("bend").with_suffix(".mcap")), folder / f"{EXPECTED}.html"
        found, run = counted(first), get("dead").with_suffix(".mcap")
        it = forecast_of(found.header, [found.visits] * 40)
        signals = signal_bands([run_extremes(report_of(first))] * 40)
        times = folder / "times.yaml"
        times.write_text(it.model_copy(update={"signals": signals}).text(), "utf-8")
        told.with_suffix(".mcap").write_bytes(run.read_bytes())
        asked = ["report", str(run), "-o", str(told), "--forecast", str(times)]
        assert CliRunner().invoke(commands, asked).exit_code == 0
        return told

    return get


def _pieces(recording: bytes | bytearray) -> list[int]:
    """Where the pieces of the run begin."""
    starts, at = [], len(MCAP0_MAGIC)
    while at < len(recording) - len(MCAP0_MAGIC):
        if recording[at] == Opcode.CHUNK:
            starts.append(at)
        at += 9 + int.from_bytes(recording[at + 1 : at + 9], "little")
    return starts


class Opened:
    """A page, what its console said and what it asked for."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.said: list[str] = []
        self.asked: list[str] = []
        page.on("console", lambda message: self.said.append(message.text))
        page.on("pageerror", lambda error: self.said.append(str(error)))
        page.on("request", lambda request: self.asked.append(request.url))

    @property
    def at_s(self) -> float:
        """The time that is shown."""
        return float(self.page.locator("#clock").inner_text().split()[0])

    @property
    def end_s(self) -> float:
        """When the run ends, by the page's slider."""
        return float(self.page.locator("#slider").get_attribute("max") or "nan")

    @property
    def places(self) -> str:
        """Where the wheels are drawn."""
        return self.page.locator("#scene").get_attribute("data-places") or ""

    @property
    def picture(self) -> str:
        """The drawing of the robot, dot by dot."""
        return str(self.page.evaluate("document.getElementById('scene').toDataURL()"))


@pytest.fixture
def opened(browser: Browser, report: Callable[[str], Path]) -> Iterator[Callable[..., Opened]]:
    """Opens the page of a run in a window of its own, with the clock of the wall stopped."""
    contexts = []

    def open_it(
        name: str, *, wide: int = 1280, high: int = 800, scheme: str = "light", before: str = ""
    ) -> Opened:
        context = browser.new_context(
            viewport={"width": wide, "height": high}, color_scheme=scheme, offline=True
        )
        contexts.append(context)
        page = context.new_page()
        page.clock.install(time=0)
        if before:
            page.add_init_script(before)
        found = Opened(page)
        page.goto(report(name).as_uri())
        page.wait_for_selector("html[data-ready=yes]", state="attached")
        page.clock.pause_at(60_000)
        return found

    yield open_it
    for context in contexts:
        context.close()
