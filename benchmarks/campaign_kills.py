"""A campaign that is disturbed again and again, beside the same campaign left alone.

    python -m benchmarks.campaign_kills [--runs 600] [--every 10] [--seed 1]

Six cells: two missions, each without defects and with two of the defects; a cell ends when its
interval is narrow enough, so the table would differ if it depended on which result came first. The
campaign runs once undisturbed, on two workers of its own. Then it runs on a cluster of
processes over TCP on loopback; every few seconds one of these happens, drawn by the seed:

- a worker is killed, and another one started;
- the connections between the client and the scheduler are cut;
- the client is killed, and its command given again with ``--resume``.

The tables as text, JSON and JUnit, and each row that both stores have, must be equal, bit for bit.
The exit code is 1 if they are not.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from time import perf_counter

from benchmarks.dask_cluster import Cluster, Relay, kill
from pirate_sm.lab.campaign.chunk import RunRow
from pirate_sm.lab.campaign.store import Store

CAMPAIGN = """\
format: 1
campaign: disturbed
missions: [mitre_bend, take_bend_backward]
defects: [none, messages_lost, gamma_2_drops]
jitter: {{start: 20 mm, friction: 20 %}}
seeds: 0..{last}
stop: {{half_width: 2.5 %}}
expect: {{truthful: "100 %"}}
"""
FORMS = ("text", "json", "junit")
PIRATE = (sys.executable, "-c", "from pirate_sm.cli.start import main; main()")
ENDED = (0, 1)
"""Exit codes of a campaign that has its table."""


def main() -> int:
    """Run the campaign twice and compare; return 1 when something differs."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=600, help="seeds of a cell at most")
    parser.add_argument("--every", type=float, default=10.0, help="seconds between disturbances")
    parser.add_argument("--seed", type=int, default=1)
    wishes = parser.parse_args()
    with TemporaryDirectory() as name:
        file = Path(name) / "disturbed.yaml"
        file.write_text(CAMPAIGN.format(last=wishes.runs - 1), encoding="utf-8")
        alone, disturbed = Path(name) / "alone", Path(name) / "disturbed"
        began = perf_counter()
        _finished(file, alone, "--workers", "2")
        print(f"alone: {_size(alone):,} runs in {perf_counter() - began:.0f} s", flush=True)
        began = perf_counter()
        happened = _disturb(file, disturbed, Random(wishes.seed), wishes.every)
        print(
            f"disturbed: {_size(disturbed):,} runs in {perf_counter() - began:.0f} s;"
            f" {happened['worker']} workers killed, {happened['connection']} connections cut,"
            f" {happened['client']} clients killed"
        )
        return _compare(file, alone, disturbed)


def _command(file: Path, folder: Path, *more: str) -> list[str]:
    own = ("--output", str(folder), "--record", "none", "--no-check", "--resume")
    return [*PIRATE, "campaign", str(file), *own, *more]


def _finished(file: Path, folder: Path, *more: str) -> str:
    """Run or continue the campaign to its end; return what it prints, without the folder."""
    done = subprocess.run(
        _command(file, folder, *more), capture_output=True, text=True, check=False
    )
    if done.returncode not in ENDED:
        raise SystemExit(f"exit code {done.returncode}: {done.stderr}")
    return done.stdout.replace(str(folder), "FOLDER")


def _disturb(file: Path, folder: Path, drawn: Random, every_s: float) -> Counter[str]:
    """Run the campaign on a cluster that is disturbed until it ends; return what happened."""
    happened: Counter[str] = Counter()
    with ExitStack() as stack:
        cluster = Cluster(stack)
        workers = [cluster.add_worker() for _ in range(2)]
        relay = stack.enter_context(Relay(cluster.address))
        client = _client(file, folder, relay)

        def end() -> None:
            if client.poll() is None:
                kill(client)

        stack.callback(end)
        while True:
            try:
                code = client.wait(timeout=every_s)
            except subprocess.TimeoutExpired:
                code = None
            if code in ENDED:
                return happened
            if code is not None:  # the cluster was lost, says the client
                happened["lost"] += 1
                client = _client(file, folder, relay)
                continue
            what = drawn.choice(("worker", "connection", "client"))
            happened[what] += 1
            if what == "worker":
                kill(workers.pop(drawn.randrange(2)))
                workers.append(cluster.add_worker())
            elif what == "connection":
                relay.cut()
            else:
                kill(client)
                client = _client(file, folder, relay)


def _client(file: Path, folder: Path, relay: Relay) -> subprocess.Popen[str]:
    return subprocess.Popen(
        _command(file, folder, "--scheduler", relay.address),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    )


def _rows(folder: Path) -> Iterator[RunRow]:
    for rows in Store(folder).read():
        yield from rows


def _size(folder: Path) -> int:
    return len({(row.cell, row.seed) for row in _rows(folder)})


def _compare(file: Path, alone: Path, disturbed: Path) -> int:
    """Print the table and what differs; return 1 if anything does."""
    tables = {
        form: [_finished(file, folder, "--format", form) for folder in (alone, disturbed)]
        for form in FORMS
    }
    print(tables["text"][0], end="")
    different = [form for form, (one, other) in tables.items() if one != other]
    # Seeds beyond the end of a cell's table may have run in one of the two campaigns only.
    one, other = (
        {(row.cell, row.seed): repr(row) for row in _rows(each)} for each in (alone, disturbed)
    )
    both = one.keys() & other.keys()
    rows = sum(one[each] != other[each] for each in both)
    print(
        f"{len(both):,} rows of both stores, {rows} of them differ; "
        f"{len(different)} of {len(FORMS)} tables differ {different or ''}".rstrip()
    )
    return 1 if rows or different else 0


if __name__ == "__main__":
    sys.exit(main())
