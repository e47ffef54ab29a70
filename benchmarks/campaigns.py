"""What a campaign costs: two workers beside one, the client, memory, and many runs from that.

    python -m benchmarks.campaigns [--runs 600] [--pairs 3] [--warm 200] [--bends 10000]

The bend with varied start, friction and diameter, on Dask workers of one thread, each a process;
the scheduler is a process of its own. In turns one worker and two run the same missions, without
any check; the best of each counts. Printed are:

- missions per hour of one and of two workers, from the first chunk to the last; bar 1.8 x;
- the client's processor time for a mission; bar 2 ms; and the scheduler's;
- how much memory a worker has gained since its first 200 missions, or what ``--warm`` says; bar
  8 MB, for it goes up and down by 5 MB;
- the bytes in the store for a mission;
- how many missions an hour the client, the scheduler and the store would pass if a mission took no
  time: two workers that answer at once;
- from these: the time of 10^6 and 10^8 missions on 10, 100, 1,000 and 10,000 workers, and what
  limits it.

With ``--bends`` a campaign of so many bends runs afterwards on all processors, with its table;
bar for 10,000 on two processors: 15 minutes.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time
from typing import NamedTuple

from distributed import Client

from benchmarks.dask_cluster import Cluster
from pirate_sm.lab.campaign.campaign_file import read_campaign
from pirate_sm.lab.campaign.chunk import Chunk, RunRow, Sent
from pirate_sm.lab.campaign.conductor import Conductor
from pirate_sm.lab.campaign.crew import connected
from pirate_sm.lab.campaign.plan import CampaignPlan, mark_of
from pirate_sm.lab.campaign.results import as_text, result_of
from pirate_sm.lab.campaign.store import Store

BEND = Path(__file__).parents[1] / "campaigns" / "bend.yaml"
TWICE, CLIENT_S, GAINED_MB, BENDS_S = 1.8, 0.002, 8.0, 900.0
INSTANT = 40_000
"""Missions that take no time."""

WARM = 200
"""A worker compiles, loads and fills its caches in its first missions."""


class Measured(NamedTuple):
    """What a campaign cost.

    Attributes:
        per_hour: Missions.
        client_s: Processor time of the client for a mission; likewise ``scheduler_s``.
        gained_mb: Memory that the worker with the largest gain has gained.
        stored: Bytes for a mission.
    """

    per_hour: float
    client_s: float
    scheduler_s: float
    gained_mb: float
    stored: float


def main() -> int:
    """Print what was measured; return 1 when a bar is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=600)
    parser.add_argument("--pairs", type=int, default=3)
    parser.add_argument("--warm", type=int, default=WARM, help="runs of each worker before that")
    parser.add_argument("--instant", type=int, default=INSTANT, help="missions without work")
    parser.add_argument("--bends", type=int, default=0)
    wishes = parser.parse_args()
    bends = _bends(wishes.runs)
    found: dict[int, list[Measured]] = {1: [], 2: []}
    for _ in range(wishes.pairs):
        for workers, measured in found.items():
            measured.append(_measure(bends, workers, wishes.warm))
            print(f"{workers} worker{'s' * (workers > 1)}: {_said(measured[-1])}", flush=True)
    good = _show(found, _ceiling_s(_bends(wishes.instant)))
    if wishes.bends:
        good &= _many(_bends(wishes.bends))
    return 0 if good else 1


def _bends(runs: int) -> CampaignPlan:
    plan = read_campaign(BEND, range(runs), check=False)
    return replace(plan, cells=plan.cells[:1])


@contextmanager
def _cluster(workers: int) -> Iterator[tuple[str, int]]:
    """Yield the address of a scheduler with so many workers, and the scheduler's process."""
    with ExitStack() as stack:
        cluster = Cluster(stack)
        for _ in range(workers):
            cluster.add_worker()
        with Client(cluster.address, timeout=30) as client:
            client.wait_for_workers(workers, timeout=60)
        yield cluster.address, cluster.scheduler.pid


def _measure(plan: CampaignPlan, workers: int, each: int) -> Measured:
    """Run a campaign, with workers that are warm."""
    with _cluster(workers) as (address, scheduler), TemporaryDirectory() as folder:
        warm = replace(
            plan, cells=(replace(plan.cells[0], key="warm", seeds=range(each * workers)),)
        )
        _conduct(warm, address, Path(folder) / "warm")
        before = _memory_mb(address)
        scheduler_s, client_s, began = _cpu_s(scheduler), process_time(), perf_counter()
        _conduct(plan, address, Path(folder) / "measured")
        took_s, client_s = perf_counter() - began, process_time() - client_s
        scheduler_s = _cpu_s(scheduler) - scheduler_s
        after = _memory_mb(address)
        files = (Path(folder) / "measured").rglob("*.parquet")
        runs = len(plan.cells[0].seeds)
        return Measured(
            runs / took_s * 3600,
            client_s / runs,
            scheduler_s / runs,
            max(after[worker] - before[worker] for worker in before),
            sum(file.stat().st_size for file in files) / runs,
        )


def _conduct(plan: CampaignPlan, address: str, folder: Path) -> None:
    store = Store(folder)
    store.begin(mark_of(plan))
    conductor = Conductor(plan, store)
    with connected(plan, address) as crew:
        conductor.conduct(crew)
    store.close()


def _cpu_s(process: int) -> float:
    fields = Path(f"/proc/{process}/stat").read_text("utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _memory_mb(address: str) -> dict[str, float]:
    """Return the memory of each worker, by its address."""
    with Client(address) as client:
        return dict(client.run(_resident_mb))


def _resident_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text("utf-8").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def _said(measured: Measured) -> str:
    return (
        f"{measured.per_hour:9,.0f} missions an hour; client {measured.client_s * 1000:.2f} ms and "
        f"scheduler {measured.scheduler_s * 1000:.2f} ms a mission; memory "
        f"{measured.gained_mb:+.1f} MB; {measured.stored:.0f} bytes stored a mission"
    )


def _ceiling_s(plan: CampaignPlan) -> float:
    """Return how long client, scheduler and store take for a mission that takes no time."""
    with _cluster(2) as (address, _), TemporaryDirectory() as folder:
        store = Store(Path(folder))
        store.begin(mark_of(plan))
        conductor = Conductor(plan, store)
        with connected(plan, address) as crew:
            began = perf_counter()
            conductor.conduct(crew.doing(_at_once))
        store.close()
        return (perf_counter() - began) / len(plan.cells[0].seeds)


def _at_once(chunk: Chunk, sent: Sent, version: str) -> list[RunRow]:
    values = (True, "", 30.0, 0.8, -0.03, 0.001)
    return [RunRow(chunk.cell, seed, "succeeded", "passed", "", *values) for seed in chunk.seeds]


def _show(found: dict[int, list[Measured]], ceiling_s: float) -> bool:
    one, two = (max(measured, key=lambda each: each.per_hour) for measured in found.values())
    every = [each for measured in found.values() for each in measured]
    ratio = two.per_hour / one.per_hour
    client_s = min(each.client_s for each in every)
    gained_mb = min(each.gained_mb for each in found[1])
    print(f"two workers {ratio:.2f} x one (bar {TWICE} x)")
    print(f"client {client_s * 1000:.2f} ms of processor a mission (bar {CLIENT_S * 1000:.0f} ms)")
    print(f"memory of a worker {gained_mb:+.1f} MB (bar {GAINED_MB:.0f} MB)")
    _extrapolate(one, ceiling_s)
    return ratio >= TWICE and client_s <= CLIENT_S and gained_mb <= GAINED_MB


def _extrapolate(one: Measured, ceiling_s: float) -> None:
    """Print how long many missions take, and what limits them."""
    mission_s = 3600 / one.per_hour
    print(
        f"if a mission took no time: {3600 / ceiling_s:,.0f} an hour; one takes "
        f"{mission_s * 1000:.0f} ms, so {mission_s / ceiling_s:,.0f} workers are the most"
    )
    for missions in (10**6, 10**8):
        for workers in (10, 100, 1_000, 10_000):
            limit = "the workers" if mission_s / workers > ceiling_s else "client and scheduler"
            hours = missions * max(mission_s / workers, ceiling_s) / 3600
            print(
                f"    {missions:11,} missions on {workers:6,} workers: {hours:9,.2f} h, limited by "
                f"{limit}; {missions * one.stored / 1e9:.2f} GB stored"
            )


def _many(plan: CampaignPlan) -> bool:
    """Run many bends on all processors of this machine and print the table."""
    began = perf_counter()
    with TemporaryDirectory() as folder:
        store = Store(Path(folder))
        store.begin(mark_of(plan))
        conductor = Conductor(plan, store)
        with connected(plan) as crew:
            conductor.conduct(crew)
        store.close()
        print(as_text(result_of(plan, conductor.results, store.recordings)), end="")
    took_s = perf_counter() - began
    runs = len(plan.cells[0].seeds)
    print(f"{runs:,} bends in {took_s / 60:.1f} min (bar {BENDS_S * runs / 10_000 / 60:.1f} min)")
    return took_s <= BENDS_S * runs / 10_000


if __name__ == "__main__":
    sys.exit(main())
