"""How far a state is from what usually happens."""

from __future__ import annotations

from pirate_sm.checking.exploring.exploration import fewest_mishaps


def test_the_mishaps_of_a_state_are_those_of_the_way_with_the_fewest() -> None:
    steps = [(-1, 0, False), (0, 1, True), (1, 2, True), (0, 3, False), (3, 2, True)]

    assert fewest_mishaps(steps) == [0, 1, 1, 0]
