"""The nearest valid name for a misspelt one."""

from __future__ import annotations

import pytest

from pirate_sm.core.spelling import compared_with, meant, nearest, one_of, unknown

NAMES = ["GripNose", "GripTail", "Halt", "go_on"]


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("GripNoze", "GripNose"),
        ("gripnose", "GripNose"),
        ("HALT", "Halt"),
        ("go-on", "go_on"),
        ("go on", "go_on"),
        ("entirely else", None),
        ("x" * 10_000, None),
    ],
)
def test_nearest_finds_what_was_probably_meant(written: str, meant: str | None) -> None:
    assert nearest(written, NAMES) == meant


@pytest.mark.parametrize(
    ("written", "known", "meant"),
    [
        ("wheel_dead", ["wheel.dead", "robot.stuck"], "wheel.dead"),
        ("straight_113.yaml", ["straight_113", "straight_114"], "straight_113"),
        ("distance", ["BendingState", "odometry", "speed"], None),
        ("Clamped", ["Unclamped", "DoubleClamped"], None),
        ("UnclampNose", ["ClampNose"], None),
        ("Clamped", ["Unclamped", "Clampd"], "Clampd"),
        ("Unclampd", ["Unclamped"], "Unclamped"),
        ("under", ["udner"], "udner"),
        ("dometry", ["odometry"], "odometry"),
    ],
)
def test_what_only_looks_alike_or_says_the_opposite_is_not_what_was_meant(
    written: str, known: list[str], meant: str | None
) -> None:
    assert nearest(written, known) == meant


def test_nearest_of_nothing_is_nothing() -> None:
    assert nearest("Halt", []) is None


def test_lists_of_names_stay_readable() -> None:
    assert one_of(["a"]) == "a"
    assert one_of(["a", "b"]) == "one of a, b"
    assert one_of([str(number) for number in range(20)], limit=2) == "one of 0, 1, … (18 more)"


def test_all_unknown_names_are_named_at_once() -> None:
    assert unknown("there is no step", ["Halt", "go_on"], NAMES) == ""
    assert unknown("there is no step", ["Hat", "x", "Halt", "y", "go-on"], NAMES) == (
        "there is no step 'Hat': did you mean 'Halt'?\n"
        "there is no step 'go-on': did you mean 'go_on'?\n"
        "there is no step 'x' or 'y': expected one of GripNose, GripTail, Halt, go_on"
    )
    assert unknown("it has no", ["x"], [], "it has none") == "it has no 'x': it has none"


def test_an_impossible_word_collects_the_names_that_it_is_compared_with() -> None:
    with compared_with("zzqxj") as names:
        nearest("zzqxj", ["drive", "halt"])
        nearest("drvie", ["drive", "rest"])
        meant("zzqxj", iter(["halt", "grip"]))

    assert [*names] == ["drive", "halt", "grip"]
    assert nearest("zzqxj", ["later"]) is None
    assert [*names] == ["drive", "halt", "grip"]
