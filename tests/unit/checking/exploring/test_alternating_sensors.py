"""Which waits can come to an outcome only while sensors change to and fro."""

from __future__ import annotations

from math import isnan
from pathlib import Path

import pytest

from checking.small_missions import write
from pirate_sm.checking.exploring.explore import conditions_of, explore, lasting
from pirate_sm.core.effects import Ended
from pirate_sm.core.engine import EngineState
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.core.program import Wait

KNOWN = ("known(neck)", "2 s")
UNKNOWN = ("not known(neck)", "2 s")
APART = ("pace > 1 mm/s", "2 s")


def outcomes(folder: Path, *triggers: tuple[str, str], within: str) -> list[int]:
    """Numbers of the triggers that can outlast their rivals; -1 is the limit of the wait."""
    loaded = load_mission(write(folder, waiting(*triggers, within=within)))
    return [
        next((n for n, since in enumerate(at.mission.since) if not isnan(since)), -1)
        for at, _ in every_lasting(loaded)
    ]


def waiting(*triggers: tuple[str, str], within: str) -> str:
    """A mission that waits once."""
    waits = f"    wait: [{listed(*triggers)}]\n    within: {{time: {within}, go: bad}}\n"
    return f"start: p\nphases:\n  p:\n{waits}"


def listed(*triggers: tuple[str, str]) -> str:
    return ", ".join(f"{{when: {when}, held: {held}, go: good}}" for when, held in triggers)


def every_lasting(loaded: LoadedMission) -> list[tuple[EngineState, float]]:
    """What outlasts its rivals in the first wait of the mission."""
    found = explore(loaded.robot, loaded.program, conditions_of(loaded))
    wait, state = next(
        (it, node.state)
        for node in found.nodes
        if isinstance(it := loaded.program.instructions[node.state.mission.pc], Wait)
    )
    return list(lasting(wait, state, conditions_of(loaded)))


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


def test_a_condition_outlasts_its_rivals_when_it_has_held_long_enough(tmp_path: Path) -> None:
    quick = (("known(neck)", "1 s"), ("not known(neck)", "1 s"))
    body = waiting(APART, *quick, within="5 s")
    loaded = load_mission(write(tmp_path, body))

    times = [round(at_s - state.mission.armed_s, 9) for state, at_s in every_lasting(loaded)]

    assert times == [5.0, 2.0]


def test_a_wait_is_outlasted_whatever_has_ended_another_one(tmp_path: Path) -> None:
    triggers = listed(KNOWN, UNKNOWN).replace("good", "last")
    body = f"""
start: p
phases:
  p:
    wait: [{triggers}]
    within: {{time: 3 s, go: bad}}
  last:
    wait: [{{when: pace > 1 mm/s, go: good}}]
    within: {{time: 3 s, go: good}}
"""
    loaded = load_mission(write(tmp_path, body))

    found = explore(loaded.robot, loaded.program, conditions_of(loaded))

    ends = {e.end for step in found.steps for e in step.effects if isinstance(e, Ended)}
    assert ends == {"good", "bad"}
