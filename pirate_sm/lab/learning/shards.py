"""Environments that share a process, here or in one of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

from pirate_sm.core.errors import BackendError
from pirate_sm.lab.learning.environment import InPipe
from pirate_sm.lab.learning.spaces import Observation

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
        """Ask for a method, which begins at once.

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
