"""Many environments that take their steps together, on all processors."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from multiprocessing import get_context
from multiprocessing.connection import Connection
from os import cpu_count
from typing import Any, NamedTuple, cast

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array
from numpy.typing import NDArray

from pirate_sm.api.arguments import whole
from pirate_sm.core.errors import BackendError, UsageError
from pirate_sm.lab.learning.environment import InPipe, Mask, Observation

# --- shards --------------------------------------------------------------------------------------


_STOP_S = 5.0
"""How long a process may take to end after it was asked to."""


class Row(NamedTuple):
    """What a step of one environment has given."""

    observation: Observation
    reward: float
    terminated: bool
    truncated: bool
    info: dict[str, Any]


class EnvironmentShare:
    """Environments of one process, which begin a new episode in the step after an end.

    What is asked for with ``send`` is returned by ``receive``, as of a :class:`RemoteShard`.

    Args:
        count: How many.
        options: Keyword arguments of :class:`~pirate_sm.lab.learning.environment.InPipe`.
    """

    def __init__(self, count: int, options: dict[str, Any]) -> None:
        self._environments = [InPipe(**options) for _ in range(count)]
        self._over = [False] * count
        self._next: list[Row | None] = [None] * count
        self._asked: Callable[[], object] = lambda: None

    def send(self, method: str, *arguments: object) -> None:
        """Ask for a method; it is done when it is received."""
        self._asked = lambda: getattr(self, method)(*arguments)

    def receive(self) -> Any:
        """Do what was asked for."""
        return self._asked()

    def reset(self, seeds: Sequence[int | None], mask: Sequence[bool]) -> list[Row | None]:
        """Begin episodes in the environments that the mask names; None for the others."""
        rows: list[Row | None] = []
        for i, environment in enumerate(self._environments):
            begun, self._next[i] = (self._next[i], None) if mask[i] else (None, self._next[i])
            if not mask[i]:
                rows.append(None)
                continue
            rows.append(begun if begun and seeds[i] is None else _begin(environment, seeds[i]))
            self._over[i] = False
        return rows

    def step(self, actions: Sequence[int]) -> list[Row]:
        """Take a step in each; one whose episode is over begins another and ignores its action."""
        rows = []
        for i, (environment, action) in enumerate(zip(self._environments, actions, strict=True)):
            if self._over[i]:
                row, self._next[i] = self._next[i] or _begin(environment, None), None
            else:
                row = Row(*environment.step(action))
            self._over[i] = row.terminated or row.truncated
            rows.append(row)
        return rows

    def begin_next(self) -> None:
        """Begin the next episodes where one is over, while nobody waits for it."""
        for i, environment in enumerate(self._environments):
            if self._over[i] and self._next[i] is None:
                self._next[i] = _begin(environment, None)

    def close(self) -> None:
        """End all episodes."""
        for environment in self._environments:
            environment.close()


def _begin(environment: InPipe, seed: int | None) -> Row:
    observation, info = environment.reset(seed=seed)
    return Row(observation, 0.0, False, False, info)


class RemoteShard:
    """A share of the environments in a process of its own."""

    def __init__(self, count: int, options: dict[str, Any]) -> None:
        context = get_context("spawn")
        self._here, there = context.Pipe()
        self._process = context.Process(target=_serve, args=(there, count, options), daemon=True)
        self._process.start()
        there.close()

    def send(self, method: str, *arguments: object) -> None:
        """Ask for a method, which begins immediately.

        Raises:
            BackendError: The process has ended.
        """
        try:
            self._here.send((method, arguments))
        except OSError as error:
            raise self._lost() from error

    def receive(self) -> Any:
        """Return what it has returned.

        Raises:
            BackendError: The process has ended.
            Exception: What it has raised.
        """
        try:
            result = self._here.recv()
        except (EOFError, OSError) as error:
            raise self._lost() from error
        if isinstance(result, Exception):
            raise result
        return result

    def close(self) -> None:
        """End the process."""
        self._here.close()
        self._process.join(_STOP_S)
        if self._process.is_alive():
            self._process.terminate()
            self._process.join()

    def _lost(self) -> BackendError:
        self._process.join(_STOP_S)
        return BackendError(
            f"a process with environments has ended, exit code {self._process.exitcode}; in a "
            "script the environments must be made under  if __name__ == '__main__':"
        )


def _serve(pipe: Connection, count: int, options: dict[str, Any]) -> None:
    """Do what the other end of the pipe asks for, until it is closed."""
    share: EnvironmentShare | None = None
    while True:
        try:
            method, arguments = pipe.recv()
        except (EOFError, KeyboardInterrupt):
            break
        try:
            share = share or EnvironmentShare(count, options)
            result = getattr(share, method)(*arguments)
        except Exception as error:
            result = error
        pipe.send(result)
        if share is not None and not isinstance(result, Exception):
            share.begin_next()
    if share is not None:
        share.close()


# --- all of them ---------------------------------------------------------------------------------


Flags = NDArray[np.bool_]


class InPipes(gymnasium.vector.VectorEnv[Observation, NDArray[np.int64], NDArray[Any]]):
    """Many robots in pipes; ``gymnasium.make_vec("pirate_sm/InPipe-v0", num_envs=32)``.

    What happens in each is the same as in an :class:`InPipe` alone, for any number of processes.
    An environment whose episode is over begins another in the next step, whose action it ignores.

    Args:
        num_envs: How many.
        workers: How many processes share them; one for each processor by default; 1: this one.
        options: Keyword arguments of :class:`InPipe`. Other processes get them pickled, so a reward
            of your own must be a function of a module.

    Raises:
        LoadError: Everything that is wrong with the files.
        UsageError: An option does not fit.
        BackendError: A process has ended; likewise in all methods.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012  # typed so by Gymnasium
        "autoreset_mode": AutoresetMode.NEXT_STEP
    }

    def __init__(self, num_envs: int = 1, *, workers: int | None = None, **options: Any) -> None:
        self._shards: list[EnvironmentShare | RemoteShard] = []
        self.num_envs = whole(num_envs, "num_envs", 1)
        count = cpu_count() or 1 if workers is None else whole(workers, "workers", 1)
        one = InPipe(**options)  # shows what is wrong before a process begins
        self.spaces = one.spaces
        self.single_action_space = one.action_space
        self.single_observation_space = one.observation_space
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        count = min(count, self.num_envs)
        bounds = [self.num_envs * i // count for i in range(count + 1)]
        self._parts = [slice(*ends) for ends in pairwise(bounds)]
        make = EnvironmentShare if count == 1 else RemoteShard
        self._shards = [make(part.stop - part.start, options) for part in self._parts]
        self._masks: Mask = np.zeros((self.num_envs, len(self.spaces.actions)), dtype=np.int8)
        self._observations: Observation = cast(
            Observation, create_empty_array(self.single_observation_space, self.num_envs)
        )

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode in each environment.

        Args:
            seed: A seed for each; an integer is that of the first, and the next ones follow.
            options: ``reset_mask`` names the environments that begin an episode, by True.
        """
        mask = (options or {}).get("reset_mask")
        chosen = [True] * self.num_envs if mask is None else np.asarray(mask, dtype=bool).tolist()
        seeds = self._seeds(seed)
        if len(chosen) != self.num_envs or not any(chosen):
            raise UsageError(f"reset_mask: expected True or False for {self.num_envs} environments")
        rows = self._ask("reset", seeds, chosen)
        infos = self._take(rows)
        return self._observed(), infos

    def step(
        self, actions: NDArray[np.int64]
    ) -> tuple[Observation, NDArray[np.float64], Flags, Flags, dict[str, Any]]:
        """Take a step in each environment, all together."""
        given = np.asarray(actions)
        if given.shape != (self.num_envs,):
            raise UsageError(f"expected {self.num_envs} actions, got the shape {given.shape}")
        rows = self._ask("step", given.tolist())
        infos = self._take(rows)
        return (
            self._observed(),
            np.array([row.reward for row in rows], dtype=np.float64),
            np.array([row.terminated for row in rows], dtype=np.bool_),
            np.array([row.truncated for row in rows], dtype=np.bool_),
            infos,
        )

    def action_masks(self) -> Mask:
        """Return 1 for each action that would be taken now, `(environments, actions)`."""
        return self._masks.copy()

    def close_extras(self, **kwargs: Any) -> None:
        """End all episodes and processes."""
        for shard in self._shards:
            shard.close()
        self._shards = []

    def _ask(self, method: str, *columns: Sequence[Any]) -> list[Any]:
        """Ask every shard for its part of the work, and return all results in order."""
        if not self._shards:
            raise UsageError("the environments have been closed")
        for shard, part in zip(self._shards, self._parts, strict=True):
            shard.send(method, *(column[part] for column in columns))
        return [row for shard in self._shards for row in shard.receive()]

    def _take(self, rows: Iterable[Row | None]) -> dict[str, Any]:
        infos: dict[str, Any] = {}
        kept = []
        for i, row in enumerate(rows):
            kept.append(self._kept(i) if row is None else row.observation)
            if row is not None:
                self._masks[i] = row.info["action_mask"]
                infos = self._add_info(infos, row.info, i)
        concatenate(self.single_observation_space, kept, self._observations)
        return infos

    def _kept(self, index: int) -> Observation:
        return {name: np.copy(column[index]) for name, column in self._observations.items()}

    def _observed(self) -> Observation:
        return {name: column.copy() for name, column in self._observations.items()}

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, int | np.integer):
            return [int(seed) + i for i in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise UsageError(f"seed: expected {self.num_envs} seeds, got {len(seed)}")
        return list(seed)
