"""What people wait for: each figure beside its goal, and beside that of an earlier commit.

    python -m benchmarks.bench [WORK ...] [--small] [--page docs/measurements.md]

Each work of `benchmarks.speeds` is a process of its own, in this tree and in that of the commit
before the speeds were worked on, in turn and several times where it is short; the best counts.
Times are of the processor (user and system, of all processes of a command) unless the row says
wall, so that other programs disturb them less. The goals were set on another machine together with
what was measured there, so that what judges is how many times as good a figure is as before. A
figure that is a ratio by itself is judged as it is. What falls short of its goal is marked.

The earlier tree, with its machine code, is made of the history and kept in `build/before`; without
a history nothing is compared. With ``--small`` nothing is either, and the works are as small as
tests need them. With ``--page`` the table is written into a page too, between its marks.
"""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from io import BytesIO
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple
from zipfile import ZipFile

from benchmarks.growth import ROWS
from benchmarks.speeds import WORKS
from pirate_sm.simulation.machine_code.built_library import find_library

ROOT = Path(__file__).resolve().parents[1]
BEFORE = "42c6ed7f09a0a96eeeb98b8e3cfa4f0bbda14526"
"""The commit before pipes were linear and results of the check were kept."""

ALONE = {"growth"}
"""Works of which the earlier tree would take minutes, and whose figures are ratios."""

LONG_S, REPEATS = 10.0, 3
"""A work is repeated so many times, until both trees together have taken so long."""

BEGINS, ENDS = "<!-- speed: written by `python -m benchmarks.bench --page` -->\n", "<!-- end -->"
HEAD = "| | now | before | times as good | goal | |\n|---|---|---|---|---|---|"


class Figure(NamedTuple):
    """What is printed of a figure, and by what it is judged.

    Attributes:
        what: What was measured.
        form: How it is written.
        goal: None: there is none.
        was: What was measured where the goal was set; None: the figure is judged as it is.
        more: Whether more is better.
    """

    what: str
    form: str = "{:.2f} s"
    goal: float | None = None
    was: float | None = None
    more: bool = False

    def times(self, now: float, before: float) -> float:
        """How many times as good it is as before."""
        return now / before if self.more else before / now

    def is_short(self, now: float, before: float | None) -> bool:
        """Whether it falls short of its goal; without a goal or what it is compared with never."""
        if self.goal is None:
            return False
        if self.was is None:
            return now < self.goal if self.more else now > self.goal
        return before is not None and self.times(now, before) < self.times(self.goal, self.was)

    def line(self, now: float, before: float | None) -> str:
        """The line of the table."""
        times, goal, mark = "–", "–", "**short**" if self.is_short(now, before) else ""
        if before is not None:
            times = f"{self.times(now, before):.2f} ×"
        if self.goal is not None:
            goal = f"{'≥' if self.more else '≤'} {self.form.format(self.goal)}"
            if self.was is not None:
                goal += f" of {self.form.format(self.was)}: {self.times(self.goal, self.was):.1f} ×"
        was = "–" if before is None else self.form.format(before)
        return f"| {self.what} | {self.form.format(now)} | {was} | {times} | {goal} | {mark} |"


RATE, SHARE, TIMES, MORE = "{:,.0f}", "{:.3f}", "{:.2f} ×", "{:+.0f} %"

FIGURES: Mapping[str, Sequence[Figure]] = {
    "check": (
        Figure("`pirate check`, all files, nothing kept: wall", goal=5, was=12),
        Figure("… nothing changed", goal=0.5, was=12),
    ),
    "mission": (
        Figure("`pirate check mitre_bend.yaml`, nothing changed", goal=0.25, was=0.68),
        Figure("… a comment changed", goal=0.5, was=0.68),
    ),
    "explored": (Figure("explored steps a second", RATE, more=True),),
    "process": (
        Figure("`pirate-run mitre_bend`, a later process", goal=0.45, was=0.765),
        Figure("… its most memory", "{:.0f} MB"),
        Figure("`pirate-run --help`", "{:.3f} s"),
    ),
    "interpreted": (
        Figure("a bend in times real time, by events of python-statemachine a second", SHARE,
               goal=0.2, more=True),
        Figure("… these events", RATE, more=True),
        Figure("… the bend", RATE + " ×", more=True),
        Figure("… `take_elbow`, in a round pipe", RATE + " ×", more=True),
    ),
    "loop": (Figure("`pirate_sm.run(loaded, seed=k)`, again", "{:.3f} s", goal=0.06, was=0.117),),
    "odometry": (
        Figure("a bend by odometry: gain by glides", TIMES, more=True),
        Figure("… in parts of the gain by `sim`", TIMES, goal=0.95, more=True),
    ),
    "recorded": (Figure("what a recording adds to a bend", MORE, goal=15),),
    "pipe": (
        Figure("a pipe of 1,000 segments: to load a mission in it", goal=0.2, was=2.2),
        Figure("… its findings", goal=0.2, was=15.2),
    ),
    "learnt": (
        Figure("learning, steps a second of one process", RATE, goal=1_000, was=280, more=True),
    ),
    "campaign": (
        Figure("campaign of 600 bends, one worker: a second, wall", "{:.1f}", goal=30, was=17,
               more=True),
        Figure("… two workers to one: wall", TIMES, goal=1.85, more=True),
    ),
    "growth": tuple(
        Figure(f"exponent of growth: {row.what}", "{:.2f}", goal=row.bar) for row in ROWS.values()
    ),
}  # fmt: skip
"""Of each work, in the order in which it returns them."""


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("works", nargs="*", choices=(*WORKS, "all"), default="all")
    parser.add_argument("--small", action="store_true", help="as small as tests need it")
    parser.add_argument("--page", type=Path, help="a page whose table is written anew")
    wishes = parser.parse_args()
    names = [name for name in WORKS if name in wishes.works or "all" in wishes.works]
    earlier = None if wishes.small else earlier_tree(ROOT)
    if wishes.page:
        written(wishes.page.read_text("utf-8"), ())  # it has its marks
    lines = []
    for line in chain((caption(earlier), "", HEAD), table(names, earlier, wishes.small)):
        print(line, flush=True)
        lines.append(line)
    if wishes.page:
        text = wishes.page.read_text("utf-8")
        wishes.page.write_text(written(text, lines), encoding="utf-8")
    return 0


def caption(earlier: Path | None) -> str:
    """Say where and when this is measured, and with what it is compared."""
    load, why_not = os.getloadavg()[0], find_library().why_not
    said = [
        f"{datetime.now(UTC):%Y-%m-%d}",
        f"{os.cpu_count()} cores ({platform.machine()}), load {load:.1f} at the start",
        f"Python {platform.python_version()}",
        f"before: {BEFORE[:8]}" if earlier else "compared with nothing",
        *([f"machine code of the simulator not built, {why_not}"] if why_not else ()),
    ]
    return "; ".join(said) + "."


def table(names: Iterable[str], earlier: Path | None, small: bool) -> Iterator[str]:
    """Yield the lines of these works, each as soon as it has been measured."""
    for name in names:
        trees = [ROOT, *([earlier] if earlier and name not in ALONE else ())]
        found: dict[Path, list[Sequence[float]]] = {tree: [] for tree in trees}
        began_s = perf_counter()
        for _ in range(1 if small else REPEATS):
            for tree in tuple(found):
                try:
                    found[tree].append(measured(tree, name, small))
                except subprocess.CalledProcessError:
                    if tree == ROOT:
                        raise
                    del found[tree]  # what the works use has changed since
            if perf_counter() - began_s > LONG_S:
                break
        for index, figure in enumerate(FIGURES[name]):
            best = max if figure.more else min
            now, *before = (best(some[index] for some in each) for each in found.values())
            yield figure.line(now, before[0] if before else None)


def measured(tree: Path, name: str, small: bool) -> list[float]:
    """Return the figures of a work in a tree, with nothing kept from before."""
    with TemporaryDirectory() as cache:
        around = {
            **os.environ,
            **dict.fromkeys(("XDG_CACHE_HOME", "PIRATE_SM_CACHE", "NUMBA_CACHE_DIR"), cache),
            "PIRATE_SM_RUNS": "",
            "PYTHONPATH": str(tree),
            "PYTHONDONTWRITEBYTECODE": "",
        }
        code = f"from benchmarks.speeds import WORKS; print(*WORKS[{name!r}]({small}))"
        told = subprocess.run(
            [sys.executable, "-c", code], cwd=tree, env=around, stdout=subprocess.PIPE, check=True
        ).stdout
    return [float(each) for each in told.splitlines()[-1].split()]


def earlier_tree(root: Path) -> Path | None:
    """Return the tree of the commit before, with its machine code; None if no history has it."""
    tree = root / "build" / "before" / BEFORE[:8]
    if tree.exists():
        return tree
    archive = ["git", "-C", str(root), "archive", "--format=zip", BEFORE]
    try:
        packed = subprocess.run(archive, check=True, capture_output=True).stdout
    except (OSError, subprocess.CalledProcessError):
        print(f"Nothing is compared: the commit {BEFORE[:8]} is in no history here.")
        return None
    part = tree.with_suffix(".part")
    shutil.rmtree(part, ignore_errors=True)
    with ZipFile(BytesIO(packed)) as files:
        files.extractall(part)
    shutil.rmtree(part / "benchmarks")
    (part / "benchmarks").symlink_to(root / "benchmarks")
    around = {**os.environ, "PYTHONPATH": str(part)}
    build = [sys.executable, "-m", "pirate_sm.simulation.machine_code.builder"]
    subprocess.run(build, cwd=part, env=around, check=True, stdout=subprocess.DEVNULL)
    return part.rename(tree)


def written(page: str, lines: Iterable[str]) -> str:
    """Return the page with these lines between its marks."""
    before, begins, rest = page.partition(BEGINS)
    _, ends, after = rest.partition(ENDS)
    if not begins or not ends:
        raise ValueError(f"the page has no {BEGINS.strip()} with an {ENDS}")
    return f"{before}{begins}" + "".join(f"{line}\n" for line in lines) + f"{ends}{after}"


if __name__ == "__main__":
    sys.exit(main())
