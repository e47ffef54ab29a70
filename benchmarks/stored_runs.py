"""What it costs to read the results of a long campaign: its page, and a comparison of two.

    python -m benchmarks.stored_runs [--runs 1000000] [--cells 10]

Two stores of so many made-up runs are written as a campaign writes them, each run with three drawn
numbers, one in eight failed. Then `pirate report` and `pirate compare` read them, each as a process
of its own. Printed are the time on the wall, processor time and most memory of each, of a quarter
of the runs and of all; bars 30 s and 1 GB, with all of them. The exit code is 1 when one is missed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

from benchmarks.used import Used, used_by
from pirate_sm.lab.campaign.campaign_model import Expectation, StoppingRule, TrueEnd
from pirate_sm.lab.campaign.chunk import RunRow, factors_of
from pirate_sm.lab.campaign.plan import CampaignPlan, Cell, mark_of
from pirate_sm.lab.campaign.store import Store
from pirate_sm.running.wiring import Order

BAR_S, BAR_BYTES = 30.0, 1e9
CHUNK = 20
"""Runs of one task of a campaign."""


def plan_of(runs: int, cells: int) -> CampaignPlan:
    """Return a campaign of so many runs."""
    order = Order("mitre_bend", start_jitter_m=0.005, friction_jitter=0.05, diameter_jitter_m=0.001)
    found = (
        Cell("bend", f"{n}", order, range(runs // cells), TrueEnd(), Expectation(), f"k{n}")
        for n in range(cells)
    )
    return CampaignPlan("many_bends", "1", tuple(found), 0.95, StoppingRule())


def rows_of(cell: Cell, salt: int) -> Iterator[RunRow]:
    """Yield made-up results of all runs of a cell; of more salt a few more of them pass."""
    draw = Random(f"{cell.key} {salt}")
    factors = factors_of(cell.order)
    for seed in cell.seeds:
        drawn = {each.name: draw.uniform(each.low, each.high) for each in factors}
        passed, time_s = draw.random() > 1 / (8 + salt), draw.gauss(64.0, 2.0)
        why = "" if passed else f"Bend: wheel 3 has lost the wall after {time_s:.2f} s"
        said = ("succeeded", "passed") if passed else ("failed", "failed")
        found = (time_s, 0.8, draw.gauss(-0.03, 0.002), 0.001)
        yield RunRow(cell.key, seed, *said, why, True, "", *found, drawn, 0.01, 0.3)


def write(folder: Path, plan: CampaignPlan, salt: int) -> None:
    """Write the results of a campaign, its cells in turn as workers do."""
    clock = [0.0]
    store = Store(folder, lambda: clock[0])
    store.begin(mark_of(plan))
    results = [rows_of(cell, salt) for cell in plan.cells]
    while chunks := [chunk for rows in results if (chunk := list(islice(rows, CHUNK)))]:
        for chunk in chunks:
            store.add(chunk)
            clock[0] += CHUNK * 3e-4  # as long as client and store take for them
    store.close()


def read(folder: Path, plan: CampaignPlan) -> dict[str, Used]:
    """Return what commands use that read the results of such a campaign, or of two."""
    stores = folder / "a", folder / "b"
    for salt, store in enumerate(stores):  # the second is not worse: `compare` ends with 0
        write(store, plan, salt)
    pirate = Path(sys.executable).with_name("pirate")
    return {
        "page": used_by(pirate, "report", stores[0]),
        "comparison": used_by(pirate, "compare", *stores),
    }


def main() -> int:
    """Print what reading costs; return 1 when a bar is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=1_000_000)
    parser.add_argument("--cells", type=int, default=10)
    wishes = parser.parse_args()
    missed = False
    for runs in (wishes.runs // 4, wishes.runs):
        with TemporaryDirectory() as name:
            found = read(Path(name), plan_of(runs, wishes.cells))
        for what, used in found.items():
            over = used.wall_s > BAR_S or used.memory_bytes > BAR_BYTES
            missed |= over
            print(
                f"{what:12}{runs:>10,} runs {used.wall_s:7.1f} s, of a processor "
                f"{used.processor_s:7.1f} s, {used.memory_bytes / 1e6:7.0f} MB"
                f"{', over its bar' if over else ''}"
            )
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
