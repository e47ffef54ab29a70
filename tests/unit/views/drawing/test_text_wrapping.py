from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.views.drawing.wrapping import balanced, cells, printable, wrapped


@given(st.text(max_size=200), st.integers(20, 60))
def test_lines_fit_and_lose_nothing(text: str, width: int) -> None:
    for lines in (wrapped(text, width), balanced(text, width)):
        assert "".join("".join(lines).split()) == "".join(text.split())
        assert all(cells(line) <= width * 3 // 2 for line in lines)


def test_later_lines_hang_by_as_much_as_is_asked() -> None:
    assert wrapped("  one two three", 10, 2) == ("  one two", "    three")


def test_balanced_lines_are_about_as_long() -> None:
    assert balanced("at_the_start: odometry <= 0 mm", 28) == ("at_the_start:", "odometry <= 0 mm")


def test_a_long_word_is_kept_whole_where_that_is_not_much_wider() -> None:
    assert balanced("x = FrontWheelsState=DrivingForward", 28)[-1] == (
        "FrontWheelsState=DrivingForward"
    )


def test_wide_characters_take_two_columns_and_accents_none() -> None:
    assert cells("漢字") == 4
    assert cells("e\N{COMBINING ACUTE ACCENT}") == 1


def test_what_no_file_can_show_is_replaced() -> None:
    assert printable("a\x1b\ud800\uffff\x9b\nb\tc") == "a\ufffd\ufffd\ufffd\ufffd\nb\tc"
