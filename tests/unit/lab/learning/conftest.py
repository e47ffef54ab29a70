from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest

import pirate_sm.learning
from pirate_sm.lab.learning.environment import InPipe

ID = pirate_sm.learning.IN_PIPE


@pytest.fixture
def environment() -> Iterator[InPipe]:
    made = InPipe()
    yield made
    made.close()


def act(environment: Any, name: str) -> tuple[Any, float, bool, bool, dict[str, Any]]:
    """Take the step of this name."""
    actions = environment.unwrapped.spaces.actions
    step: tuple[Any, float, bool, bool, dict[str, Any]] = environment.step(actions.index(name))
    return step


def lots(count: int) -> list[np.random.Generator]:
    return [np.random.default_rng(seed) for seed in range(count)]


def drawn(lot: np.random.Generator, mask: Any) -> int:
    """An action that the mask allows."""
    return int(lot.choice(np.flatnonzero(mask)))


def made(**options: Any) -> gymnasium.Env[Any, Any]:
    return gymnasium.make(ID, **options)
