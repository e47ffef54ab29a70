"""Long lines are broken between words where a terminal ends."""

from __future__ import annotations

import io

import pytest

from pirate_sm.cli.output.terminal import columns_of, wrapped

LINE = "climb   Drive up an upright pipe, hold there, drive down again"


def test_a_piped_line_stays_whole() -> None:
    assert columns_of(io.StringIO()) is None
    assert wrapped(LINE, None) == LINE


def test_no_word_is_cut_and_each_further_line_is_indented() -> None:
    assert wrapped(LINE, 40, 8).splitlines() == [
        "climb   Drive up an upright pipe, hold",
        "        there, drive down again",
    ]


def test_colours_have_no_width() -> None:
    assert wrapped(f"\x1b[1m{LINE}\x1b[0m", len(LINE)) == f"\x1b[1m{LINE}\x1b[0m"


@pytest.mark.parametrize("columns", [1, 19])
def test_too_narrow_a_terminal_breaks_lines_itself(columns: int) -> None:
    assert wrapped(LINE, columns) == LINE


def test_a_word_that_is_wider_than_the_terminal_stays_whole() -> None:
    assert wrapped("see " + "x" * 60, 30) == "see\n  " + "x" * 60
