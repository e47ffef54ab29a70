"""What a terminal shows while something takes long."""

from __future__ import annotations

from io import StringIO

import pytest

from pirate_sm.cli.output.terminal import progress


class Screen(StringIO):
    """A terminal that keeps all that was written."""

    def isatty(self) -> bool:
        return True

    @property
    def line(self) -> str:
        return self.getvalue().rpartition("\r\x1b[K")[2]


class Clock:
    now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture(autouse=True)
def _terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")


def test_the_share_and_what_is_left_are_shown_on_one_line_that_goes() -> None:
    screen, clock = Screen(), Clock()
    with progress("reading it", screen, clock) as tell:
        clock.now_s = 10.0
        tell(0.25)
        assert screen.line == "reading it: 25%, 30 s left"
        clock.now_s = 100.0
        tell(0.5)
        assert screen.line == "reading it: 50%, 1:40 min left"
        tell(0.75)
        assert screen.line == "reading it: 50%, 1:40 min left"
    clock.now_s = 200.0
    tell(0.9)
    assert screen.line == ""
    assert "\n" not in screen.getvalue()


def test_a_second_pass_begins_anew() -> None:
    screen, clock = Screen(), Clock()
    with progress("reading it", screen, clock) as tell:
        clock.now_s = 100.0
        tell(1.0)
        tell(0.0)
        clock.now_s = 102.0
        tell(0.5)
        assert screen.line == "reading it: 50%, 2 s left"


def test_no_progress_is_shown_for_what_ends_soon() -> None:
    screen, clock = Screen(), Clock()
    with progress("reading it", screen, clock) as tell:
        clock.now_s = 0.4
        tell(0.5)
    assert screen.getvalue() == ""


@pytest.mark.parametrize("out", [StringIO(), Screen()])
def test_nothing_is_written_where_nobody_could_read_it(
    out: StringIO, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TERM", "dumb")
    clock = Clock()
    with progress("reading it", out, clock) as tell:
        clock.now_s = 50.0
        tell(0.5)
    assert out.getvalue() == ""
