"""Robots in whose files something has been put for something else, and what is said of them."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from pathlib import Path

from pirate_sm.checking.findings import Finding

ROOT = Path(__file__).resolve().parents[3]
NEWT = ROOT / "tests" / "robots" / "newt"
PIRATE = ROOT / "hardware_profiles" / "pirate_ii"


def changed(robot: Path, folder: Path, file: str, *swaps: tuple[str, str]) -> Path:
    """A copy of a robot in which each first text of a swap has become the second."""
    target = folder / robot.name
    shutil.copytree(robot, target)
    swap(target / file, *swaps)
    return target


def swap(file: Path, *swaps: tuple[str, str]) -> None:
    text = file.read_text(encoding="utf-8")
    for old, new in swaps:
        assert old in text, f"nothing to swap: {old}"
        text = text.replace(old, new, 1)
    file.write_text(text, encoding="utf-8")


def told(findings: Iterable[Finding]) -> list[tuple[str, str]]:
    """Code of each finding, and what stands in the file from its place on."""
    return [(each.code, each.excerpt[each.place.column - 1 :]) for each in findings]
