"""How many of 250 small faults the tests find: `python -m benchmarks.mutants`.

A seeded sample of faults is made in the packages that decide what a robot does: flipped
comparisons, dropped terms, removed statements, swapped arguments, changed constants. Each is tried
by the tests that run its line. ``equivalent.yaml`` lists those that change nothing that matters,
with the reason; of the others 95 % must die in each package.

`--paths` takes files and folders instead of the packages. Their mutants are tried by the files and
folders of tests that mirror them and by the files in the folders above, without a record of what
all tests run, which takes many minutes.
"""

from __future__ import annotations

import argparse
import random
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from tempfile import TemporaryDirectory
from typing import TypeAlias

import yaml

from benchmarks.mutants.covering import Coverage, measure
from benchmarks.mutants.making import Mutant, mutants_of
from benchmarks.mutants.trying import Copy, Fate

ROOT = Path(__file__).resolve().parents[2]
KEPT = ROOT / "runs" / "mutants"
EQUIVALENT = Path(__file__).with_name("equivalent.yaml")
ASKED = 0.95

_REPLAYING = (
    *("recording/compare", "recording/parallel_replay", "recording/recorded_mission"),
    *("recording/replay", "wiring/resume_offer"),
)

PACKAGES = {
    "engine": ("pirate_sm/core/_engine",),
    "expressions": ("pirate_sm/core/_expressions",),
    "serial backend": (
        "pirate_sm/robot/backends/serial",
        "pirate_sm/robot/rosserial",
    ),
    "program": tuple(
        f"pirate_sm/core/_loading/mission/{name}.py"
        for name in ("program", "program_writer", "called_missions", "scope", "parameter_values")
    ),
    "exploration": ("pirate_sm/checking/exploring",),
    "recordings": (
        "pirate_sm/running/recording/read",
        *(f"pirate_sm/running/{name}.py" for name in _REPLAYING),
    ),
    "campaign": tuple(
        f"pirate_sm/lab/campaign/{name}.py"
        for name in ("intervals", "results", "tally", "watched_run")
    ),
    "places": (
        *(f"pirate_sm/robot/detectors/{name}.py" for name in ("place_filter", "word_timing")),
        "pirate_sm/core/_geometry/route.py",
    ),
}

_QUICK = 200
"""So many of the tests, the quickest, are tried before the others."""

Parts: TypeAlias = Sequence[Sequence[str]]
"""Tests, or their files and folders, in parts that are run one after the other."""


def files_of(places: tuple[str, ...]) -> list[str]:
    """Return the Python files at these places, relative to the tree."""
    found = []
    for place in places:
        path = ROOT / place
        if not path.exists():
            raise SystemExit(f"{place} is no longer there: correct PACKAGES")
        files = [path] if path.is_file() else sorted(path.rglob("*.py"))
        found += [str(each.relative_to(ROOT)) for each in files]
    return found


def mirrored(path: str) -> list[str]:
    """Return the file of tests that mirrors a file; what no recorded test runs is tried by it."""
    tests = Path("tests", "unit", *Path(path).parts[1:-1], f"test_{Path(path).name}")
    return [str(tests)] if (ROOT / tests).exists() else []


def nearby(path: str) -> Parts:
    """Return the file of tests that mirrors a file, its folder of tests, and files around that."""
    unit = Path("tests", "unit")
    folder = unit.joinpath(*Path(path).parts[1:-1])
    while not (ROOT / folder).exists():
        folder = folder.parent
    parents = [each for each in folder.parents if each.is_relative_to(unit) and each != unit]
    around = [file for each in parents for file in sorted((ROOT / each).glob("test_*.py"))]
    files = [str(file.relative_to(ROOT)) for file in around]
    return [part for part in (mirrored(path), [str(folder)], files) if part]


def sample(
    packages: Mapping[str, tuple[str, ...]], number: int, seed: int, only: str | None
) -> dict[str, list[Mutant]]:
    """Return a seeded choice of mutants by package, as many as its share of all there are."""
    every = {
        name: [m for path in files_of(places) for m in mutants_of(path, (ROOT / path).read_bytes())]
        for name, places in packages.items()
    }
    total = sum(len(each) for each in every.values())
    least = number // (2 * len(every))
    chosen = {}
    for name, mutants in every.items():
        size = least + round((number - least * len(every)) * len(mutants) / total)
        if only in (None, name):
            chosen[name] = random.Random(f"{seed} {name}").sample(mutants, min(size, len(mutants)))
    return chosen


def known_equivalents() -> dict[tuple[str, str, str, str], str]:
    """Return the reasons why a mutant changes nothing, by file, function and change."""
    listed = yaml.safe_load(EQUIVALENT.read_text()) or []
    return {(e["file"], e["function"], e["before"], e["after"]): e["reason"] for e in listed}


def recorded(coverage: Coverage, mutant: Mutant) -> Parts:
    """Return the tests that run the line of a mutant, quick ones first."""
    tests = coverage.tests(mutant.path, mutant.line) or mirrored(mutant.path)
    return [part for part in (tests[:_QUICK], tests[_QUICK:]) if part]


def try_all(
    mutants: list[Mutant],
    tests: Callable[[Mutant], Parts],
    copies: SimpleQueue[Copy],
    at_once: int,
) -> list[Fate]:
    """Return the fate of each mutant; each is shown as it becomes known, if no test failed."""

    def attempt(mutant: Mutant) -> Fate:
        copy = copies.get()
        try:
            fate = copy.fate(mutant, tests(mutant))
        finally:
            copies.put(copy)
        if fate != "killed":
            print(f"  {fate}: {mutant.path}:{mutant.line} {mutant.function} ({mutant.kind})")
            print(f"    - {mutant.before}\n    + {mutant.after}", flush=True)
        return fate

    with ThreadPoolExecutor(at_once) as pool:
        return list(pool.map(attempt, mutants))


def which_tests(options: argparse.Namespace, copy: Copy) -> Callable[[Mutant], Parts]:
    """Return what says which tests try a mutant; exit where these fail without one."""
    if options.paths:
        files = files_of(tuple(options.paths))
        near = sorted({test for path in files for part in nearby(path) for test in part})
        if not copy.passes([near]):
            raise SystemExit(f"{', '.join(near)}: fail without any mutant: fix that first")
        return lambda mutant: nearby(mutant.path)
    files = [path for places in PACKAGES.values() for path in files_of(places)]
    coverage = measure(ROOT, files, KEPT, options.at_once, options.tests)
    return lambda mutant: recorded(coverage, mutant)


def main() -> None:
    """Try a sample of mutants and show what became of them; exit 1 where too many live."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--number", type=int, default=250)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=PACKAGES, help="one package alone")
    parser.add_argument("--paths", nargs="+", default=[], help="files and folders instead")
    parser.add_argument("--at-once", type=int, default=2)
    parser.add_argument("--again", action="store_true", help="run all tests for coverage anew")
    parser.add_argument("--tests", nargs="*", default=[], help="folders of tests; all otherwise")
    options = parser.parse_args()
    if options.again:
        (KEPT / "coverage").unlink(missing_ok=True)
        (KEPT / "times").unlink(missing_ok=True)
    packages = {"paths": tuple(options.paths)} if options.paths else PACKAGES
    reasons = known_equivalents()
    short = []
    with TemporaryDirectory() as folder:
        copies: SimpleQueue[Copy] = SimpleQueue()
        for number in range(options.at_once):
            copies.put(copy := Copy(ROOT, Path(folder, str(number))))
        tests = which_tests(options, copy)
        for name, mutants in sample(packages, options.number, options.seed, options.only).items():
            print(f"{name}: {len(mutants)} mutants", flush=True)
            real = [m for m in mutants if (m.path, m.function, m.before, m.after) not in reasons]
            fates: dict[Fate, int] = defaultdict(int)
            for fate in try_all(real, tests, copies, options.at_once):
                fates[fate] += 1
            died = fates["killed"] + fates["timed out"]
            share = died / max(len(real), 1)
            print(
                f"{name}: {died} of {len(real)} died ({share:.0%}), "
                f"{len(mutants) - len(real)} change nothing", flush=True,
            )  # fmt: skip
            short += [name] * (share < ASKED)
    raise SystemExit(f"below {ASKED:.0%}: {', '.join(short)}" if short else 0)


if __name__ == "__main__":
    main()
