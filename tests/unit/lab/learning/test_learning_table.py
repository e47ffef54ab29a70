from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.learning import WITHOUT
from benchmarks.learning_table import Situation, Table, learn, play, situation

from .conftest import made

HERE, THERE = Situation((0,), 0), Situation((1,), 0)


def table(**rewards: float) -> Table:
    """A table that knows one step to the end, by each of two actions."""
    made = Table(2)
    made.meet(HERE, np.array([1, 1], dtype=np.int8))
    for action, reward in enumerate(rewards.values()):
        made.note(HERE, action, reward, None)
    made.plan()
    return made


def test_the_better_action_is_taken() -> None:
    both = np.array([1, 1], dtype=np.int8)

    assert table(first=0.1, second=0.9).best(HERE, both) == 1
    assert table(first=0.9, second=0.1).best(HERE, both) == 0


def test_what_was_never_tried_is_tried() -> None:
    assert table(first=0.1).best(HERE, np.array([1, 1], dtype=np.int8)) == 1


def test_what_the_mask_forbids_is_never_taken() -> None:
    assert table(first=0.1, second=0.9).best(HERE, np.array([1, 0], dtype=np.int8)) == 0


def test_a_way_counts_by_its_end() -> None:
    long = Table(2)
    for where in (HERE, THERE):
        long.meet(where, np.array([1, 1], dtype=np.int8))
    long.note(HERE, 0, 0.0, THERE)
    long.note(HERE, 1, 0.3, None)
    long.note(THERE, 0, 1.0, None)
    long.note(THERE, 1, -1.0, None)
    long.plan()

    assert long.best(HERE, np.array([1, 1], dtype=np.int8)) == 0


def observed(word: int) -> Any:
    return {"states": np.array([2, 1]), "word": np.int64(word)}


def test_a_word_stays_until_another_is_heard() -> None:
    begun = situation(observed(1))
    given = situation(observed(0), begun, 4)

    assert given == Situation((2, 1), 1, frozenset({4}))
    assert situation(observed(1), given) == given
    assert situation(observed(2), given, 3) == Situation((2, 1), 2)


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_it_learns_to_drive_on() -> None:
    """To a place in the first leg, which takes three commands and a wait."""
    with made(reach_m=0.45, reward="least_commands", time_limit_s=60.0) as environment:
        actions = environment.unwrapped.spaces.actions  # type: ignore[attr-defined]
        own = Table(len(actions), without=[actions.index(name) for name in WITHOUT])
        learn(environment, own, 100)
        played = [play(environment, own, 1000 + seed, learns=False) for seed in range(10)]

    assert all(each.success for each in played)
