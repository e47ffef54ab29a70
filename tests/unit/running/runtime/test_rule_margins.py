"""How near signals are to the limits of fault rules."""

from __future__ import annotations

from math import nan

import pytest

from pirate_sm.core.expressions import EnumType, NumberType, Vocabulary, compile_condition
from pirate_sm.core.robot import FaultSpec
from pirate_sm.core.units import DIMENSIONLESS, LENGTH, SPEED
from pirate_sm.running.runtime.near_misses import RuleMargin, margins_of

WORDS = Vocabulary(
    {
        "width": NumberType(LENGTH),
        "speed": NumberType(SPEED),
        "ratio": NumberType(DIMENSIONLESS),
        "Grip": EnumType(("Open", "Closed")),
    }
)


def levels(text: str, held_s: float = 0.0) -> list[RuleMargin]:
    when = compile_condition(text, WORDS)
    return margins_of(FaultSpec("a.b", "message", when, held_s, True), WORDS)


def level(text: str, held_s: float = 0.0) -> RuleMargin:
    (only,) = levels(text, held_s)
    return only


def seen(
    it: RuleMargin,
    width: float = nan,
    speed: float = nan,
    ratio: float = nan,
    *,
    grip: str | None = "Closed",
    at: float = 0.0,
) -> tuple[float, str]:
    return it.seen((width, speed, ratio), (grip,), at)


def test_what_rises_is_told_as_a_share_of_its_limit() -> None:
    assert seen(level("width > 130 mm"), 0.104) == (
        pytest.approx(0.8),
        "width came up to 0.104 m, the limit is 0.13 m",
    )


def test_what_falls_is_told_as_a_share_too() -> None:
    assert seen(level("abs(speed) < 10 mm/s"), speed=-0.04) == (
        pytest.approx(0.25),
        "abs(speed) came down to 0.04 m/s, the limit is 0.01 m/s",
    )


@pytest.mark.parametrize("text", ["width > 130 mm", "130 mm < width"])
def test_a_limit_may_stand_on_either_side(text: str) -> None:
    assert seen(level(text), 0.13 * 0.5)[0] == pytest.approx(0.5)


def test_beyond_the_limit_it_has_come_about() -> None:
    assert seen(level("width > 130 mm"), 0.2) == (1.0, "")


@pytest.mark.parametrize("width", [nan, 0.0, -0.1])
def test_the_unknown_and_what_has_another_sign_is_not_near(width: float) -> None:
    assert seen(level("width > 130 mm"), width)[0] == 0.0


def test_only_while_the_rest_of_the_rule_holds() -> None:
    it = level("width > 100 mm and Grip == Closed")

    assert seen(it, 0.09, grip="Open") == (0.0, "")
    assert seen(it, 0.09, grip=None) == (0.0, "")
    assert seen(it, 0.09, grip="Closed")[0] == pytest.approx(0.9)


def test_of_several_limits_the_one_that_is_farthest_off_counts() -> None:
    it = level("width > 100 mm and abs(speed) < 10 mm/s")

    nearness, text = seen(it, 0.2, 0.02)
    assert nearness == pytest.approx(0.5)
    assert text.startswith("abs(speed) came down to")


def test_each_way_for_a_rule_to_hold_is_followed_for_itself() -> None:
    first, second = levels("width > 100 mm or abs(speed) > 1 m/s")

    assert seen(first, 0.05, 0.1)[0] == pytest.approx(0.5)
    assert seen(second, 0.05, 0.1)[0] == pytest.approx(0.1)


def test_a_rule_about_words_alone_has_no_limit_to_come_near_to() -> None:
    assert levels("Grip == Open") == []


def test_it_must_have_been_near_for_as_long_as_the_rule_must_hold() -> None:
    it = level("width > 100 mm", held_s=1.0)

    assert seen(it, 0.09, at=0.0) == (0.0, "")
    assert seen(it, 0.05, at=0.5) == (0.0, "")
    nearness, text = seen(it, 0.09, at=1.0)
    assert nearness == pytest.approx(0.5)
    assert text == "width came up to 0.05 m for 1 s, the limit is 0.1 m"
    assert seen(it, 0.08, at=1.5)[0] == pytest.approx(0.5)
    assert seen(it, 0.09, at=1.6)[0] == pytest.approx(0.8)


def test_it_begins_anew_when_the_rest_has_not_held() -> None:
    it = level("width > 100 mm and Grip == Closed", held_s=1.0)
    seen(it, 0.09, at=0.0)
    seen(it, 0.09, at=0.9, grip="Open")

    assert seen(it, 0.09, at=1.1) == (0.0, "")
    assert seen(it, 0.09, at=2.1)[0] == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("condition", "words"),
    [
        ("max(width, 10 mm) > 100 mm", "max(width, 0.01) came up to 0.05 m"),
        ("ratio * 2 > 100", "(ratio * 2) came up to 80.0"),
        ("-speed + 1 m/s > 9 m/s", "(-speed + 1) came up to 1.5 m/s"),
    ],
)
def test_a_value_is_written_as_people_write_it(condition: str, words: str) -> None:
    assert seen(level(condition), 0.05, -0.5, 40.0)[1].startswith(words)
