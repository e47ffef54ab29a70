"""Runs a mission to its end, once or with many seeds, and starts batches of simulated robots."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from functools import partial
from multiprocessing import get_context, parent_process
from os import PathLike, cpu_count
from typing import TYPE_CHECKING, NamedTuple, Unpack

from pirate_sm.api.arguments import Mission, loaded_once, prepared, whole
from pirate_sm.api.result import Columns, Run, noted
from pirate_sm.core.companion import entered
from pirate_sm.core.errors import BackendError, ExitCode, UsageError
from pirate_sm.core.options import Options
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring.adoption import adopt_alone

if TYPE_CHECKING:
    from pirate_sm.simulation.batch import Batch


def run(
    mission: Mission,
    backend: str = "sim",
    *,
    seed: int = 0,
    record: str | PathLike[str] | None = None,
    check: bool = True,
    yes: bool = False,
    adopt: bool = False,
    **options: Unpack[Options],
) -> Run:
    """Run a mission to its end, as fast as the backend goes; nobody is asked anything.

    Questions of the mission get their first answer. Whatever happens, the robot is brought to its
    safe state: also on Ctrl-C, which is raised afterwards.

    Args:
        mission: A shipped mission's name, the path of a file, or what :func:`load` has returned.
        backend: Name of a backend: ``sim``, ``physics``, ``trace``, ``serial``, or another's.
        seed: Of everything random; equal seeds give equal runs.
        record: A file for a recording, which must not exist yet.
        check: Whether a mission in which the check finds errors is refused.
        yes: Whether you agree that a real robot moves.
        adopt: Whether a robot that stands elsewhere than declared is taken as its sensors show it.
        options: :class:`~pirate_sm.core.options.Options`, such as ``pipe``, ``defects``.

    Raises:
        LoadError: Everything that is wrong with the files; ``problems`` has each with its place.
        CheckError: The mission is refused; ``findings`` has why, each with its place.
        UsageError: An argument does not fit, or an extra is not installed.
        RecordingError: The recording cannot be begun.
        BackendError: The backend cannot be opened.
    """
    ready = prepared(mission, backend, seed, check=check, yes=yes, **options)
    with ExitStack() as stack:
        ready, resuming = adopt_alone(ready, stack) if adopt else (ready, None)
        notes = stack.enter_context(noted(ready, record, lambda: mission_run.state))
        stack.enter_context(entered(ready.companions))
        nobody = [] if ready.attended else [FirstChoice("nobody is asked")]
        companions = (*ready.companions, *nobody)
        mission_run = MissionRun(
            ready.engine, ready.backend, companions=companions, tap=notes, resuming=resuming
        )
        result = mission_run.execute()
    if result.error is not None:
        if result.exit_code == ExitCode.BUG:
            raise result.error
        if mission_run.state is None:
            raise BackendError(result.ended.message) from result.error
    if result.exit_code == ExitCode.INTERRUPTED:
        raise KeyboardInterrupt(result.ended.message)
    return notes.run(ready.parting())


def batch(
    mission: Mission,
    seeds: Iterable[int] = range(32),
    *,
    backend: str = "sim",
    threads: int | None = None,
    check: bool = False,
    **options: Unpack[Options],
) -> Batch:
    """Return simulated robots where a mission begins, one for each seed.

    Args:
        mission: A shipped mission's name, the path of a file, or what :func:`load` has returned.
        seeds: The seeds.
        backend: ``sim`` or ``physics``.
        threads: How many threads share the work; one for each processor by default.
        check: Whether a mission in which the check finds errors is refused.
        options: :class:`~pirate_sm.core.options.Options`, such as ``pipe``, ``defects``.

    Raises:
        LoadError: Everything that is wrong with the files; ``problems`` has each with its place.
        CheckError: The mission is refused; ``findings`` has why, each with its place.
        UsageError: An argument does not fit, there are no seeds, or the backend simulates no robot.
    """
    from pirate_sm.simulation.backend import SimulatorBackend
    from pirate_sm.simulation.batch import Batch

    count = None if threads is None else whole(threads, "threads", 1)
    loaded, rest = loaded_once(mission, **options)
    robots, link = [], None
    for seed in seeds:
        ready = prepared(loaded, backend, seed, check=check, yes=False, **rest)
        if not isinstance(ready.backend, SimulatorBackend):
            raise UsageError(f"the backend {backend} simulates no robot; take 'sim' or 'physics'")
        robots.append(ready.backend.robot)
        link = ready.loaded.loaded_robot.profile.link
        check = False  # the files are the same for every seed
    if link is None:
        raise UsageError("seeds: a batch has one robot at least")
    return Batch(robots, link, count)


class _Row(NamedTuple):
    """How one run ended: a row of the table."""

    seed: int
    outcome: str
    end: str
    message: str
    duration_s: float


def sweep(
    mission: Mission,
    seeds: Iterable[int] = range(100),
    *,
    backend: str = "sim",
    workers: int | None = None,
    check: bool = True,
    **options: Unpack[Options],
) -> Columns:
    """Run a mission once with each seed; return a table with a row for each, in their order.

    The columns are ``seed``, ``outcome``, ``end``, ``message`` and ``duration_s``. They are the
    same for any number of processes. A script that calls this with several of them must do so
    under ``if __name__ == "__main__":``, for they import it.

    Args:
        mission: A shipped mission's name, the path of a file, or what :func:`load` has returned.
        seeds: The seeds.
        backend: Name of a backend that can run many times at once.
        workers: How many processes share the work; 1: this one does all. One for each processor
            by default.
        check: Whether a mission in which the check finds errors is refused.
        options: :class:`~pirate_sm.core.options.Options`, such as ``pipe``, ``defects``.

    Raises:
        LoadError: Everything that is wrong with the files; ``problems`` has each with its place.
        CheckError: The mission is refused; ``findings`` has why, each with its place.
        UsageError: An argument does not fit, or an extra is not installed.
    """
    given: object = seeds
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise UsageError(f"seeds: expected whole numbers such as range(100), got {seeds!r}")
    wanted = [whole(seed, "seeds", 0) for seed in seeds]
    if not wanted:
        raise UsageError("seeds: a sweep has one seed at least")
    if options.get("view"):
        raise UsageError("a sweep opens no viewer: run the seed that you want to see")
    count = cpu_count() or 1 if workers is None else whole(workers, "workers", 1)
    count = min(count, len(wanted))
    if count > 1 and parent_process() is not None:
        raise UsageError(
            "a process of a sweep has come to a sweep itself: put the script's own work under "
            "`if __name__ == '__main__':`, for every process imports the script"
        )
    loaded, rest = loaded_once(mission, **options)
    # Compiles the simulator before the others need it, and finds whatever does not fit.
    prepared(loaded, backend, 0, check=check, yes=False, **rest)
    one = partial(_run, loaded, backend, rest)
    if count <= 1:
        ended = [one(seed) for seed in wanted]
    else:
        with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
            ended = list(pool.map(one, wanted, chunksize=-(-len(wanted) // (4 * count))))
    return {name: [row[n] for row in ended] for n, name in enumerate(_Row._fields)}


def _run(mission: Mission, backend: str, options: Options, seed: int) -> _Row:
    """Return how the mission ends with one seed."""
    ready = prepared(mission, backend, seed, check=False, yes=False, **options)
    companions = ready.companions if ready.attended else (*ready.companions, FirstChoice())
    result = MissionRun(ready.engine, ready.backend, companions=companions).execute()
    if result.error is not None and result.exit_code == ExitCode.BUG:
        raise result.error
    if result.exit_code == ExitCode.INTERRUPTED:
        raise KeyboardInterrupt(result.ended.message)
    ended = result.ended
    return _Row(seed, ended.outcome, ended.end, ended.message, result.now_s)
