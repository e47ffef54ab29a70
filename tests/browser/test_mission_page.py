"""The page of a mission before its run, in Chromium."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pirate_sm.core import library
from pirate_sm.lab.campaign.margins import FactorMargin, PairMap, TriedValue
from pirate_sm.lab.campaign.margins_page import MARGINS_STYLE, margins_markup
from pirate_sm.views.report.figure_page import FigureSection
from pirate_sm.views.report.mission_page import mission_page

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.browser

LEVELS = tuple(TriedValue(n / 6, "holds" if n > 2 else "fails", 21, 21) for n in range(7))
FRICTION = FactorMargin("friction", "", 0.5, 0.0, 1.0, 0.5, 1.0, 1 / 3, None, (), LEVELS, ())
MAP = tuple(replace(level, other=float(n)) for n in range(7) for level in LEVELS)


def envelope() -> list[FigureSection]:
    pair = PairMap(("friction", "tilt"), ("", "deg"), (0.5, 0.0), MAP)
    drawn = MARGINS_STYLE + margins_markup([FRICTION], [pair])
    return [FigureSection("How far it holds", markup=drawn)]


@pytest.mark.parametrize("wide", [1280, 390])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_an_envelope_can_be_read_and_never_makes_the_page_wider_than_the_window(
    browser: Browser, tmp_path: Path, wide: int, scheme: str
) -> None:
    file = tmp_path / "page.html"
    file.write_text(mission_page(library.find_mission("mitre_bend"), known=envelope), "utf-8")
    context = browser.new_context(
        viewport={"width": wide, "height": 900}, color_scheme=scheme, offline=True
    )
    page = context.new_page()
    page.goto(file.as_uri())

    assert page.evaluate("document.documentElement.scrollWidth") == wide
    name = page.locator(".margins text").first.bounding_box()
    assert name is not None
    assert name["height"] >= 9.0
    assert page.locator(".margins title").count() == len(LEVELS)
    context.close()
