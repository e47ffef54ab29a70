"""Learns by a table: what each action has led to in each state, and what it is worth from there.

It looks at the states of the chart, the newest word of the detector and what was commanded since; a
wait lasts until a word is heard. An action that was not tried counts as good (R-max: Brafman and
Tennenholtz, JMLR 3, 2002), so the agent tries what the masks allow until it knows a better way.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from pirate_sm.lab.learning.environment import Mask, Observation

WAIT = "wait"

_WAITS = 20
"""How many waits make one action where nothing new is heard: 10 s, in which a robot drives 1 m."""

_PER_WORD = 0.2
"""What it counts that a later word is heard, and an earlier one costs, while learning [D].

A profile lists words in the order in which a bend is passed. Such a difference of potentials leaves
the best policy as it is (Ng, Harada and Russell, ICML 1999) and shows the way to it.
"""

_SWEEPS = 200
_EXACT = 1e-4


class Situation(NamedTuple):
    """What the table goes by.

    Attributes:
        states: Index of the state of each region.
        word: Index of the newest word of the detector, which may be valid no more; 0 before one.
        given: The commands that were given since it was heard: the same states look alike before
            and after a part was brought round a bend.
    """

    states: tuple[int, ...]
    word: int
    given: frozenset[int] = frozenset()


def situation(
    observation: Observation, before: Situation | None = None, command: int | None = None
) -> Situation:
    """Return the situation that an observation shows.

    Args:
        observation: The observation.
        before: The situation before it, in the same episode.
        command: The command that was given there; None after a wait.
    """
    states = tuple(int(state) for state in observation["states"])
    word = int(observation["word"])
    if before is None or word not in (0, before.word):
        return Situation(states, word)
    given = before.given if command is None else before.given | {command}
    return Situation(states, before.word, given)


class Tried(NamedTuple):
    """What an action has led to in a situation.

    Attributes:
        led: How often each situation has followed; None: the end of the episode.
        rewards: All rewards together.
    """

    led: Counter[Situation | None]
    rewards: list[float]


class Table:
    """A model of the robot by counts, and the best policy by it.

    Args:
        actions: How many actions there are.
        without: Actions that are never taken; each one less makes the table smaller.
        tries: How often an action is tried before its outcome counts.
        hope: What an action counts that was tried more seldom.
        discount: What a reward is worth one step later.
    """

    def __init__(
        self,
        actions: int,
        *,
        without: Iterable[int] = (),
        tries: int = 1,
        hope: float = 0.5,
        discount: float = 0.99,
    ) -> None:
        self._tries, self._hope, self._discount = tries, hope, discount
        self._taken: Mask = np.ones(actions, dtype=np.int8)
        self._taken[list(without)] = 0
        self._tried: dict[Situation, dict[int, Tried]] = {}
        self._masks: dict[Situation, Mask] = {}
        self._values: dict[Situation, float] = {}

    def __len__(self) -> int:
        """Return how many situations have been seen."""
        return len(self._masks)

    def meet(self, here: Situation, mask: Mask) -> None:
        """Note which actions a situation allows."""
        self._masks[here] = mask & self._taken
        self._tried.setdefault(here, {})

    def note(self, here: Situation, action: int, reward: float, then: Situation | None) -> None:
        """Note what an action has led to; None: the end of the episode."""
        tried = self._tried[here].setdefault(action, Tried(Counter(), [0.0]))
        tried.led[then] += 1
        tried.rewards[0] += reward

    def plan(self) -> None:
        """Find the value of each situation by the counts so far."""
        for _ in range(_SWEEPS):
            change = 0.0
            for here, mask in self._masks.items():
                value = max(self._worth(here, action) for action in np.flatnonzero(mask).tolist())
                change = max(change, abs(value - self._values.get(here, self._hope)))
                self._values[here] = value
            if change < _EXACT:
                break

    def best(self, here: Situation, mask: Mask) -> int:
        """Return the best action that the mask allows; the first of equals."""
        allowed: list[int] = np.flatnonzero(mask & self._taken).tolist()
        return max(allowed, key=lambda action: self._worth(here, action))

    def _worth(self, here: Situation, action: int) -> float:
        tried = self._tried.get(here, {}).get(action)
        if tried is None or (count := tried.led.total()) < self._tries:
            return self._hope
        later = sum(
            times * self._values.get(then, self._hope)
            for then, times in tried.led.items()
            if then is not None
        )
        return (tried.rewards[0] + self._discount * later) / count


class Played(NamedTuple):
    """An episode.

    Attributes:
        success: Whether the place was reached.
        course: The names of the commands that were given, and for each wait in between, after
            ``wait``, the word that ended it, ``wait close``, or how long it was: ``wait 10 s``.
        steps: How many steps it took; ``time_s``: how long, in mission time.
    """

    success: bool
    course: tuple[str, ...]
    steps: int
    time_s: float

    @property
    def commands(self) -> list[str]:
        """The names of the commands that were given."""
        return [step for step in self.course if not step.startswith(WAIT)]


def play(environment: Any, table: Table, seed: int | None, *, learns: bool) -> Played:
    """Play an episode by the table.

    Args:
        environment: An environment, such as ``gymnasium.make("pirate_sm/InPipe-v0")`` returns.
        table: The table.
        seed: As for ``reset``.
        learns: Whether the table learns from it.
    """
    observation, info = environment.reset(seed=seed)
    here, steps, over = situation(observation), 0, False
    words, course = environment.unwrapped.spaces.words, []
    while not over:
        if learns:
            table.meet(here, info["action_mask"])
        action, worth, began_s = table.best(here, info["action_mask"]), 0.0, info["now_s"]
        for _ in range(_WAITS):
            observation, reward, terminated, truncated, info = environment.step(action)
            command = action if info["command"] else None
            then, over = situation(observation, here, command), terminated or truncated
            worth, steps = worth + float(reward), steps + 1
            if over or info["command"] or then != here or info["faults"]:
                break
        waited = f"{info['now_s'] - began_s:.1f} s" if then.word == here.word else words[then.word]
        course.append(info["command"] or f"{WAIT} {waited}")
        if learns:
            worth += _PER_WORD * (then.word - here.word)
            table.note(here, action, worth, None if terminated else then)
        here = then
    return Played(info["success"], tuple(course), steps, info["now_s"])


def learn(environment: Any, table: Table, episodes: int, seed: int = 0) -> list[Played]:
    """Let a table learn from episodes; return them.

    Args:
        environment: As for :func:`play`.
        table: The table.
        episodes: How many.
        seed: Of the first; the others follow from it.
    """
    played = []
    for number in range(episodes):
        played.append(play(environment, table, seed if number == 0 else None, learns=True))
        table.plan()
    return played
