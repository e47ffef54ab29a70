"""Threads that share work whose long part is machine code, for which no other thread waits."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from typing import Self, TypeVar

_T = TypeVar("_T")


class Crew:
    """Does the same work for many things at once.

    Args:
        threads: How many threads work at once, the caller's included; one for each processor by
            default.
    """

    def __init__(self, threads: int | None = None) -> None:
        self.threads = threads or cpu_count() or 1
        self._helpers = ThreadPoolExecutor(self.threads - 1) if self.threads > 1 else None

    def __enter__(self) -> Self:
        """Begin."""
        return self

    def __exit__(self, *error: object) -> None:
        """Let the threads go."""
        if self._helpers is not None:
            self._helpers.shutdown()

    def each(self, work: Callable[[_T], object], things: Iterable[_T]) -> None:
        """Do the work for each thing; whoever is free takes the next one.

        Raises:
            Exception: What the work has raised, after the others have done theirs.
        """
        left = deque(things)

        def share() -> None:
            while True:
                try:
                    thing = left.popleft()
                except IndexError:
                    return
                work(thing)

        helpers = []
        if self._helpers is not None:
            wanted = min(self.threads, len(left)) - 1
            helpers = [self._helpers.submit(share) for _ in range(wanted)]
        try:
            share()
        finally:
            errors = [helper.exception() for helper in helpers]
        for error in errors:
            if error is not None:
                raise error
