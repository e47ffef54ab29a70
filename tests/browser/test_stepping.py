"""Stepping through a recorded run on its page: step by step, phase by phase, to a line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.views.report.contents import Report
from pirate_sm.views.report.recording_report import report_of
from pirate_sm.views.report.report_page import html

from .conftest import Opened

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def bend(report: Callable[[str], Path]) -> Report:
    return report_of(read_recording(report("bend").with_suffix(".mcap")))


def step(it: Opened, name: str) -> float:
    it.page.locator(f'[data-step="{name}"]').click()
    return it.at_s


def marked(it: Opened) -> int:
    """The line that is marked as under way."""
    return int(it.page.locator("#lines .line.now").get_attribute("data-line") or 0)


def test_steps_lead_from_one_to_the_next_and_back(
    opened: Callable[..., Opened], bend: Report
) -> None:
    it = opened("bend")
    moments = sorted({round(at_s, 3) for at_s, _ in bend.stepping.begun})
    own = dict(bend.stepping.begun)  # the last line of each moment
    it.page.locator("#slider").fill("0")

    seen = [step(it, "next") for _ in moments if it.page.locator('[data-step="next"]').is_enabled()]

    assert seen == pytest.approx([each for each in moments if each > 0], abs=0.011)
    assert it.page.locator('[data-step="next"]').is_disabled()
    assert step(it, "back") == pytest.approx(moments[-2], abs=0.011)
    assert set(own.values()) - {0} <= set(bend.stepping.lines)


def test_keys_do_the_same_and_a_line_leads_to_when_it_begins(
    opened: Callable[..., Opened], bend: Report
) -> None:
    it = opened("bend")
    it.page.locator("#slider").fill("0")
    it.page.locator("h1").click()
    phases = [span.start_s for lane in bend.lanes if lane.name == "phase" for span in lane.spans]

    it.page.keyboard.press(">")
    assert it.at_s == pytest.approx(next(each for each in phases if each > 0), abs=0.011)
    it.page.keyboard.press("<")
    it.page.keyboard.press(".")
    it.page.keyboard.press(",")
    line = next(n for at_s, n in bend.stepping.begun if n and at_s > it.at_s + 0.1)
    it.page.locator(f'#lines .line[data-line="{line}"] button.text').click()
    assert it.at_s == pytest.approx(
        next(at_s for at_s, n in bend.stepping.begun if n == line and at_s > 0), abs=0.011
    )
    assert marked(it) == line
    assert it.said == []


@pytest.mark.parametrize("wide", [1280, 390])
def test_breakpoints_of_the_run_are_at_their_lines_and_in_the_diagram(
    browser: object, bend: Report, tmp_path: Path, wide: int
) -> None:
    first, second = [n for _, n in bend.stepping.begun if n][:2]
    stepping = bend.stepping._replace(breakpoints=((0.0, (first,)), (5.0, (second,))))
    page = tmp_path / "run.html"
    page.write_text(html(replace(bend, stepping=stepping)), encoding="utf-8")
    shown = browser.new_page(viewport={"width": wide, "height": 800})  # type: ignore[attr-defined]
    shown.goto(page.as_uri())

    def at(time_s: float) -> list[str | None]:
        shown.locator("#slider").fill(str(time_s))
        marks = shown.locator('#lines .mark[aria-pressed="true"]')
        return [each.get_attribute("data-number") for each in marks.all()]

    assert at(1.0) == [str(first)]
    assert at(6.0) == [str(second)]
    assert shown.locator("#diagram .pauses").count() == 1
    assert shown.evaluate("document.documentElement.scrollWidth") == wide
    shown.close()
