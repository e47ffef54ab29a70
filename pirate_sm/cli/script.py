"""What a trace shall fire: from the command line, or from a YAML file."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite
from pathlib import Path

from pirate_sm.errors import UsageError
from pirate_sm.loading import script as loading
from pirate_sm.loading.source import read_document
from pirate_sm.model.course import Happening
from pirate_sm.runtime.companions import Firing


def read_fire(texts: Iterable[str]) -> list[Firing]:
    """The firings that ``--fire TRIGGER[=SECONDS]`` asks for.

    Raises:
        UsageError: One of them reads otherwise.
    """
    firings = []
    for text in texts:
        trigger, given, after = text.partition("=")
        firings.append(Firing(trigger, _seconds(after, text) if given else None))
    return firings


def _seconds(text: str, whole: str) -> float:
    try:
        after_s = float(text.strip().removesuffix("s"))
    except ValueError:
        after_s = -1.0
    if not (isfinite(after_s) and after_s >= 0):
        raise UsageError(f"--fire {whole}: expected TRIGGER or TRIGGER=SECONDS, such as past=2.5")
    return after_s


def read_script(path: Path) -> tuple[list[Firing], tuple[Happening, ...]]:
    """The firings that a file lists, or the whole course of events that it lays down.

    Raises:
        LoadError: Everything that is wrong with the file.
    """
    script = loading.read_script(read_document(path))
    return [Firing(each.trigger, each.after, each.phase) for each in script.entries], script.course
