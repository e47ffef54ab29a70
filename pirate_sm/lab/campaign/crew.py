"""Dask workers that run chunks: processes of this machine, or an existing cluster."""

from __future__ import annotations

import logging
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing import resource_tracker
from queue import Empty, Queue
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeAlias
from uuid import uuid4

from pirate_sm.core.errors import BackendError, UsageError, not_installed
from pirate_sm.lab.campaign.chunk import Chunk, OtherVersionError, Sent, bug_row, cut, run_chunk
from pirate_sm.lab.campaign.plan import CampaignPlan, code_version

if TYPE_CHECKING:
    from distributed import Client, Future, LocalCluster

_NO_ANSWER_S = 10.0
_NO_WORKERS_S = 60.0
_COUNTED_EVERY_S = 5.0
_ENDS_WITHIN_S = 10.0
_AHEAD = 2
"""A worker has a chunk under way and one waiting."""

MOST_EACH = 4
"""The most workers that are started for each processor [decided]."""

_DEATHS = 3
"""A run is to blame when so many tasks with it alone have lost their worker too often for Dask."""


Work: TypeAlias = Callable[[Chunk, Sent, str], list[Any]]
"""Runs a chunk on a worker, and returns one thing for each seed."""


class Done(NamedTuple):
    """A chunk with its results."""

    chunk: Chunk
    rows: Sequence[Any]


class ChunkRunner(Protocol):
    """Whoever runs chunks."""

    @property
    def room(self) -> int:
        """How many more chunks it can be given now."""

    def submit(self, chunk: Chunk) -> None:
        """Give it a chunk."""

    def wait(self, within_s: float) -> Sequence[Done]:
        """Return the chunks that are done, as soon as there are any or this time is over."""


class DaskCrew:
    """The workers of a Dask cluster.

    Args:
        client: Connected to the scheduler.
        plan: What is run.
        work: Runs a chunk on a worker.
    """

    def __init__(self, client: Client, plan: CampaignPlan, work: Work = run_chunk) -> None:
        self._client = client
        self._plan = plan
        self._work = work
        self._missions: dict[str, Future] = {}
        self._under_way: dict[str, tuple[Future, Chunk]] = {}
        self._ended: Queue[str] = Queue()
        self._deaths: dict[tuple[str, int], int] = {}
        self._threads = 1
        self._counted_s = -_COUNTED_EVERY_S

    def doing(self, work: Work) -> DaskCrew:
        """Return the same workers with other work."""
        return DaskCrew(self._client, self._plan, work)

    @property
    def room(self) -> int:
        """How many more chunks the workers should have; there may be more workers than before."""
        now_s = monotonic()
        if now_s - self._counted_s >= _COUNTED_EVERY_S:
            self._counted_s = now_s
            with _connected():
                self._threads = max(1, sum(self._client.nthreads().values()))
        return _AHEAD * self._threads - len(self._under_way)

    def submit(self, chunk: Chunk) -> None:
        """Send a chunk to the scheduler.

        Raises:
            BackendError: The scheduler is lost.
        """
        name = f"campaign-{chunk.cell}-{chunk.seeds[0]}-{uuid4().hex[:8]}"
        with _connected():
            future = self._client.submit(
                self._work,
                chunk,
                self._mission(chunk.mission),
                self._plan.version,
                key=name,
                pure=False,
            )
        self._under_way[name] = future, chunk
        future.add_done_callback(lambda each: self._ended.put(each.key))

    def wait(self, within_s: float) -> Sequence[Done]:
        """Return the chunks that are done, as soon as there are any or this time is over.

        Raises:
            BackendError: The scheduler is lost, or a worker cannot run a chunk.
            UsageError: A worker has another version of this program.
        """
        names = set[str]()
        with suppress(Empty):
            names.add(self._ended.get(timeout=within_s))
            while True:
                names.add(self._ended.get_nowait())
        if not names and self._client.status not in ("running", "connecting"):
            raise _lost()
        return [done for name in names if (done := self._done(name)) is not None]

    def _mission(self, key: str) -> Future:
        """Return a mission on the cluster: a task, so that Dask sends it again when it is lost."""
        if key not in self._missions:
            sent = Sent(key, self._plan.missions[key])
            self._missions[key] = self._client.submit(
                _same, sent, key=f"mission-{key}-{uuid4().hex[:8]}"
            )
        return self._missions[key]

    def _done(self, name: str) -> Done | None:
        """Return the result of a chunk; None after submitting it again."""
        if name not in self._under_way:
            return None
        future, chunk = self._under_way.pop(name)
        if future.status == "finished":
            with _connected():
                return Done(chunk, future.result())
        if future.status == "error":
            return self._failed(future, chunk)
        # Cancelled or lost: the connection to the scheduler was cut, which forgets what it has.
        if self._client.status not in ("running", "connecting"):
            raise _lost()
        self._missions.clear()
        self.submit(chunk)
        return None

    def _failed(self, future: Future, chunk: Chunk) -> Done | None:
        """Handle a task that has raised an exception, or has lost its worker again and again."""
        from distributed.scheduler import KilledWorker

        error = future.exception()
        if isinstance(error, OtherVersionError):
            raise _other_version({"a worker": str(error)})
        if not isinstance(error, KilledWorker):
            raise BackendError(f"a worker cannot run a chunk: {type(error).__name__}: {error}")
        if len(chunk.seeds) > 1:  # one of them may be to blame, not all
            for seed in chunk.seeds:
                self.submit(cut(chunk, [seed]))
            return None
        one = chunk.cell, chunk.seeds[0]
        self._deaths[one] = self._deaths.get(one, 0) + 1
        if self._deaths[one] < _DEATHS:
            self.submit(chunk)
            return None
        return Done(chunk, [bug_row(*one, "the worker process died each time", {})])


def _same(sent: Sent) -> Sent:
    return sent


def most_workers() -> int:
    """Return how many workers are started on this machine at most."""
    from dask.system import CPU_COUNT

    return MOST_EACH * int(CPU_COUNT)


@contextmanager
def connected(
    plan: CampaignPlan, scheduler: str | None = None, workers: int | None = None
) -> Iterator[DaskCrew]:
    """Yield the workers of a cluster, or of processes that are started here.

    Args:
        plan: What is run.
        scheduler: Address of an existing scheduler.
        workers: How many processes are started without one; one for each processor by default.

    Raises:
        UsageError: No scheduler answers, it has no workers, or a worker has another version.
    """
    with _client(scheduler, workers) as client:
        if scheduler is not None:
            _refuse_others(client, plan.version, scheduler)
        yield DaskCrew(client, plan)


@contextmanager
def _client(scheduler: str | None, workers: int | None) -> Iterator[Client]:
    try:
        import dask
        from distributed import Client
    except ModuleNotFoundError as error:
        raise not_installed("a campaign", error.name, "campaign") from None
    # What happens to workers is said in our words, or repaired silently.
    for name in ("distributed", "distributed.client"):  # Dask gives its client a level of its own
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    if scheduler is None:
        with dask.config.set({"logging.distributed": "critical"}), _started(workers) as cluster:
            yield cluster.get_client()
        return
    try:
        client = Client(scheduler, timeout=_NO_ANSWER_S)
    except (OSError, TimeoutError, ValueError, TypeError) as error:
        raise UsageError(
            f"no Dask scheduler answers at '{scheduler}': {str(error) or type(error).__name__}"
        ) from None
    with client:
        yield client


@contextmanager
def _started(workers: int | None) -> Iterator[LocalCluster]:
    """Yield a cluster of processes that do not hear Ctrl-C, which this process answers.

    Ctrl-C while it starts or ends is answered afterwards, so that no process of it stays.

    Raises:
        UsageError: So many processes cannot be started.
    """
    from distributed import LocalCluster

    with ExitStack() as stack:
        with _signals_wait():
            try:
                cluster = LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    dashboard_address=None,
                    # Without a dashboard too, a scheduler serves its state, at one usual port.
                    scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
                    silence_logs=logging.CRITICAL,
                )
            except (OSError, RuntimeError, TimeoutError) as error:
                raise UsageError(
                    f"the workers cannot be started ({str(error) or type(error).__name__}): try "
                    "fewer with --workers"
                ) from None
            stack.callback(_end, cluster)
        yield cluster


def _end(cluster: LocalCluster) -> None:
    """End the client and the processes of a cluster."""
    with _signals_wait():
        cluster.get_client().close()
        cluster.close(_ENDS_WITHIN_S)


@contextmanager
def _signals_wait() -> Iterator[None]:
    """Let signals that ask for an end wait, also in processes and threads that are started here.

    Processes that are started later by these threads do not hear them either.
    """
    resource_tracker.ensure_running()  # starting later, it would let signals through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _refuse_others(client: Client, version: str, scheduler: str) -> None:
    """Check that there are workers, and that all have the client's version of this program.

    Workers that come later are checked when they get work.

    Raises:
        UsageError: There is no worker, or some have another version.
    """
    try:
        client.wait_for_workers(1, timeout=_NO_WORKERS_S)
    except TimeoutError:
        raise UsageError(
            f"the scheduler at '{scheduler}' has no workers: start some with "
            f"`dask worker {scheduler} --nthreads 1`"
        ) from None
    found: dict[str, Any] = client.run(_version_there, on_error="return")
    others = {worker: str(each) for worker, each in found.items() if each != version}
    if others:
        raise _other_version(others)


def _version_there() -> str:
    return code_version()


def _other_version(others: dict[str, str]) -> UsageError:
    which = "; ".join(f"{worker} has {version}" for worker, version in sorted(others.items()))
    return UsageError(
        f"workers run another version of pirate-sm than this one, {code_version()}: {which}; "
        "install the same code on all"
    )


@contextmanager
def _connected() -> Iterator[None]:
    """Turn errors of a lost connection into one of ours."""
    from distributed.comm.core import CommClosedError

    try:
        yield
    except (OSError, CommClosedError, TimeoutError) as error:
        raise _lost(error) from None


def _lost(error: object = "") -> BackendError:
    why = f": {error}" if str(error) else ""
    return BackendError(
        f"the connection to the Dask scheduler is lost{why}; results so far are kept: continue "
        "with --resume"
    )
