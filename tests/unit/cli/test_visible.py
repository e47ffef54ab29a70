from __future__ import annotations

from typing import Any

import pytest

from pirate_sm.core.visible import visible

from .conftest import NEWT


def test_control_characters_are_written_out() -> None:
    assert visible("a\x1b[2J\x7f\x00\nb é") == "a\\x1b[2J\\x7f\\x00\\nb é"
    assert visible("a\x1b\nb", lines=True) == "a\\x1b\nb"


@pytest.mark.parametrize(
    "hidden", ["\u202e", "\u2028", "\u2029", "\u200b", "\u200d", "\u2066", "\ufeff", "\u00ad"]
)
def test_what_hides_or_reorders_text_is_written_out(hidden: str) -> None:
    assert visible(f"a{hidden}b") == f"a{hidden.encode('unicode_escape').decode()}b"


def test_words_of_any_language_stay_as_they_are() -> None:
    assert visible("Rohr Ø 120\u00a0mm → ✓ 管 трубa") == "Rohr Ø 120\u00a0mm → ✓ 管 трубa"


def test_a_trigger_that_was_never_fired_is_reported(pirate_run: Any) -> None:
    fired = ("--fire", "within", "--fire", "within")
    result = pirate_run(NEWT / "patrol.yaml", "--backend", "trace", "--quiet", *fired)

    assert "never fired" in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_trigger_whose_wait_ended_before_is_reported(pirate_run: Any) -> None:
    mission = NEWT / "patrol.yaml"
    result = pirate_run(mission, "--backend", "trace", "--quiet", "--fire", "look=100")

    assert "never fired, because something else ended its wait first: 'look'" in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_command_that_lets_go_is_marked(pirate: Any) -> None:
    listed = pirate("list", "commands").stdout

    assert "releases every clamp" in listed
