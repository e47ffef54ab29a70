"""Shares the checks of missions and campaigns out to processes, so that all processors work.

Each process is a copy of this one while that has a single thread. It returns what its check makes,
with what it has asked of the disk and what is to be kept of it. What none returns is made here.
"""

from __future__ import annotations

import os
import re
import signal
import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.process import BaseProcess
from threading import Thread
from typing import Any, Final, TypeAlias

from pirate_sm.checking.kept_results import add_waiting, take_waiting
from pirate_sm.checking.project_files import CheckTarget
from pirate_sm.core.documents import FileKind
from pirate_sm.core.on_disk import DiskAnswers, noting, opened

MOST_PROCESSES: Final = 8
"""More are not made, however many processors there are: each holds explorations. [decided]"""

Make: TypeAlias = Callable[[CheckTarget], dict[str, Any]]
"""Returns what the check of a file adds to a report, as JSON."""

_Made: TypeAlias = tuple[dict[str, Any], DiskAnswers, dict[str, Any]]

_make: Make


@contextmanager
def shared_out(targets: Sequence[CheckTarget], make: Make) -> Iterator[Make]:
    """Return a context with a function for ``make``, which processes do in advance.

    Args:
        targets: The files that are to be checked and take long.
        make: Checks one.
    """
    before = active_children()
    groups = _groups(targets) if _can_copy() else []
    count = min(len(os.sched_getaffinity(0)), MOST_PROCESSES, len(groups)) if groups else 0
    if count < 2:
        yield make
        return
    pool: ProcessPoolExecutor | None = None
    making: dict[CheckTarget, tuple[Future[list[_Made]], int]] = {}
    try:
        try:
            with _uninterrupted():
                copies = get_context("fork")
                pool = ProcessPoolExecutor(count, copies, initializer=_begin, initargs=(make,))
                for group in groups:
                    future = pool.submit(_make_all, group)
                    making |= {target: (future, number) for number, target in enumerate(group)}
        except (OSError, RuntimeError):  # the system refuses processes
            pool, making = None, {}  # its thread may not have begun, and cannot be waited for
            _end_new(before)
        yield lambda target: _made(making.get(target), target, make)
    except BaseException:
        _end_new(before)
        raise
    finally:
        if pool is not None:
            pool.shutdown(cancel_futures=True)


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Return a context that Ctrl-C waits for: in one of Python's hooks of a fork it is lost."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_new(before: Collection[BaseProcess]) -> None:
    for each in active_children():
        if each not in before:
            each.terminate()


def _can_copy() -> bool:
    """Return whether this process has a single thread, also none that Python knows nothing of."""
    if sys.platform != "linux":
        return False
    with suppress(OSError):  # some containers have no /proc
        return len(os.listdir("/proc/self/task")) == 1  # noqa: PTH208
    return False


def _groups(targets: Sequence[CheckTarget]) -> list[list[CheckTarget]]:
    """Return the files, the most first, a campaign together with the missions that it names.

    A process explores a mission once for all that run it.
    """
    groups: list[set[CheckTarget]] = [{each} for each in targets]
    for campaign in (each for each in targets if each.kind is FileKind.CAMPAIGN):
        named = _words(campaign)
        one = {each for each in targets if each == campaign or each.path.stem in named}
        apart = [each for each in groups if each.isdisjoint(one)]
        groups = [*apart, one.union(*(each for each in groups if each not in apart))]
    ordered = sorted(groups, key=len, reverse=True)
    return [[each for each in targets if each in group] for group in ordered]


def _words(target: CheckTarget) -> set[str]:
    try:
        with opened(target.path) as stream:
            return {*re.findall(r"\w+", stream.read().decode("utf-8", errors="replace"))}
    except (OSError, ValueError):
        return set()


def _begin(make: Make) -> None:
    """Begin a process, which Ctrl-C ends with the command, and whatever ends the command too."""
    global _make  # noqa: PLW0603 - a process has one
    _make = make
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        Thread(target=_end_with_the_command, daemon=True).start()
    except RuntimeError:  # the system refuses threads; nothing else would end this process
        os._exit(1)


def _end_with_the_command() -> None:
    command = parent_process()
    if command is not None:
        command.join()
    os._exit(1)


def _make_all(targets: Sequence[CheckTarget]) -> list[_Made]:
    found: list[_Made] = []
    for target in targets:
        with noting() as asked:
            made = _make(target)
        found.append((made, asked, take_waiting()))
    return found


def _made(
    making: tuple[Future[list[_Made]], int] | None, target: CheckTarget, make: Make
) -> dict[str, Any]:
    """Return what a process has made of a file, or make it here."""
    if making is not None:
        future, number = making
        with suppress(Exception):  # what it raises is raised again here, unless it was ended
            made, asked, waiting = future.result()[number]
            asked.repeat()
            add_waiting(waiting)
            return made
    return make(target)
