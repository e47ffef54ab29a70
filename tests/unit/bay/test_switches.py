from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from pirate_sm.bay.switches import Corruption, Loss, Occasions, Switches
from pirate_sm.errors import UsageError


def rng(seed: int = 5) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize("never_two", [False, True])
def test_the_share_of_frames_lost_is_the_one_asked_for(never_two: bool) -> None:
    loss = Loss(0.2, never_two, rng())
    lost = [not loss.arrives(1) for _ in range(20_000)]

    assert sum(lost) / len(lost) == pytest.approx(0.2, abs=0.01)


def test_independent_losses_come_in_a_row() -> None:
    loss = Loss(0.2, False, rng())
    lost = [not loss.arrives(1) for _ in range(5000)]

    assert any(a and b for a, b in itertools.pairwise(lost))


def test_of_two_consecutive_frames_of_a_topic_one_always_arrives() -> None:
    loss = Loss(0.2, True, rng())
    lost: dict[int, list[bool]] = {1: [], 2: []}
    for _ in range(20_000):
        for topic, series in lost.items():
            series.append(not loss.arrives(topic))

    assert not any(a and b for series in lost.values() for a, b in itertools.pairwise(series))


def test_the_share_of_bytes_changed_is_the_one_asked_for() -> None:
    corruption = Corruption(0.01, rng())
    changed = sum(
        sum(a != b for a, b in zip(corruption.damage(bytes(7)), bytes(7), strict=True))
        for _ in range(20_000)
    )

    assert changed / 140_000 == pytest.approx(0.01, abs=0.001)


def test_occasions_come_when_given_and_at_random() -> None:
    given = Occasions((5.0, 2.0), 0.0, rng())
    assert given.due_s == 2.0
    given.pass_one()
    assert given.due_s == 5.0
    given.pass_one()
    assert given.due_s == float("inf")

    random = Occasions((), 10.0, rng())
    for _ in range(2000):
        random.pass_one()
    assert random.due_s / 2001 == pytest.approx(10.0, rel=0.1)


@pytest.mark.parametrize(
    "wrong",
    [
        {"loss_in": 1.1},
        {"loss_out": 0.6, "never_two": True},
        {"corruption": -0.1},
        {"delay_s": -1.0},
        {"reset_at_s": (-1.0,)},
        {"ring": 0},
        {"poll_s": 0.0},
    ],
)
def test_switches_that_make_no_sense_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(UsageError):
        Switches(**wrong)
