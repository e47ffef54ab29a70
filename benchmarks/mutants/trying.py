"""Runs the tests against a mutant, in a copy of the tree."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Literal, TypeAlias

from benchmarks.mutants.making import Mutant

Fate: TypeAlias = Literal["killed", "survived", "not covered"]

_QUICK = 200
"""So many of the tests, the quickest, are tried before the others."""

_TEST_TIMEOUT_S = 30
"""A mutant that makes one test last longer is killed by that; no test takes a third of it."""


class Copy:
    """A copy of the tree in which one mutant after the other is tried.

    Args:
        root: The tree.
        folder: Where the copy is made.
    """

    def __init__(self, root: Path, folder: Path) -> None:
        self._root = root
        self._folder = folder
        listed = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=root, capture_output=True, text=True, check=True,
        )  # fmt: skip
        for name in filter(None, listed.stdout.split("\0")):
            if (root / name).exists():
                target = folder / name
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(root / name, target)

    def fate(self, mutant: Mutant, tests: Sequence[str]) -> Fate:
        """Return what the tests make of the mutant; the copy is as before afterwards.

        Args:
            mutant: The fault.
            tests: The tests that run its line, quick ones first.
        """
        if not tests:
            return "not covered"
        source = (self._root / mutant.path).read_bytes()
        target = self._folder / mutant.path
        target.write_bytes(mutant.apply(source))
        try:
            parts = (tests[:_QUICK], tests[_QUICK:])
            killed = any(self._fails(part) for part in parts if part)
        finally:
            target.write_bytes(source)
        return "killed" if killed else "survived"

    def _fails(self, tests: Sequence[str]) -> bool:
        names = self._folder / "tests_to_run.txt"
        names.write_text("\n".join(tests) + "\n")
        run = subprocess.run(
            [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-p", "no:xdist",
             "-p", "no:randomly", f"--timeout={_TEST_TIMEOUT_S}", f"@{names.name}"],
            cwd=self._folder, capture_output=True, check=False,
            env={**os.environ, "PYTHONPATH": str(self._folder), "PYTHONDONTWRITEBYTECODE": "1"},
        )  # fmt: skip
        return run.returncode != 0
