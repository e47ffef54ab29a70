from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from pirate_sm.core.robot import RobotSpec
from pirate_sm.views.console.availability import Request, obstacles

ROBOT = cast("RobotSpec", SimpleNamespace(regions=("GripState", "LightState")))
ALREADY = "unneeded: it is so already"
LONG = "impossible: it needs GripState in (NoseHeld, TailHeld, BothHeld, NothingHeld)"


def said(rows: int = 10, width: int = 38, **asked: list[Request]) -> list[str]:
    return [line.plain for line in obstacles(asked, ROBOT, width, rows)]


def test_a_reason_is_said_once_with_every_key_that_it_holds_for() -> None:
    assert said(commands=[Request("c", ALREADY), Request("d", ""), Request("e", ALREADY)]) == [
        "= c e  it is so already"
    ]


def test_a_reason_that_holds_for_all_names_no_key() -> None:
    reason = "impossible: another command is under way"
    asked = [Request("c", reason), Request("d", reason)]

    assert said(commands=asked) == ["✕ all  another command is under way"]
    assert said(commands=asked, missions=[Request("r", "")])[0].startswith("✕ commands  ")


def test_commands_that_help_stand_for_the_reason_and_are_said_once() -> None:
    two = [
        Request("b", f"impossible: Grip first ({LONG.partition(': ')[2]})"),
        Request("d", "impossible: Grip first (it needs something else)"),
        Request("c", ALREADY),
    ]
    assert said(commands=two) == ["✕ b d  Grip first", "= c  it is so already"]


def test_what_cannot_be_comes_before_what_is_so_already_and_names_are_short() -> None:
    lines = said(commands=[Request("c", ALREADY), Request("b", LONG)])

    assert lines == [
        "✕ b  needs Grip in (NoseHeld,",
        "  TailHeld, BothHeld, NothingHeld)",
        "= c  it is so already",
    ]


@pytest.mark.parametrize("rows", [1, 2, 3, 4, 5])
def test_where_there_are_too_few_lines_the_longest_reasons_are_cut(rows: int) -> None:
    asked = [Request("b", LONG), Request("e", f"{LONG} and more"), Request("c", ALREADY)]
    lines = said(rows, commands=asked)

    assert len(lines) == rows
    assert all(len(line) <= 38 for line in lines)
    assert (rows < 3) or lines[-1].startswith("= c")


def test_where_nothing_stands_in_the_way_that_is_said() -> None:
    assert said(commands=[Request("c", "")]) == ["everything can be asked for"]


def test_where_there_is_no_room_nothing_is_said_to_be_possible() -> None:
    assert said(rows=0, commands=[Request("c", LONG)]) == []
    assert said(rows=0, commands=[Request("c", "")]) == ["everything can be asked for"]
