from __future__ import annotations

from typing import Any

from pirate_sm.showing.visible import visible

from .conftest import NEWT


def test_control_characters_are_written_out() -> None:
    assert visible("a\x1b[2J\x7f\x00\nb é") == "a\\x1b[2J\\x7f\\x00\\nb é"
    assert visible("a\x1b\nb", lines=True) == "a\\x1b\nb"


def test_a_trigger_that_was_never_fired_is_told(pirate_run: Any) -> None:
    fired = ("--fire", "within", "--fire", "within")
    result = pirate_run(NEWT / "patrol.yaml", "--backend", "trace", "--quiet", *fired)

    assert "never fired" in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_command_that_lets_go_is_marked(pirate: Any) -> None:
    listed = pirate("list", "commands").stdout

    assert "lets go of every clamp" in listed
