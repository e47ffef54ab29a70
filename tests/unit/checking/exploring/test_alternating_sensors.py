"""Which waits can come to an outcome only while sensors change to and fro."""

from __future__ import annotations

from math import isnan
from pathlib import Path

import pytest

from checking.small_missions import write
from pirate_sm.checking.exploring.alternating_sensors import lasting
from pirate_sm.checking.exploring.explore import explore
from pirate_sm.checking.mission.explore_mission import conditions_of
from pirate_sm.engine.mission.program import Wait
from pirate_sm.loading.mission import load_mission

KNOWN = ("known(neck)", "2 s")
UNKNOWN = ("not known(neck)", "2 s")
APART = ("pace > 1 mm/s", "2 s")


def outcomes(folder: Path, *triggers: tuple[str, str], within: str) -> list[int]:
    """Numbers of the triggers that can outlast their rivals; -1 is the limit of the wait."""
    listed = ", ".join(f"{{when: {when}, held: {held}, go: good}}" for when, held in triggers)
    body = (
        f"start: p\nphases:\n  p:\n    wait: [{listed}]\n    within: {{time: {within}, go: bad}}\n"
    )
    loaded = load_mission(write(folder, body))
    found = explore(loaded.robot, loaded.program, conditions_of(loaded))
    wait, state = next(
        (it, node.state)
        for node in found.nodes
        if isinstance(it := loaded.program.instructions[node.state.mission.pc], Wait)
    )
    return [
        next((n for n, since in enumerate(at.mission.since) if not isnan(since)), -1)
        for at, _ in lasting(wait, state, conditions_of(loaded))
    ]


@pytest.mark.parametrize(
    ("within", "expected"),
    [
        pytest.param("3 s", [-1], id="the limit comes after the conditions"),
        pytest.param("2 s", [-1], id="at a tie a condition comes before the limit: a rival"),
        pytest.param("1 s", [], id="the limit comes first: no condition has to break"),
    ],
)
def test_a_limit_is_outlasted_by_conditions_that_break_in_turn(
    tmp_path: Path, within: str, expected: list[int]
) -> None:
    assert outcomes(tmp_path, KNOWN, UNKNOWN, within=within) == expected


def test_at_a_tie_the_conditions_listed_before_are_rivals(tmp_path: Path) -> None:
    assert outcomes(tmp_path, KNOWN, UNKNOWN, APART, within="2 s") == [-1, 2]


def test_at_a_tie_the_conditions_listed_after_are_no_rivals(tmp_path: Path) -> None:
    assert outcomes(tmp_path, APART, KNOWN, UNKNOWN, within="2 s") == [-1, 2]


def test_a_limit_does_not_outlast_a_condition_that_cannot_break(tmp_path: Path) -> None:
    always = ("known(neck) or not known(neck)", "2 s")

    assert outcomes(tmp_path, KNOWN, always, within="3 s") == []
