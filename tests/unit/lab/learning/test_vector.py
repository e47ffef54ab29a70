from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

import pirate_sm
from pirate_sm.lab.learning.environment import InPipe
from pirate_sm.lab.learning.vector import InPipes

from .conftest import ID, drawn, lots

COUNT = 3
STEPS = 14
OPTIONS: dict[str, Any] = {"time_limit_s": 12.0, "reward": "progress"}


def alone(index: int) -> list[Any]:
    """What happens in an environment, which begins anew in the step after an end."""
    environment, lot, over = InPipe(**OPTIONS), lots(COUNT)[index], False
    observation, info = environment.reset(seed=5 + index)
    lines = [observation["signals"].tolist()]
    for _ in range(STEPS):
        action = drawn(lot, info["action_mask"])
        if over:
            (observation, info), reward, over = environment.reset(), 0.0, False
        else:
            observation, reward, terminated, truncated, info = environment.step(action)
            over = terminated or truncated
        lines.append((observation["signals"].tolist(), reward, over, info["now_s"]))
    environment.close()
    return lines


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_each_goes_as_it_goes_alone(workers: int) -> None:
    vector = gymnasium.make_vec(ID, num_envs=COUNT, workers=workers, **OPTIONS)
    assert isinstance(vector, InPipes)
    draws = lots(COUNT)
    observations, _ = vector.reset(seed=5)
    lines: list[list[Any]] = [[row.tolist()] for row in observations["signals"]]
    for _ in range(STEPS):
        masks = vector.action_masks()
        actions = np.array([drawn(lot, row) for lot, row in zip(draws, masks, strict=True)])
        observations, rewards, terminated, truncated, infos = vector.step(actions)
        over = terminated | truncated
        for i, own in enumerate(lines):
            signals = observations["signals"][i].tolist()
            own.append((signals, float(rewards[i]), bool(over[i]), infos["now_s"][i]))
    vector.close()

    assert lines == [alone(i) for i in range(COUNT)]
    assert any(line[2] for own in lines for line in own[1:])  # one has begun anew


def test_some_begin_anew() -> None:
    vector = InPipes(2, workers=1)
    first, _ = vector.reset(seed=1)
    vector.step(np.array([0, 0]))
    mask = np.array([True, False])
    observations, infos = vector.reset(seed=1, options={"reset_mask": mask})
    vector.close()

    assert (observations["signals"][0] == first["signals"][0]).all()
    assert (observations["signals"][1] != first["signals"][1]).any()
    assert infos["_run_seed"].tolist() == [True, False]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda vector: vector.step(np.array([0])), "expected 2 actions"),
        (lambda vector: vector.reset(seed=[1]), "expected 2 seeds, got 1"),
        (lambda vector: vector.reset(options={"reset_mask": [True]}), "reset_mask"),
    ],
)
def test_what_does_not_fit_is_refused(call: Any, message: str) -> None:
    vector = InPipes(2, workers=1)
    with pytest.raises(pirate_sm.UsageError, match=message):
        call(vector)
    vector.close()
