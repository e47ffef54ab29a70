"""Campaigns on Dask clusters of processes of their own, over TCP on loopback.

The workers are killed, the connection is cut and the client is killed; the table stays the same.
"""

from __future__ import annotations

import logging
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from threading import Event

import pytest

from benchmarks.dask_cluster import Cluster, Relay, kill
from pirate_sm.core.errors import BackendError, UsageError
from pirate_sm.lab.campaign import crew as crews
from pirate_sm.lab.campaign.campaign_file import read_campaign
from pirate_sm.lab.campaign.conductor import Conductor, Progress
from pirate_sm.lab.campaign.crew import connected
from pirate_sm.lab.campaign.plan import CampaignPlan, mark_of
from pirate_sm.lab.campaign.results import as_text, result_of
from pirate_sm.lab.campaign.store import Store

from .rows import row

TRIAL = """\
format: 1
campaign: trial
missions: [enter_2d, climb]
defects: [none, stale_repeats]
jitter: {friction: 20 %}
seeds: 0..119
"""
PIRATE = (sys.executable, "-c", "from pirate_sm.cli.start import main; main()")


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> CampaignPlan:
    file = tmp_path_factory.mktemp("campaign") / "trial.yaml"
    file.write_text(TRIAL)
    return read_campaign(file, check=False)


@pytest.fixture(scope="module")
def expected(plan: CampaignPlan, tmp_path_factory: pytest.TempPathFactory) -> str:
    return table(plan, tmp_path_factory.mktemp("one") / "results", None, workers=1)


def table(
    plan: CampaignPlan,
    folder: Path,
    scheduler: str | None,
    workers: int | None = None,
    show: Callable[[Progress], None] = lambda progress: None,
) -> str:
    store = Store(folder)
    store.begin(mark_of(plan))
    try:
        conductor = Conductor(plan, store)
        with connected(plan, scheduler, workers) as crew:
            conductor.conduct(crew, show)
    finally:
        store.close()
    return as_text(result_of(plan, conductor.results, folder)).replace(str(folder), "FOLDER")


@pytest.fixture
def cluster() -> Iterator[Cluster]:
    with ExitStack() as stack:
        yield Cluster(stack)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_the_table_is_the_same_on_a_cluster_with_workers_that_die_and_come(
    plan: CampaignPlan, expected: str, cluster: Cluster, tmp_path: Path
) -> None:
    doomed = [cluster.add_worker() for _ in range(2)]
    due = [60, 140, 220, 300]

    def kill_when_due(progress: Progress) -> None:
        if due and progress.done >= due[0]:
            due.pop(0)
            kill(doomed.pop(0))
            doomed.append(cluster.add_worker())

    assert table(plan, tmp_path / "results", cluster.address, show=kill_when_due) == expected
    assert due == []


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_connection_that_is_cut_is_made_again(
    plan: CampaignPlan, expected: str, cluster: Cluster, tmp_path: Path
) -> None:
    cluster.add_worker()
    cluster.add_worker()
    relay = Relay(cluster.address)
    cut = Event()

    def cut_once(progress: Progress) -> None:
        if progress.done >= 100 and not cut.is_set():
            cut.set()
            relay.cut()

    with relay:
        assert table(plan, tmp_path / "results", relay.address, show=cut_once) == expected
    assert cut.is_set()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_scheduler_that_is_gone_ends_the_campaign_and_results_are_kept(
    plan: CampaignPlan, expected: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    gone = Event()
    with ExitStack() as stack:
        cluster = Cluster(stack)
        cluster.add_worker()

        def end(progress: Progress) -> None:
            if progress.done >= 100 and not gone.is_set():
                gone.set()
                stack.close()

        with pytest.raises(BackendError, match="continue with --resume"):
            table(plan, tmp_path / "results", cluster.address, show=end)

    assert "Traceback" not in capfd.readouterr().err
    assert sum(len(rows) for rows in Store(tmp_path / "results").read()) >= 100
    assert table(plan, tmp_path / "results", None, workers=2) == expected


@pytest.mark.slow
def test_a_client_that_is_killed_goes_on(plan: CampaignPlan, expected: str, tmp_path: Path) -> None:
    file = tmp_path / "trial.yaml"
    file.write_text(TRIAL)
    folder = tmp_path / "results"
    words = ["campaign", str(file), "--workers", "2", "--output", str(folder), "--record", "none"]
    client = subprocess.Popen(
        [*PIRATE, *words],
        stdout=subprocess.DEVNULL,
        start_new_session=True,
    )
    while client.poll() is None and not list(folder.glob("results/*.parquet")):
        Event().wait(0.02)
    client.kill()
    client.wait()
    stored = sum(len(rows) for rows in Store(folder).read())

    resumed = subprocess.run(
        [*PIRATE, *words, "--resume"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert resumed.stdout.replace(str(folder), "FOLDER") == expected, resumed.stderr
    assert 0 < stored < 480


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_run_that_kills_its_worker_each_time_is_a_bug_and_no_other_is_blamed(
    plan: CampaignPlan, tmp_path: Path
) -> None:
    store = Store(tmp_path)
    store.begin(mark_of(plan))
    conductor = Conductor(plan, store)
    with connected(plan, None, 2) as crew:
        conductor.conduct(crew.doing(deadly))
    store.close()

    bugs = [(t.bugs, [each.seeds for each in t.causes.values()]) for t in conductor.tallies]
    assert bugs == [(1, [[33]]), (0, []), (0, []), (0, [])]


def deadly(chunk: crews.Chunk, sent: crews.Sent, version: str) -> list[object]:
    """Work that ends its process at a certain seed of the first mission."""
    if "enter_2d" in chunk.order.mission and not chunk.order.defects and 33 in chunk.seeds:
        os._exit(1)
    return [row(chunk.cell, seed) for seed in chunk.seeds]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_workers_of_another_version_are_refused(plan: CampaignPlan, cluster: Cluster) -> None:
    cluster.add_worker()
    with (
        pytest.raises(UsageError, match="run another version of pirate-sm"),
        connected(replace(plan, version="0.0.1+abc"), cluster.address),
    ):
        pass


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_scheduler_without_workers_is_reported(
    plan: CampaignPlan, cluster: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(crews, "_NO_WORKERS_S", 0.5)
    with pytest.raises(UsageError, match="has no workers"), connected(plan, cluster.address):
        pass


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nowhere", "zcp://a:1", ""])
def test_a_scheduler_that_is_not_there_is_reported(
    plan: CampaignPlan, address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(crews, "_NO_ANSWER_S", 0.2)
    with pytest.raises(UsageError, match="no Dask scheduler answers at"), connected(plan, address):
        pass
    # Dask's client says by itself that its scheduler is gone, in words of its own.
    assert not logging.getLogger("distributed.client").isEnabledFor(logging.ERROR)
