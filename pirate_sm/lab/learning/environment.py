"""An environment of Gymnasium: an agent gives a robot in a pipe its commands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias, cast

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from pirate_sm.core.errors import UsageError
from pirate_sm.core.options import Options
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import Numbers
from pirate_sm.core.spelling import unknown
from pirate_sm.lab.learning.picture import Image
from pirate_sm.lab.learning.rewards import Reward, StepMoment, Transition, reward_of
from pirate_sm.lab.learning.trial import OPTIONAL, Scenario, StepOutcome, Trial

# --- spaces --------------------------------------------------------------------------------------


Observation: TypeAlias = dict[str, Any]
Mask: TypeAlias = NDArray[np.int8]

_MODE = "rgb_array"

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


# --- the environment -----------------------------------------------------------------------------


class InPipe(gymnasium.Env[Observation, np.int64]):
    """A robot in a pipe, commanded by an agent; ``gymnasium.make("pirate_sm/InPipe-v0")``.

    A step is one command until it is done, has failed or there is a fault; or a wait, until the
    detector's word changes or for 0.5 s. The engine guards commands as it guards an operator's.

    Args:
        reward: What a step is worth: a name in :data:`pirate_sm.learning.REWARDS`, or a
            function of the :class:`~pirate_sm.learning.Transition`.
        render_mode: ``rgb_array``: :meth:`render` returns a picture. None: there are none.
        options: :class:`~pirate_sm.lab.learning.trial.Scenario`, such as ``mission``,
            ``defects``.

    Raises:
        LoadError: Everything that is wrong with the files.
        UsageError: An option does not fit.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012  # typed so by Gymnasium
        "render_modes": ["rgb_array"],
        "render_fps": 4,
    }

    def __init__(
        self, *, reward: str | Reward = "reach", render_mode: str | None = None, **options: Any
    ) -> None:
        if wrong := unknown("there is no render mode", [render_mode or _MODE], [_MODE]):
            raise UsageError(wrong)
        self.render_mode = render_mode
        self._scenario = scenario_of(options)
        self._reward = reward_of(reward)
        self.spaces = Spaces(self._scenario.loaded.robot)
        self.action_space = self.spaces.action
        self.observation_space = self.spaces.observation
        self._trial: Trial | None = None
        self._scenario.prepared(0)  # shows options that do not fit, before the first episode

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode, whose robot, pipe and sensors follow from the seed.

        Args:
            seed: Seeds :attr:`np_random`, from which the seed of each episode is drawn.
            options: There are none.
        """
        super().reset(seed=seed)
        self.close()
        run_seed = int(self.np_random.integers(2**31))
        ready, backend = self._scenario.prepared(run_seed)
        self._trial = trial = Trial(ready, backend, self._scenario.time_limit_s)
        self._mask = self._find_mask(trial)
        self._moment = trial.moment
        self._start_m = self._moment.last_wheel_m
        self._reach_m = self._scenario.place_to_reach(backend)
        return self._observation(trial), {**self._info(self._moment), "run_seed": run_seed}

    def step(self, action: np.int64 | int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Give a command or wait.

        Returns:
            Observation; reward; whether the place is reached or the run is over, by a fault, say;
            whether the time is up; what else there is to know.
        """
        trial = self._trial
        if trial is None:
            raise UsageError("reset the environment before its first step")
        if not self.action_space.contains(action):
            raise UsageError(
                f"expected an action from 0 to {len(self.spaces.actions) - 1}: {action!r}"
            )
        waits = int(action) == len(self.spaces.actions) - 1
        course = trial.wait() if waits else trial.command(int(action))
        before, self._moment = self._moment, trial.moment
        self._mask = self._find_mask(trial)
        step = self._transition("" if waits else self.spaces.actions[int(action)], course, before)
        truncated = trial.now_s >= self._scenario.time_limit_s
        terminated = step.reached or step.ended
        info = {
            **self._info(self._moment),
            "command": step.command,
            "outcome": step.outcome,
            "reason": course.reason,
            "faults": course.faults,
            "success": step.reached,
        }
        reward = float(self._reward(step))
        return self._observation(trial), reward, terminated, truncated and not terminated, info

    def action_masks(self) -> Mask:
        """Return 1 for each action that would be taken now, as MaskablePPO of sb3-contrib asks."""
        if self._trial is None:
            raise UsageError("reset the environment before its masks are asked for")
        return self._mask.copy()

    def render(self) -> Image | None:
        """Return a picture of the robot in its pipe from above; None without a render mode."""
        if self.render_mode is None:
            return None
        if self._trial is None:
            raise UsageError("reset the environment before it is rendered")
        return self._trial.picture

    def close(self) -> None:
        """End the episode."""
        if self._trial is not None:
            self._trial.close()
            self._trial = None

    def _transition(self, command: str, course: StepOutcome, before: StepMoment) -> Transition:
        trial, after = self._trial, self._moment
        assert trial is not None  # as step has seen
        ended = trial.ended is not None or trial.gone
        reached = not ended and after.last_wheel_m >= self._reach_m
        places = self._reach_m, self._start_m
        return Transition(command, course.outcome, before, after, reached, ended, *places)

    def _find_mask(self, trial: Trial) -> Mask:
        return self.spaces.mask(trial.refusals())

    def _observation(self, trial: Trial) -> Observation:
        return self.spaces.observation_of(trial.words, trial.numbers, self._mask)

    def _info(self, moment: StepMoment) -> dict[str, Any]:
        mask, place_m = self._mask.copy(), moment.last_wheel_m
        return {"action_mask": mask, "now_s": moment.now_s, "place_m": place_m}


def scenario_of(options: dict[str, Any]) -> Scenario:
    """Return the scenario of these options.

    Raises:
        UsageError: There is no such option, or one does not fit.
    """
    own = [name for name in Scenario.__dataclass_fields__ if name != "options"]
    if wrong := unknown("there is no option", options, sorted([*own, *OPTIONAL])):
        raise UsageError(wrong)
    optional = {name: options[name] for name in OPTIONAL if name in options}
    own_values = {name: value for name, value in options.items() if name not in optional}
    return Scenario(**own_values, options=cast(Options, optional))
