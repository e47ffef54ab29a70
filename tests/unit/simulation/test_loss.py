from __future__ import annotations

import itertools

import numpy as np
import pytest

from pirate_sm.simulation.acting_defect import Loss


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
