"""The spaces of an environment: what an agent sees and what it can do, taken from the robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import Numbers

Observation: TypeAlias = dict[str, Any]
Mask: TypeAlias = NDArray[np.int8]

LARGEST = 1e6
"""Signals are clipped to this, SI; no signal of a robot in a pipe comes near it."""


class Spaces:
    """The spaces of a robot, and how the engine's knowledge is put into them.

    Args:
        robot: The robot.

    Attributes:
        actions: The names of the actions: the commands of the chart, in its order, and ``wait``.
        words: The words of the detector; the first is unknown.
        action: The actions; ``observation``: the observations.
    """

    def __init__(self, robot: RobotSpec) -> None:
        table = robot.table
        self.actions = (*table.commands, "wait")
        self.words = ("", *robot.detector_words)
        signals = len(robot.vocabulary.numbers)
        self.action = spaces.Discrete(len(self.actions))
        self.observation = spaces.Dict(
            {
                "states": spaces.MultiDiscrete([len(states) for states in table.states]),
                "word": spaces.Discrete(len(self.words)),
                "signals": spaces.Box(-LARGEST, LARGEST, (signals,), np.float32),
                "known": spaces.MultiBinary(signals),
                "action_mask": spaces.MultiBinary(len(self.actions)),
            }
        )
        self._states = [{name: i for i, name in enumerate(states)} for states in table.states]
        self._words = {word: i for i, word in enumerate(self.words)}

    def mask(self, refusals: Sequence[str]) -> Mask:
        """Return 1 for each action that would be taken: commands that are not refused, the wait."""
        return np.array([*(not reason for reason in refusals), True], dtype=np.int8)

    def observation_of(
        self, words: Sequence[str | None], numbers: Numbers, mask: Mask
    ) -> Observation:
        """Return what an agent sees.

        Args:
            words: State of each region, then the detector's word; None is unknown.
            numbers: Signals, SI; NaN is unknown and becomes 0.
            mask: The actions that would be taken.
        """
        *states, word = words
        signals = np.array(numbers, dtype=np.float64)
        known = np.isfinite(signals)
        shown = np.where(known, np.clip(signals, -LARGEST, LARGEST), 0.0)
        indexes = [
            known_as[state or ""] for known_as, state in zip(self._states, states, strict=True)
        ]
        return {
            "states": np.array(indexes, dtype=np.int64),
            "word": np.int64(self._words[word or ""]),
            "signals": shown.astype(np.float32),
            "known": known.astype(np.int8),
            "action_mask": mask.copy(),
        }
