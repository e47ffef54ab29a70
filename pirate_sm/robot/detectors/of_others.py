"""Guards detectors of other packages, so that what goes wrong in one is said to be its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import wraps
from math import inf
from typing import Any, Self, get_args

from pirate_sm.core.companion import Companion
from pirate_sm.core.effects import Effect
from pirate_sm.core.errors import DetectorError, PirateError
from pirate_sm.core.events import Event

_MOST_WORDS_OF_A_MOMENT = 1_000
_MOMENT_S = 1e-4
"""A detector that speaks more often than that within this mission time lets time stand still."""

_OPTIONAL = ("look", "restart", "follow", "word_watch", "relieve")
"""What only some companions can do: see :mod:`pirate_sm.core.companion`."""


class OfOthers:
    """A companion of another package, whose faults carry its name.

    It can do what the other one can.

    Args:
        whose: The detector, its package and its entry point.
        companion: The companion.
    """

    def __init__(self, whose: str, companion: Companion) -> None:
        self._whose = whose
        self._companion = companion
        self._entered = ExitStack()
        self._moment_s, self._left = -inf, _MOST_WORDS_OF_A_MOMENT
        for name in _OPTIONAL:
            if hasattr(companion, name):
                setattr(self, name, guarded(whose, name, getattr(companion, name)))

    @property
    def due_s(self) -> float:
        """Return the mission time of its next call."""
        with _blaming(self._whose, "due_s"):
            return float(self._companion.due_s)

    @property
    def listening(self) -> bool:
        """Return whether it waits for a person."""
        with _blaming(self._whose, "listening"):
            return bool(self._companion.listening)

    def __enter__(self) -> Self:
        """Enter the companion if it is a context manager; what it refuses is said in its words."""
        if isinstance(self._companion, AbstractContextManager):
            with _blaming(self._whose, "__enter__", lets_refuse=True):
                self._entered.enter_context(self._companion)
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the companion."""
        with _blaming(self._whose, "__exit__"):
            self._entered.close()

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Process the effects of the last step."""
        with _blaming(self._whose, "react"):
            self._companion.react(effects, now_s)

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the events due now.

        Raises:
            DetectorError: It raises, returns anything else, or does not move ``due_s`` on.
        """
        with _blaming(self._whose, "speak"):
            said = tuple(self._companion.speak(now_s))
            for each in said:
                if not isinstance(each, get_args(Event)):
                    raise TypeError(f"{each!r} is no event")
        self._keep_time(now_s)
        return said

    def _keep_time(self, now_s: float) -> None:
        if now_s > self._moment_s + _MOMENT_S:
            self._moment_s, self._left = now_s, _MOST_WORDS_OF_A_MOMENT
        self._left -= 1
        if self._left < 0:
            due = f"due_s is {self.due_s:g} s at {now_s:g} s of mission time"
            raise DetectorError(
                f"{self._whose} lets time stand still: {due}; speak must move it on"
            )


def guarded(whose: str, what: str, function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the function so that what it raises is a ``DetectorError``."""

    @wraps(function)
    def called(*arguments: Any, **options: Any) -> Any:
        with _blaming(whose, what):
            return function(*arguments, **options)

    return called


@contextmanager
def _blaming(whose: str, what: str, *, lets_refuse: bool = False) -> Iterator[None]:
    """Turn what is raised into a ``DetectorError``; ``lets_refuse``: not our own errors."""
    try:
        yield
    except (Exception, SystemExit) as error:
        if isinstance(error, DetectorError) or (lets_refuse and isinstance(error, PirateError)):
            raise
        fault = f"{type(error).__name__}: {error}"
        raise DetectorError(f"{whose} fails in {what} with {fault}") from error
