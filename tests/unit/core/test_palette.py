"""Contrasts and distances of the colours, computed; limits are those of WCAG and Okabe-Ito."""

from __future__ import annotations

from itertools import product

import pytest

from pirate_sm.core.palette import CURVES, DAY, EITHER, NIGHT, THEMES, Palette
from pirate_sm.views.report.report_page import variables
from pirate_sm.views.showing.roles import BAD, GOOD, ON_A_TERMINAL, WARN
from tests.colour_vision import GRAPHICS, TEXT, contrast, nearest

PUBLISHED = ("#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7")
"""The colours of Okabe and Ito without black; https://jfly.uni-koeln.de/color/."""

PAGES = {
    "light": DAY,
    "dark": NIGHT,
    "light+": THEMES["contrast_light"],
    "dark+": THEMES["contrast"],
}
ALL = {**PAGES, **THEMES}

MEANINGS = ("good", "bad", "late", "path", "fault")
WORDS = [
    *product(("ink", "soft", *MEANINGS), ("paper", "ground")),
    *product(("ink", "soft"), ("box", "path_box")),
    *(("ink", f"tint{number}") for number in range(6)),
    *(("ink", f"{role}_box") for role in ("good", "bad", "late")),
    *((role, f"{role}_box") for role in ("good", "bad", "late", "path")),
]
SHAPES = [
    *product(("line", "path", "good", "bad", "late", "fault", *CURVES), ("paper",)),
    *product(("wall", "held", "touch", "drive"), ("paper", "bore")),
]

TERMINALS = {
    "VGA": {"bright_blue": "#5555ff", "yellow": "#aa5500", "bright_red": "#ff5555"},
    "Windows": {"bright_blue": "#3b78ff", "yellow": "#c19c00", "bright_red": "#e74856"},
    "xterm": {"bright_blue": "#5c5cff", "yellow": "#cdcd00", "bright_red": "#ff0000"},
    "Tango": {"bright_blue": "#729fcf", "yellow": "#c4a000", "bright_red": "#ef2929"},
}
"""What terminals show for the names unless somebody changes it [their documentation]."""


@pytest.mark.parametrize("name", ALL)
def test_words_can_be_read_and_shapes_be_seen(name: str) -> None:
    palette = ALL[name]
    low = [
        f"{one} on {other}: {found:.2f}"
        for pairs, least in ((WORDS, TEXT), (SHAPES, GRAPHICS))
        for one, other in pairs
        if (found := contrast(palette[one], palette[other])) < least
    ]
    assert low == []


@pytest.mark.parametrize("name", ["contrast", "contrast_light"])
def test_high_contrast_is_higher_than_is_asked_of_all(name: str) -> None:
    palette = ALL[name]
    for role in ("ink", "soft", *MEANINGS):
        assert contrast(palette[role], palette["paper"]) >= 7.0, role  # WCAG 2.2, level AAA


@pytest.mark.parametrize("name", [*ALL, "either"])
def test_colours_look_as_different_as_those_of_okabe_and_ito_to_everybody(name: str) -> None:
    palette, (least, _) = {**ALL, "either": EITHER}[name], nearest(PUBLISHED)
    for roles in (MEANINGS, CURVES):
        found, which = nearest([palette[role] for role in roles])
        assert found >= least, which


def test_lines_that_stand_on_white_or_on_black_are_seen_on_both() -> None:
    for role, colour in EITHER.items():
        for paper in ("#ffffff", "#0d1117"):
            assert contrast(colour, paper) >= GRAPHICS, role


@pytest.mark.parametrize("terminal", TERMINALS)
def test_states_look_different_on_usual_terminals(terminal: str) -> None:
    colours = TERMINALS[terminal]
    found, which = nearest([colours[ON_A_TERMINAL[role]] for role in (GOOD, WARN, BAD)])
    assert found >= nearest(PUBLISHED)[0], which


def test_all_palettes_have_the_same_roles() -> None:
    assert {frozenset(palette) for palette in ALL.values()} == {frozenset(DAY)}


def test_roles_are_custom_properties_of_css() -> None:
    palette: Palette = {"paper": "#ffffff", "good_box": "#e3f5f0"}
    assert variables(palette) == "--paper: #ffffff; --good-box: #e3f5f0;"
