"""How what the program does grows with what it is given.

    python -m benchmarks.growth [segments] [bends] [phases] [calls] [held] [recording] [rows]
                                [--small]

Each work is done with a number of things, with twice and with four times as many. Printed are the
processor time of each, the best of three unless it is long, and the exponent of the number with
which it grows: 1 is linear. One above its bar is marked, and the exit code is 1 then. With
``--small`` the numbers are those with which tests count calls: too small for times to say much, so
that nothing is judged. ``python -m benchmarks.recording --hours 10`` tells what the longest
recording takes.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from math import log
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from benchmarks.check import HEAD, best_s, holding_mission, long_mission
from benchmarks.recording import record
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission.check_mission import check_loaded
from pirate_sm.checking.pipe.check_in_pipe import pipe_findings, view_in_pipe
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.lab.campaign.campaign_model import Expectation, StoppingRule, TrueEnd
from pirate_sm.lab.campaign.chunk import RunRow
from pirate_sm.lab.campaign.page import page_of
from pirate_sm.lab.campaign.plan import CampaignPlan, Cell
from pirate_sm.lab.campaign.results import result_of
from pirate_sm.lab.campaign.store import Store
from pirate_sm.lab.campaign.tally import Tally
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.wiring import Order
from pirate_sm.views.report.recording_report import report_of
from pirate_sm.views.report.report_page import html

BAR = 1.1
"""Largest exponent of what is linear: a sort adds a little."""

HELD_BAR = 3.0
"""That of conditions to hold: from each of them each other may follow, and all are asked then."""

RUNS, LONG_S = 3, 5.0
"""What takes longer is done once."""

Work = Callable[[], object]


def pipe_of(segments: int, in_a_run: int = 50) -> str:
    """Stairs of round pipe, in runs that end with a straight."""
    runs = max(segments // in_a_run, 1)
    lines = ["format: 1", "pipe: stairs", "diameter: 120 mm", "section: round", "runs:"]
    for run in range(runs):
        ends = f"j{run}" if run else "entry", f"j{run + 1}" if run + 1 < runs else "exit"
        parts = [
            f"{{elbow: {90 - number % 4 // 2 * 180} deg, radius: 180 mm}}"
            if number % 2 and number + 1 < segments // runs
            else "{straight: 1.2 m}"
            for number in range(segments // runs)
        ]
        lines.append(
            f"  r{run}: {{from: {ends[0]}, to: {ends[1]}, segments: [{', '.join(parts)}]}}"
        )
    lines.append(f"routes: {{through: [{', '.join(f'r{run}' for run in range(runs))}]}}")
    return "\n".join([*lines, "ends: {entry: open, exit: open}", ""])


ON = (
    f"{HEAD}pipe: pipe\non_failure: f\nstart: on\nphases:\n  on:\n"
    "    do: [{call: take_elbow}, {call: turn_right}, {call: turn_right}]\n"
    "    wait: [{operator: enough, go: e}, {operator: more, go: on}]\n"
    "    within: {time: 1 min, go: f}\n"
    "starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}\n"
    "ends: {e: {succeed: ok}, f: {fail: bad}}\n"
)
"""Through one elbow after the other, for any distance."""

CALLED = (
    f"{HEAD}start: a\nphases:\n  a:\n    do: [ToggleLighting, ToggleLighting]\n"
    "    wait: [{when: detector == close, held: 200 ms, go: e}]\n"
    "    within: {time: 10 s, go: f}\nends: {e: {succeed: ok}, f: {fail: bad}}\n"
)


def calling_mission(calls: int) -> str:
    """So many phases one after the other, each of which calls the same mission."""
    lines = [
        f"  p{n}: {{do: [{{call: called}}], go: {f'p{n + 1}' if n + 1 < calls else 'e'}}}"
        for n in range(calls)
    ]
    phases = "\n".join(lines)
    return (
        f"{HEAD}on_failure: f\nstart: p0\nphases:\n{phases}\n"
        "ends: {e: {succeed: ok}, f: {fail: bad}}\n"
    )


def load(folder: Path, mission: str, **others: str) -> Callable[[], LoadedMission]:
    """Load a mission with the files that it names."""
    for name, text in {"m": mission, **others}.items():
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    return lambda: load_mission(folder / "m.yaml")


def check(folder: Path, mission: str, **others: str) -> Work:
    """Load and check it."""
    loaded = load(folder, mission, **others)
    return lambda: check_loaded(loaded())


def findings(folder: Path, segments: int) -> Work:
    """Find what is wrong with a mission that goes through all bends of a pipe."""
    loaded = load(folder, ON, pipe=pipe_of(segments))

    def work() -> list[Finding]:
        view = view_in_pipe(loaded())
        assert view is not None  # its course is short enough
        return pipe_findings(view)

    return work


def report(folder: Path, seconds: int) -> Work:
    """Write the report of a recording of so many seconds."""
    file = folder / f"{seconds}.mcap"
    file.unlink(missing_ok=True)
    record(file, seconds / 3600)
    return lambda: html(report_of(read_recording(file)))


def count(folder: Path, hundreds: int) -> Work:
    """Store, read and count so many hundred runs of a campaign, and make its page."""

    def work() -> str:
        seeds = range(hundreds * 100)
        cell = Cell("bend", "", Order("mitre_bend"), seeds, TrueEnd(), Expectation(), "k", "m")
        plan = CampaignPlan("trial", "1", (cell,), 0.95, StoppingRule(), {"m": b""})
        with TemporaryDirectory(dir=folder) as name:
            store, tally = Store(Path(name)), Tally(cell, 0.95, StoppingRule())
            store.begin({})
            for seed in seeds:
                passed, why = seed % 7 > 0, f"Lost after {seed}.5 mm"
                said = ("succeeded", "passed", "") if passed else ("failed", "failed", why)
                store.add([RunRow("k", seed, *said, passed, "", 30.0, 0.8, -0.03, 0.001)])
            store.close()
            for rows in Store(Path(name)).read():
                tally.add(rows)
            return page_of(result_of(plan, [tally], Path(name)), "recordings")

    return work


class Row(NamedTuple):
    """Something that grows.

    Attributes:
        what: What is done, by the number of what.
        counted: The smallest number with which calls are counted; ``timed`` with which times are.
        made: Makes in a folder what so many take, and returns what is done with it.
        bar: The largest exponent.
    """

    what: str
    counted: int
    timed: int
    made: Callable[[Path, int], Work]
    bar: float = BAR

    def times(self, small: bool) -> dict[int, float]:
        """Processor times of a number, twice and four times as many."""
        times: dict[int, float] = {}
        for number in (each * (self.counted if small else self.timed) for each in (1, 2, 4)):
            for more in range(RUNS):  # another each time: the program remembers what it has seen
                with TemporaryDirectory() as folder:
                    took_s = best_s(self.made(Path(folder), number + more), 1)
                times[number] = min(took_s, times.get(number, took_s))
                if took_s > LONG_S:
                    break
        return times


def exponent(times: dict[int, float]) -> float:
    """That of the number with which the times grow."""
    first_s, *_, last_s = times.values()
    return log(last_s / first_s, 4)


ROWS = {
    "segments": Row("load, by segments", 50, 250, lambda f, n: load(f, ON, pipe=pipe_of(n))),
    "bends": Row("findings in a pipe, by segments", 20, 250, findings),
    "phases": Row("check, by phases", 20, 750, lambda f, n: check(f, long_mission(n))),
    "calls": Row("check, by calls", 10, 250,
                 lambda f, n: check(f, calling_mission(n), called=CALLED)),
    "held": Row("check, by conditions to hold", 3, 3,
                lambda f, n: check(f, holding_mission(n)), HELD_BAR),
    "recording": Row("report, by seconds recorded", 15, 900, report),
    "rows": Row("campaign, by hundreds of runs", 5, 250, count),
}  # fmt: skip


def main() -> int:
    """Print how all rows grow, or those that are named; return 1 when a bar is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("rows", nargs="*", choices=(*ROWS, "all"), default="all")
    parser.add_argument("--small", action="store_true", help="the numbers of the tests")
    wishes = parser.parse_args()
    missed = False
    for name, row in ROWS.items():
        if name not in wishes.rows and "all" not in wishes.rows:
            continue
        times = row.times(wishes.small)
        grown = exponent(times)
        over = grown > row.bar and not wishes.small
        missed |= over
        said = "   ".join(f"{number:6,}: {time_s:7.3f} s" for number, time_s in times.items())
        print(f"{row.what:32}{said}   exponent {grown:.2f}{', over its bar' if over else ''}")
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
