"""Figures are judged by how many times as good as before they are, or as they are."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.bench import BEGINS, ENDS, FIGURES, Figure, earlier_tree, written
from benchmarks.speeds import WORKS

PAGE = Path(__file__).resolve().parents[3] / "docs" / "measurements.md"

TIME = Figure("a check", goal=0.5, was=2.0)
RATE = Figure("steps a second", "{:,.0f}", goal=1_000, was=250, more=True)
SHARE = Figure("of a bend", "{:+.0f} %", goal=15)


@pytest.mark.parametrize(
    ("figure", "now", "before", "short"),
    [
        (TIME, 2.0, 8.0, False),  # a machine that is four times as slow
        (TIME, 0.4, 1.0, True),
        (TIME, 9.0, None, False),
        (RATE, 400.0, 100.0, False),
        (RATE, 2_000.0, 1_000.0, True),
        (SHARE, 10.0, 5.0, False),
        (SHARE, 20.0, None, True),
        (Figure("a rate"), 1.0, 1.0, False),
    ],
)
def test_it_is_marked_where_it_is_less_better_than_its_goal(
    figure: Figure, now: float, before: float | None, short: bool
) -> None:
    assert figure.is_short(now, before) == short
    assert ("short" in figure.line(now, before)) == short


def test_a_line_has_all_that_is_known() -> None:
    assert TIME.line(0.4, 1.0) == (
        "| a check | 0.40 s | 1.00 s | 2.50 × | ≤ 0.50 s of 2.00 s: 4.0 × | **short** |"
    )
    assert SHARE.line(10.0, None) == "| of a bend | +10 % | – | – | ≤ +15 % |  |"


def test_each_work_has_its_figures() -> None:
    assert FIGURES.keys() == WORKS.keys()


def test_the_table_of_a_page_is_replaced_and_nothing_else() -> None:
    page = f"Before.\n{BEGINS}old\n{ENDS}\nAfter.\n"

    assert written(page, ["new", "| lines |"]) == (
        f"Before.\n{BEGINS}new\n| lines |\n{ENDS}\nAfter.\n"
    )
    with pytest.raises(ValueError, match="the page has no"):
        written("no marks", [])


def test_the_page_of_measurements_has_all_figures() -> None:
    table = PAGE.read_text("utf-8").partition(BEGINS)[2].partition(ENDS)[0]
    named = [line.split(" | ")[0].removeprefix("| ") for line in table.splitlines()]

    assert named[4:] == [figure.what for figures in FIGURES.values() for figure in figures]


def test_without_a_history_nothing_is_compared(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert earlier_tree(tmp_path) is None
    assert "is in no history here" in capsys.readouterr().out
