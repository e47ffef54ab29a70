"""How many branches of each kind the shipped missions have; `make golden` writes the list again."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

from pirate_sm.core import library
from pirate_sm.core.branches import branches
from pirate_sm.core.loading import load_mission

LIST = Path(__file__).with_name("branches.txt")


def test_the_shipped_missions_have_these_branches() -> None:
    lines = []
    for path in library.missions():
        loaded = load_mission(path)
        commands = tuple(each.name for each in loaded.robot.commands)
        counts = Counter(key.kind for key in branches(loaded.program, commands))
        kinds = ", ".join(f"{kind} {count}" for kind, count in sorted(counts.items()))
        lines.append(f"{path.stem}: {kinds}\n")
    if os.environ.get("GOLDEN") == "write":
        LIST.write_text("".join(lines), "utf-8")

    assert LIST.read_text("utf-8") == "".join(lines)
