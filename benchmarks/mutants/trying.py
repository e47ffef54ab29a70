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

Fate: TypeAlias = Literal["killed", "timed out", "survived", "not covered"]

_BUILT = "pirate_sm/simulation/machine_code/functions.library"
"""The simulator's machine code, kept by no version control; tests compile what they lack."""

_TEST_TIMEOUT_S = 30
"""A mutant that makes one test last longer has died of that; no test takes a third of it."""


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
        for name in (*filter(None, listed.stdout.split("\0")), _BUILT):
            if (root / name).exists():
                target = folder / name
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(root / name, target)
        # Modules that are known by what is in them: a mutant is never taken for what it was.
        subprocess.run(
            [sys.executable, "-m", "compileall", "-q", "--invalidation-mode", "checked-hash", "."],
            cwd=folder, capture_output=True, check=False,
        )  # fmt: skip

    def fate(self, mutant: Mutant, parts: Sequence[Sequence[str]]) -> Fate:
        """Return what the tests make of the mutant; the copy is as before afterwards.

        Args:
            mutant: The fault.
            parts: Tests or their folders, in parts that are run one after the other, quick ones
                first.
        """
        if not parts:
            return "not covered"
        source = (self._root / mutant.path).read_bytes()
        target = self._folder / mutant.path
        target.write_bytes(mutant.apply(source))
        try:
            for part in parts:
                if (fate := self._run(part)) != "survived":
                    return fate
        finally:
            target.write_bytes(source)
        return "survived"

    def passes(self, parts: Sequence[Sequence[str]]) -> bool:
        """Return whether the tests pass without any mutant."""
        return all(self._run(part) == "survived" for part in parts)

    def _run(self, tests: Sequence[str]) -> Fate:
        names = self._folder / "tests_to_run.txt"
        names.write_text("\n".join(tests) + "\n")
        run = subprocess.run(
            [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-p", "no:xdist",
             "-p", "no:randomly", f"--timeout={_TEST_TIMEOUT_S}", f"@{names.name}"],
            cwd=self._folder, capture_output=True, check=False,
            env={**os.environ, "PYTHONPATH": str(self._folder), "PYTHONDONTWRITEBYTECODE": "1"},
        )  # fmt: skip
        if run.returncode == 0:
            return "survived"
        return "timed out" if b"Failed: Timeout" in run.stdout else "killed"
