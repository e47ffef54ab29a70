"""Presses: once each, combined, held, and asked for twice."""

from __future__ import annotations

from math import inf

import pytest

from pirate_sm.robot.control_panel.panel_file import Panel
from pirate_sm.robot.control_panel.presses import ControlChange, Press, Presses, action_text

PANEL = Panel.model_validate(
    {
        "format": 1,
        "panel": "small",
        "device": "Small",
        "channel": 2,
        "controls": {"STOP": 1, "GO": 2, "SET": 3, "A": 4, "B": 5, "FADER": 6},
        "buttons": {
            "STOP": {"do": "stop"},
            "GO": {"do": "go", "hold": "1 s"},
            "A": {"command": "Grip"},
            "SET+A": {"command": "Reset", "twice": True},
            "B": {"word": "near"},
        },
    }
)
NUMBERS = PANEL.controls


class Hand:
    """Somebody who presses buttons at times of his own."""

    def __init__(self) -> None:
        self.presses = Presses(PANEL)
        self.now_s = 0.0

    def down(self, name: str, value: int = 127) -> list[str]:
        return self._told(self.presses.take(ControlChange(2, NUMBERS[name], value), self.now_s))

    def up(self, name: str) -> list[str]:
        return self.down(name, 0)

    def tap(self, name: str) -> list[str]:
        return self.down(name) + self.up(name)

    def wait(self, seconds: float) -> list[str]:
        self.now_s += seconds
        return self._told(self.presses.pass_time(self.now_s))

    def _told(self, presses: list[Press]) -> list[str]:
        return [f"{p.name}{'?' if p.asks else ''} {action_text(p.button)}" for p in presses]


@pytest.fixture
def hand() -> Hand:
    return Hand()


def test_a_button_acts_once_until_it_is_released(hand: Hand) -> None:
    assert hand.down("A") == ["A Grip"]
    assert hand.down("A") == []
    assert hand.up("A") == []
    assert hand.down("A") == ["A Grip"]


def test_a_button_is_pressed_from_the_middle_of_its_range_on(hand: Hand) -> None:
    assert hand.down("A", 63) == []
    assert hand.down("A", 64) == ["A Grip"]


def test_a_fader_does_nothing(hand: Hand) -> None:
    assert [hand.down("FADER", value) for value in (0, 64, 127)] == [[], [], []]


def test_other_channels_and_numbers_do_nothing(hand: Hand) -> None:
    assert hand.presses.take(ControlChange(1, NUMBERS["A"], 127), 0.0) == []
    assert hand.presses.take(ControlChange(2, 99, 127), 0.0) == []


def test_a_held_button_acts_when_its_time_is_over(hand: Hand) -> None:
    assert hand.down("GO") == []
    assert hand.presses.due_s == 1.0
    assert hand.wait(0.99) == []
    assert hand.wait(0.02) == ["GO go"]
    assert hand.presses.due_s == inf
    assert hand.wait(5.0) == []


def test_a_button_released_too_early_does_nothing(hand: Hand) -> None:
    hand.down("GO")
    hand.wait(0.9)
    hand.up("GO")
    assert hand.wait(1.0) == []


def test_a_combination_asks_before_it_acts(hand: Hand) -> None:
    hand.down("SET")
    assert hand.tap("A") == ["SET+A? Reset"]
    hand.wait(2.9)
    assert hand.tap("A") == ["SET+A Reset"]
    assert hand.tap("A") == ["SET+A? Reset"]


def test_a_second_press_that_comes_too_late_asks_again(hand: Hand) -> None:
    hand.down("SET")
    hand.tap("A")
    hand.wait(3.1)
    assert hand.tap("A") == ["SET+A? Reset"]


def test_another_button_between_the_two_takes_the_first_one_back(hand: Hand) -> None:
    hand.down("SET")
    hand.tap("A")
    hand.up("SET")
    hand.tap("A")
    hand.down("SET")
    assert hand.tap("A") == ["SET+A? Reset"]


def test_beside_a_held_first_button_only_its_combinations_act_and_the_stop(hand: Hand) -> None:
    hand.down("SET")
    assert hand.tap("B") == []
    assert hand.tap("STOP") == ["STOP stop"]
    hand.up("SET")
    assert hand.tap("B") == ["B the word near"]


def test_the_order_of_a_combination_counts(hand: Hand) -> None:
    assert hand.down("A") == ["A Grip"]
    assert hand.down("SET") == []


def test_other_buttons_that_are_down_change_nothing(hand: Hand) -> None:
    hand.down("B")
    assert hand.tap("A") == ["A Grip"]


def test_a_panel_that_has_gone_holds_no_button_down(hand: Hand) -> None:
    hand.down("GO")
    hand.down("SET")
    hand.tap("A")
    hand.presses.release_all()
    assert hand.wait(2.0) == []
    assert hand.tap("A") == ["A Grip"]
    assert hand.down("GO") == []
    assert hand.wait(1.0) == ["GO go"]
