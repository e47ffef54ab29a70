"""Prints what to install for some extras and groups of pyproject.toml: their part of the lock.

The lock is one file for all of them, and pip installs the whole of a file with hashes. Without a
lock it prints the ranges of pyproject.toml.
"""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parent
PIN = re.compile(r"^([\w.-]+)==.*(?:\n .*)*\n", re.M)
REQUIRER = re.compile(r"^    #(?: via|  ) ([\w.-]+)$", re.M)


def ranges(names: list[str]) -> list[str]:
    """Return what the package needs with these extras and groups, as pyproject.toml has it."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    optional = project["project"]["optional-dependencies"] | project["dependency-groups"]
    return [*project["project"]["dependencies"], *(n for name in names for n in optional[name])]


def locked(lock: str, names: list[str]) -> str:
    """Return the part of a lock that the package needs with these extras and groups.

    Raises:
        SystemExit: The lock lacks some of it, and is to be updated.
    """
    first = (re.split(r"[^\w.-]", each, maxsplit=1)[0] for each in ranges(names))
    wanted = {re.sub(r"[-_.]+", "-", name).lower() for name in first}
    pins = list(PIN.finditer(lock))
    if missing := wanted - {pin[1] for pin in pins}:
        sys.exit(f"requirements.lock lacks {', '.join(sorted(missing))}: run make update")
    known = 0
    while known < len(wanted):
        known = len(wanted)
        wanted |= {pin[1] for pin in pins if not wanted.isdisjoint(REQUIRER.findall(pin[0]))}
    return "".join(pin[0] for pin in pins if pin[1] in wanted)


if __name__ == "__main__":
    lock, *names = sys.argv[1:]
    names = [name for each in names for name in each.split(",")]
    text = locked(Path(lock).read_text("utf-8"), names) if lock else "\n".join(ranges(names))
    sys.stdout.write(text)
