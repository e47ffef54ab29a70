"""What became of commands is kept apart: given, skipped, unneeded, impossible."""

from __future__ import annotations

from pathlib import Path

from checking.small_missions import checked, told, write
from pirate_sm.checking.exploring.exploration import Visits, index_exploration
from pirate_sm.checking.exploring.explore import conditions_of, explore
from pirate_sm.core.loading import load_mission

SKIPPED_OR_IMPOSSIBLE = """
start: p
phases:
  p:
    do: [{command: HoldNose, if: known(neck)}, {command: Rest, unneeded: skip, if: known(neck)},
         {command: GoAhead, unneeded: skip}]
    go: good
"""


def visits(folder: Path, body: str) -> dict[str, Visits]:
    loaded = load_mission(write(folder, body))
    book = index_exploration(explore(loaded.robot, loaded.program, conditions_of(loaded)))
    return {each.name: each for each in book.visits.values()}


def test_a_command_that_is_skipped_has_been_visited(tmp_path: Path) -> None:
    rest = visits(tmp_path, SKIPPED_OR_IMPOSSIBLE)["Rest"]

    assert rest.skipped
    assert not rest.given
    assert not rest.refused


def test_a_command_that_is_skipped_on_one_path_is_not_refused_on_all() -> None:
    visits = Visits(skipped=[1], impossible=[2])

    assert not visits.never_fine
    assert Visits(impossible=[2]).never_fine


def test_a_step_skipped_on_one_path_and_refused_on_another_is_only_maybe_refused(
    tmp_path: Path,
) -> None:
    body = """
starts_in: {Grip: NoseHeld, Crawl: Ahead}
allow_unclamp: it lies on a table
start: p
phases:
  p:
    do:
      - choose: [{if: known(neck), do: [Home]}]
        else: []
      - {command: GoAhead, unneeded: skip}
    go: good
"""
    assert ("step.maybe_impossible", "error") in told(checked(tmp_path, body))
