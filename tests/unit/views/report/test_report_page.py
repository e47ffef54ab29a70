from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from math import inf, nan

import pytest

from pirate_sm.views.report.contents import (
    Chart,
    Fact,
    Lane,
    Report,
    Sentence,
    Series,
    TimelineMark,
)
from pirate_sm.views.report.report_page import html, report_json

EVIL = "</script><img src=x onerror=alert(1)> & ' \" \u2028 $title"


class _Page(HTMLParser):
    """Notes every element, what it refers to, and the text of each script."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.references: list[str] = []
        self.scripts: list[str] = []
        self._in_script = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self._in_script = tag == "script"
        self.references += [value or "" for name, value in attrs if name in ("src", "href")]
        if tag == "script":
            self.scripts.append("")

    def handle_data(self, data: str) -> None:
        if self._in_script:
            self.scripts[-1] += data

    def handle_endtag(self, tag: str) -> None:
        self._in_script = False


@pytest.fixture
def evil() -> Report:
    return Report(
        title=EVIL,
        outcome="failed",
        summary=(EVIL, EVIL),
        story=(Sentence(0.5, EVIL, "trouble", EVIL),),
        warnings=(EVIL,),
        duration_s=1.0,
        lanes=(Lane(EVIL, (), (TimelineMark(0.5, EVIL, "fault", EVIL),)),),
        charts=(Chart(EVIL, "m", 2, (Series(EVIL, (0.0, 1.0, 2.0), (nan, inf, 1.23456)),)),),
        scene=None,
        diagram="",
        facts=(Fact(EVIL, EVIL),),
        files={EVIL: "0"},
        failures=(Sentence(0.5, EVIL, "trouble", EVIL),),
    )


@pytest.mark.parametrize("name", ["bend", "trace", "patrol"])
def test_a_page_refers_to_nothing_outside_of_itself(
    report: Callable[[str], Report], name: str
) -> None:
    text = html(report(name))
    found = _Page(text)

    assert found.references == ["data:,"]
    assert "default-src 'none'" in text
    assert re.findall(r"@import|url\((?!#)", text) == []


def test_what_a_run_says_is_text_wherever_it_stands(evil: Report) -> None:
    found = _Page(html(evil))

    assert "img" not in found.tags
    assert found.tags.count("script") == 3
    assert json.loads(found.scripts[0])["lanes"][0]["name"] == EVIL


def test_what_is_unknown_is_null_and_decimals_that_mean_nothing_are_gone(evil: Report) -> None:
    series = report_json(evil)["charts"][0]["series"][0]

    assert series["values"] == [None, None, 1.23]


def test_curves_with_the_same_times_share_them(report: Callable[[str], Report]) -> None:
    data = report_json(report("bend"))
    curves = [series for chart in data["charts"] for series in chart["series"]]

    assert len(data["clocks"]) < len(curves)
    for series in curves:
        steps = data["clocks"][series["clock"]]
        assert len(steps) == len(series["values"])
        assert all(step >= 0 for step in steps)


def test_a_run_of_ten_minutes_stays_small(report: Callable[[str], Report]) -> None:
    found = report("dead")
    full = [number * 0.15 for number in range(4_000)]
    charts = tuple(
        replace(chart, series=tuple(
            replace(each, times_s=[at_s + 0.001 * number for at_s in full],
                    values=[-100.0 + at_s * 0.37 for at_s in full])
            for number, each in enumerate(chart.series)
        ))
        for chart in found.charts
    )  # fmt: skip
    assert found.scene is not None
    poses = [found.scene.poses[number % len(found.scene.poses)] for number in range(6_000)]
    scene = replace(found.scene, times_s=[0.1 * n for n in range(6_000)], poses=poses)

    assert len(html(replace(found, charts=charts, scene=scene))) < 10e6
