"""Triggers that nothing can make true, that never get their turn, or that are true already."""

from __future__ import annotations

from pathlib import Path

import pytest

from checking.small_missions import checked, only, told


def wait(*triggers: str, within: str = "10 s", go: str = "bad") -> str:
    listed = "\n".join(f"      - {trigger}" for trigger in triggers)
    return (
        f"start: p\nphases:\n  p:\n    do: [SwitchLamp]\n    wait:\n{listed}\n"
        f"    within: {{time: {within}, go: {go}}}\n"
    )


FIRES = "{when: way > 50 mm, go: good}"


@pytest.mark.parametrize(
    ("trigger", "code"),
    [
        ("{when: way > 50 mm and way < 20 mm, go: good}", "trigger.never"),
        ("{when: abs(neck) > 3 rad, go: good}", "trigger.never"),  # beyond its end stops
        ("{when: Grip == BothHeld, go: good}", "trigger.never"),  # no state that comes here
        ("{when: pace > 1 mm/s, held: 11 s, go: good}", "trigger.never"),
        ("{after: 11 s, go: good}", "trigger.never"),
        ("{when: way > 60 mm, go: good}", "trigger.shadowed"),
        ("{when: Lamp == Lit, go: good}", "trigger.at_once"),
        ("{when: pace > 1 mm/s, held: 10 s, go: good}", ""),
        ("{after: 10 s, go: good}", ""),
        ("{operator: yes, go: good}", ""),
        ("{when: way > 40 mm, go: good}", ""),
    ],
)
def test_a_trigger_is_told_if_it_is_of_no_use(tmp_path: Path, trigger: str, code: str) -> None:
    triggers = (trigger, FIRES) if code == "trigger.at_once" else (FIRES, trigger)

    codes = [found for found, _ in told(checked(tmp_path, wait(*triggers)))]

    assert [each for each in codes if each.startswith("trigger.")][:1] == ([code] if code else [])


def test_a_condition_that_is_always_the_same_is_told(tmp_path: Path) -> None:
    body = """
start: p
phases: {p: {do: [{command: HoldNose, if: "abs(neck) > 3 rad"}, SwitchLamp], go: good}}
"""
    assert (
        "'abs(neck) > 3 rad' is always false"
        in only(checked(tmp_path, body), "condition.constant").message
    )


def test_a_wait_lasts_while_sensors_show_now_this_and_now_that(tmp_path: Path) -> None:
    """Neither condition is ever true for 2 s, and one of them always is."""
    body = wait(
        "{when: known(hip), held: 2 s, go: good}",
        "{when: not known(hip), held: 2 s, go: good}",
        within="3 s", go="q",
    ) + "  q: {do: [Rest], go: good}\n"  # fmt: skip

    found = only(checked(tmp_path, body), "step.unneeded")

    assert found.story[-1].startswith("sensors show now this and now that")
    assert not found.course  # no course of single events could show that
