"""Asks the check about a mission, in a process of its own so that the stop waits for nothing.

A thread would not do: the threads of a Python process take turns, and a stop would wait for its
turn after the search, up to some tens of milliseconds.
"""

from __future__ import annotations

import signal
from asyncio import CancelledError
from collections.abc import Callable
from contextlib import suppress
from functools import cache, cached_property
from io import BytesIO
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pickle import HIGHEST_PROTOCOL, Pickler, Unpickler
from threading import Lock
from traceback import format_exc
from typing import Any, Final, NamedTuple, ParamSpec, Protocol, Self, TypeVar, cast

from pirate_sm.core.loading import LoadedMission
from pirate_sm.running.runtime.ending import BY_SIGNAL

_P = ParamSpec("_P")
_R = TypeVar("_R")

_DEAF_TO: Final = frozenset(BY_SIGNAL) - {signal.SIGTERM}
"""Signals that mean the console alone; the process ends with it."""

_TRIES: Final = 2
"""A process that has died, perhaps for want of memory, is replaced once per question."""

_LOOK_EVERY_S = 0.05


class CheckCall(Protocol):
    """Calls a function with its arguments, and returns its result."""

    def __call__(self, function: Callable[_P, _R], *arguments: _P.args, **named: _P.kwargs) -> _R:
        """Return the function's result."""
        ...


def ask_here(function: Callable[_P, _R], *arguments: _P.args, **named: _P.kwargs) -> _R:
    """Call the function in this process."""
    return function(*arguments, **named)


class CheckProcess:
    """Calls functions in another process, one at a time, while it is entered.

    Their arguments and results must be such as :mod:`pickle` takes. A mission among the arguments
    is sent once and kept until another one is sent.

    Args:
        leaving: Returns whether nobody needs answers any more; may be called from any thread.
    """

    def __init__(self, leaving: Callable[[], bool] = lambda: False) -> None:
        self._leaving = leaving
        self._turn = Lock()
        self._mission: LoadedMission | None = None
        self._process: BaseProcess | None = None
        self._connection: Connection | None = None
        self._left = False

    def __enter__(self) -> Self:
        """Start the process."""
        self._start()
        return self

    def __exit__(self, *_: object) -> None:
        """End the process, whatever it is doing; who still waits for an answer gets none."""
        self._left = True
        self._end()

    def ask(self, function: Callable[_P, _R], *arguments: _P.args, **named: _P.kwargs) -> _R:
        """Call the function there and wait for its result.

        Raises:
            CancelledError: Nobody needs the answer any more; leaving must not wait for it.
            RuntimeError: The function has raised, or the process has died repeatedly.
        """
        with self._turn:
            for _ in range(_TRIES):
                with suppress(EOFError, OSError):
                    answer = self._answer(_Call(function, arguments, named))
                    return cast(_R, answer)
                self._end()
                if not self._left:
                    self._start()
                if self._left:  # also while it was started, so that it does not stay
                    self._end()
                    raise CancelledError
        raise RuntimeError("the process that checks missions has ended by itself")

    def _answer(self, call: _Call) -> Any:
        assert self._connection is not None
        mission = next((a for a in call.arguments if isinstance(a, LoadedMission)), None)
        if mission is not None and mission is not self._mission:
            self._connection.send_bytes(_packed(mission, None))
            self._mission = mission
        self._connection.send_bytes(_packed(call, self._mission))
        while not self._connection.poll(_LOOK_EVERY_S):
            if self._leaving():
                raise CancelledError
        answer = self._connection.recv()
        if isinstance(answer, _Raised):
            error = RuntimeError(answer.text.strip().splitlines()[-1])
            error.add_note(answer.text)
            raise error
        return answer

    def _start(self) -> None:
        context = get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs,), daemon=True)
        process.start()
        self._process = process  # only now, since it may be ended meanwhile
        theirs.close()
        self._connection, self._mission = ours, None

    def _end(self) -> None:
        if self._connection is not None:
            self._connection.close()
        if self._process is not None:
            self._process.kill()
            self._process.join()


class _Call(NamedTuple):
    """A function and its arguments."""

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    named: dict[str, Any]


class _Raised(NamedTuple):
    """The traceback of what a function has raised."""

    text: str


class _PlainPickler(Pickler):
    """Writes what objects are made of, without the cached properties they have worked out.

    Another thread, which runs the mission, may be adding to those at any moment.
    """

    def reducer_override(self, each: Any) -> Any:
        """Return how to write an object with cached properties; any other as usual."""
        cached = _cached(each.__class__)
        if not cached:
            return NotImplemented
        make, arguments, state = each.__reduce_ex__(HIGHEST_PROTOCOL)[:3]
        # A copy is made at once: no other thread of Python runs meanwhile.
        kept = {name: it for name, it in (state or {}).copy().items() if name not in cached}
        return make, arguments, kept


@cache
def _cached(kind: type) -> frozenset[str]:
    """Return the names of the cached properties of a class."""
    found = (vars(each).items() for each in kind.__mro__)
    return frozenset(name for of in found for name, it in of if isinstance(it, cached_property))


class _Packer(_PlainPickler):
    """Writes a reference instead of the mission that the other process has."""

    mission: LoadedMission | None = None

    def persistent_id(self, each: Any) -> str | None:
        return "mission" if each is self.mission and each is not None else None


class _Unpacker(Unpickler):
    mission: LoadedMission | None = None

    def persistent_load(self, _: Any) -> LoadedMission | None:
        return self.mission


def _packed(what: object, mission: LoadedMission | None) -> bytes:
    file = BytesIO()
    packer = _Packer(file)
    packer.mission = mission
    packer.dump(what)
    return file.getvalue()


def _serve(connection: Connection) -> None:
    """Answer calls until the console is gone."""
    for number in _DEAF_TO:
        signal.signal(number, signal.SIG_IGN)
    mission: LoadedMission | None = None
    with suppress(EOFError, OSError):
        while True:
            unpacker = _Unpacker(BytesIO(connection.recv_bytes()))
            unpacker.mission = mission
            what = unpacker.load()
            if isinstance(what, LoadedMission):
                mission = what
                continue
            connection.send(_result(what))


def _result(call: _Call) -> Any:
    try:
        return call.function(*call.arguments, **call.named)
    except Exception:
        return _Raised(format_exc())
