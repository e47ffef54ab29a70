"""Which tests run each line of the code, and how long each of them takes."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

TIMES = "MUTANTS_TIMES"
"""The environment variable that names the file for the durations of the tests."""


@dataclass(frozen=True)
class Coverage:
    """What the tests run.

    Attributes:
        lines: By file and line the tests that run it, quick ones first.
    """

    lines: Mapping[str, Mapping[int, list[str]]]

    def tests(self, path: str, line: int) -> list[str]:
        """Return the tests that run the line, quick ones first."""
        return self.lines.get(path, {}).get(line, [])


def measure(
    root: Path, files: Iterable[str], kept: Path, at_once: int, tests: Sequence[str] = ()
) -> Coverage:
    """Return what the tests of the tree run, as the newest run in ``kept`` says, or by a new run.

    Args:
        root: The tree.
        files: Files of interest, relative to the tree.
        kept: A folder in which the outcome is kept.
        at_once: How many tests run at once.
        tests: Where tests are looked for; by default all there are.

    Raises:
        SystemExit: The tests fail without any mutant.
    """
    data, times = kept / "coverage", kept / "times"
    if not data.exists():
        kept.mkdir(parents=True, exist_ok=True)
        folders = {f"--cov={Path(each).parent}" for each in files}
        run = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", f"-n{at_once}", "-p", __name__, *sorted(folders),
             "--cov-context=test", "--cov-report=", "-p", "no:cacheprovider", *tests],
            cwd=root, check=False,
            env={**os.environ, "COVERAGE_FILE": str(data), TIMES: str(times)},
        )  # fmt: skip
        if run.returncode:
            data.unlink(missing_ok=True)
            raise SystemExit("the tests fail without any mutant: fix that first")
    return _read(root, files, data, times)


def _read(root: Path, files: Iterable[str], data: Path, times: Path) -> Coverage:
    from coverage import CoverageData  # of the extra `mutants`, which the tests do not need

    took: dict[str, float] = {}
    for line in times.read_text().splitlines():
        seconds, name = line.split(" ", 1)
        took[name] = float(seconds)
    covered = CoverageData(str(data))
    covered.read()
    lines = {}
    for path in files:
        contexts = covered.contexts_by_lineno(str(root / path))
        lines[path] = {
            line: sorted(
                {name.rpartition("|")[0] for name in names if name},
                key=lambda name: (took.get(name, 0.0), name),
            )
            for line, names in contexts.items()
        }
    return Coverage(lines)


@pytest.hookimpl
def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Write down how long the test took, where this file is a plugin of pytest."""
    if report.when == "call" and "PYTEST_XDIST_WORKER" not in os.environ:
        with Path(os.environ[TIMES]).open("a") as file:
            file.write(f"{report.duration:.4f} {report.nodeid}\n")
