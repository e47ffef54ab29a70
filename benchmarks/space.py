"""How often a robot passes what round pipes are made of, in space, when seeds vary.

    python -m benchmarks.space [--row NAME] [--seeds 100] [--detector odometry] [--start 0]

Each seed shifts the start by up to 20 mm (--start), friction by up to 20 % and all diameters by up
to 2 mm, and draws its own noise. A run counts when the mission succeeds, every wheel is beyond the
joint in truth, and none is folded back. Rows that are also possible between bars on a plate print
how long the same missions take there. In no row may a wheel or link be 2 mm in a wall; the first
number is what a clamp's force makes of the contact's stiffness. Odometry does not know by how much
the start is shifted.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from benchmarks.campaign import options_of_rows, run_all
from pirate_sm.lab.campaign.watched_run import Outcome
from pirate_sm.running.wiring import Order

BEND, ROUND, BRANCH, DRIVE = "take_bend", "take_elbow", "take_branch", "drive_on"
BAR, DEEPEST_M = 0.99, 0.002

MITRE = "{straight: 1 m}, {mitre: 90 deg}, {straight: 1 m}"
ELBOW = "{straight: 1 m}, {elbow: 90 deg, radius: 180 mm}, {straight: 1 m}"
LEVEL = "{}"
TILTED, TILTED_BACK = "{roll: 28 deg}", "{roll: -28 deg}"
UP, DOWN = "{roll: 90 deg}", "{roll: -90 deg}"
CLIMBING, DESCENDING = "{pitch: 90 deg}", "{pitch: -90 deg}"
LYING = {"": LEVEL, ", up": UP, ", climbing": CLIMBING}


@dataclass(frozen=True)
class Row:
    """A pipe and the mission through it.

    Attributes:
        name: What is printed, and what ``--row`` takes.
        segments: Of the pipe; empty for one that is shipped.
        frame: How its first run lies; up and down are where the far leg of a bend goes.
        mission: Name or file of the mission.
        diameter: Inner diameter at the start.
        pipe: Name of a shipped pipe.
        beyond_m: Every wheel must end beyond this arc length.
        before_m: And before this one.
        bars: Name of the pipe of bars in which the mission takes the same time.
        bar: Least share of runs that must count; 0 for a row that is only shown.
    """

    name: str
    segments: str = ""
    frame: str = LEVEL
    mission: str = BEND
    diameter: str = "120 mm"
    pipe: str = ""
    beyond_m: float = 1.0
    before_m: float = inf
    bars: str = ""
    bar: float = BAR


def tee(take: str, roll: str = "0 deg", branch: str = "120 mm") -> str:
    """Return the segments of a pipe with a tee; the arm that is not taken is a closed stub."""
    of = f"{{tee: 90 deg, take: {take}, roll: {roll}, diameter: {branch}}}"
    return f"{{straight: 1 m}}, {of}, {{straight: 1 m}}"


def elbow(angle_deg: int, radius_mm: int) -> str:
    """Return the segments of a pipe with an elbow."""
    bend = f"{{elbow: {angle_deg} deg, radius: {radius_mm} mm}}"
    return f"{{straight: 1 m}}, {bend}, {{straight: 1 m}}"


def reducer(length: str, to: str) -> str:
    """Return the segments of a pipe with a reducer."""
    return f"{{straight: 1 m}}, {{reducer: {length}, to: {to}}}, {{straight: 1.2 m}}"


@dataclass(frozen=True)
class Ways:
    """How rows are run.

    Attributes:
        detector: The detector; None for the simulator's own.
        start_m: By how much a start may differ from the pipe's.
        seeds: How many runs a row has.
        workers: How many processes share them; None: one for each processor.
    """

    detector: str | None
    start_m: float
    seeds: int
    workers: int | None


ROWS = (
    Row("mitre", MITRE, bars="mitre_90"),
    Row("mitre, tilted up", MITRE, TILTED, bars="mitre_90_tilted"),
    Row("mitre, tilted down", MITRE, TILTED_BACK),
    Row("mitre, up", MITRE, UP, bars="mitre_90_up"),
    Row("mitre, down", MITRE, DOWN, bars="mitre_90_down"),
    Row("mitre, climbing", MITRE, CLIMBING, bars="mitre_90_from_below"),
    Row("mitre, descending", MITRE, DESCENDING, bars="mitre_90_from_above"),
    *(
        Row(f"mitre of {angle} deg{way}", MITRE.replace("90", str(angle)), frame)
        for angle in (30, 45, 60, 75)
        for way, frame in LYING.items()
    ),
    Row("elbow", ELBOW, mission=ROUND),
    Row("elbow, up", ELBOW, UP, ROUND),
    Row("elbow, down", ELBOW, DOWN, ROUND),
    *(
        Row(f"elbow of {angle} deg, {radius} mm{way}", elbow(angle, radius), frame, ROUND)
        for angle in (45, 90)
        for radius in (120, 240, 300)
        for way, frame in LYING.items()
    ),
    Row("tee, in", tee("branch"), mission=BRANCH),
    Row("tee, in, up", tee("branch"), UP, BRANCH),
    Row("tee, in, down", tee("branch"), DOWN, BRANCH),
    Row("tee, in, tilted", tee("branch"), TILTED, BRANCH),
    Row("tee, in, climbing", tee("branch"), CLIMBING, BRANCH),
    Row("tee, in, descending", tee("branch"), DESCENDING, BRANCH),
    Row("tee, in 110 mm", tee("branch", branch="110 mm"), mission=BRANCH),
    Row("tee, on, square", tee("on", "90 deg"), mission=DRIVE),
    Row("tee, on, in plane", tee("on"), mission=DRIVE, bar=0.0),
    Row("120 to 105 mm", reducer("60 mm", "105 mm"), mission=DRIVE),
    Row("120 to 110, climbing", reducer("60 mm", "110 mm"), CLIMBING, DRIVE),
    Row("step to 110 mm", reducer("0 mm", "110 mm"), mission=DRIVE),
    Row("step to 110 mm, climbing", reducer("0 mm", "110 mm"), CLIMBING, mission=DRIVE),
    Row("110 to 120 mm", reducer("60 mm", "120 mm"), mission=DRIVE, diameter="110 mm"),
    Row("step to 120 mm", reducer("0 mm", "120 mm"), mission=DRIVE, diameter="110 mm"),
    Row("two planes, up", pipe="two_mitres_up", mission="two_bends_up", beyond_m=2.2),
    Row("two planes, down", pipe="two_mitres_down", mission="two_bends_down", beyond_m=2.2),
    Row("house", pipe="house", mission="house_connection", beyond_m=3.3),
    Row(
        "house, back",
        pipe="house_back",
        mission="house_connection_back",
        beyond_m=0.0,
        before_m=1.2,
    ),
    Row("house and back", pipe="house", mission="house_and_back", beyond_m=0.0, before_m=1.2),
)


def main() -> int:
    """Print each row; return 1 when one misses its bar."""
    names = [row.name for row in ROWS]
    options = options_of_rows(__doc__, names, 100, "runs of every row")
    options.add_argument("--detector", help="of the missions; the simulator's own by default")
    options.add_argument("--start", type=float, default=20, help="how far starts vary, mm; 20")
    wishes = options.parse_args()
    ways = Ways(wishes.detector, wishes.start / 1000, wishes.seeds, wishes.workers)
    good = True
    with TemporaryDirectory() as folder:
        for row in ROWS:
            if row.name in (wishes.row or names):
                good &= _show(row, Path(folder), ways)
    return 0 if good else 1


def pipe_of(row: Row, folder: Path) -> Path:
    """Write the pipe of a row to a file and return its path."""
    path = folder / f"row_{ROWS.index(row)}.yaml"
    path.write_text(
        f"format: 1\npipe: {path.stem}\nsection: round\ndiameter: {row.diameter}\n"
        f"frame: {row.frame}\nsegments: [{row.segments}]\nstart: {{at: 700 mm}}\n",
        encoding="utf-8",
    )
    return path


def _show(row: Row, folder: Path, ways: Ways) -> bool:
    """Run a row and print what came of it; return whether it is good enough."""
    pipe = row.pipe or str(pipe_of(row, folder))
    outcomes = _run(row.mission, pipe, ways)
    whys = [failure(outcome, row) for outcome in outcomes]
    passed = whys.count("")
    deepest_m = max(outcome.deepest_m for outcome in outcomes)
    times = [outcome.time_s for outcome, why in zip(outcomes, whys, strict=True) if not why]
    beside = ""
    if row.bars and times:
        flat = _run(row.mission, row.bars, ways)
        usual = median(each.time_s for each in flat if each.outcome == "succeeded")
        beside = f", {median(times) / usual - 1:+.1%} against bars"
    bar = f"bar {row.bar:.0%}" if row.bar else "no bar"
    print(
        f"{row.name:20} {passed:4} of {ways.seeds} passed ({bar}), "
        f"median {median(times or [0.0]):.1f} s{beside}, {deepest_m * 1000:.2f} mm in a wall",
        flush=True,
    )
    for why, count in Counter(why for why in whys if why).most_common():
        failed = ", ".join(str(seed) for seed, each in enumerate(whys) if each == why)
        print(f"    {count:4} × {why} (seeds {failed})", flush=True)
    return passed >= row.bar * ways.seeds and deepest_m < DEEPEST_M


def order_of(mission: str, pipe: str, seed: int) -> Order:
    """Return the run of a mission in a pipe."""
    settings = {"way": "1 m"} if mission == DRIVE else {}
    return Order(mission, "sim", pipe=pipe, settings=settings, seed=seed)


def _run(mission: str, pipe: str, ways: Ways) -> Sequence[Outcome]:
    orders = [
        replace(
            order_of(mission, pipe, seed),
            detector=ways.detector,
            start_jitter_m=ways.start_m,
            friction_jitter=0.20,
            diameter_jitter_m=0.002,
        )
        for seed in range(ways.seeds)
    ]
    return run_all(orders, workers=ways.workers)


def failure(outcome: Outcome, row: Row) -> str:
    """Return why a run did not pass; empty when it did."""
    if outcome.outcome != "succeeded":
        return outcome.message
    arcs_m = outcome.arcs_m
    if outcome.gone or min(arcs_m) < row.beyond_m or max(arcs_m) > row.before_m:
        return "said to have passed, with wheels not beyond the joint"
    if list(outcome.arcs_m) != sorted(outcome.arcs_m, reverse=True):
        return "said to have passed, with a part folded back on itself"
    return ""


if __name__ == "__main__":
    sys.exit(main())
