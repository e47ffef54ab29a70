"""What the values of options mean that are given as text."""

from __future__ import annotations

from math import inf

import pytest

from pirate_sm.cli.commands.run import ON_A_TERMINAL
from pirate_sm.cli.options.declaring import read_duration, read_length, read_settings, read_speed
from pirate_sm.core.errors import UsageError


def test_a_terminal_has_a_speed_at_which_one_can_watch() -> None:
    assert read_speed(None, ON_A_TERMINAL) == 4.0
    assert read_speed("realtime", inf) == 1.0
    assert read_speed("max", 4.0) == inf
    assert read_speed("2.5", 4.0) == 2.5


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "fast"])
def test_a_speed_is_a_factor_above_zero(text: str) -> None:
    with pytest.raises(UsageError, match="expected max, realtime, or a factor"):
        read_speed(text, 1.0)


def test_settings_are_read_by_name() -> None:
    assert read_settings(["a=1 m", " b = x=y "]) == {"a": "1 m", "b": "x=y"}
    assert read_settings(None) == {}


@pytest.mark.parametrize(("texts", "why"), [(["a"], "expected NAME"), (["a=1", "a=2"], "twice")])
def test_settings_that_read_otherwise_are_refused(texts: list[str], why: str) -> None:
    with pytest.raises(UsageError, match=why):
        read_settings(texts)


def test_lengths_and_durations_are_read_as_si() -> None:
    assert read_length("--start-at", "700 mm") == pytest.approx(0.7)
    assert read_duration("--guard-for", "2 min") == pytest.approx(120.0)
    assert read_duration("--guard-for", None) is None


def test_a_duration_is_above_zero() -> None:
    with pytest.raises(UsageError, match="--guard-for 0 s: expected a duration above zero"):
        read_duration("--guard-for", "0 s")
