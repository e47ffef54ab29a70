"""Explored charts are kept between runs, found again by the hash of the chart's text."""

from __future__ import annotations

import json
import os
import tempfile
from dataclasses import asdict
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from platformdirs import user_cache_path

from pirate_sm.engine.chart_table import ChartTable
from pirate_sm.loading.chart import ChartOutline, compile_chart
from pirate_sm.loading.problems import Problems
from pirate_sm.loading.source import Document

FORMAT = 1


def cached_table(document: Document, outline: ChartOutline, problems: Problems) -> ChartTable:
    """The chart's table, explored now or read from an earlier exploration of the same text.

    A cache that cannot be read or written is done without.

    Raises:
        LoadError: The library refuses the chart.
    """
    path = cache_folder() / f"chart-{_key(document)}.json"
    table = _read(path)
    if table is None:
        table = compile_chart(document, outline, problems)
        _write(path, table)
    return table


def cache_folder() -> Path:
    """Where what can be computed again is kept, for this user."""
    return user_cache_path("pirate_sm", appauthor=False)


def _key(document: Document) -> str:
    try:
        library = version("python-statemachine")
    except PackageNotFoundError:  # pragma: no cover - it is a dependency
        library = "unknown"
    text = "\n".join(document.lines)
    return sha256(f"{FORMAT}\n{library}\n{text}".encode()).hexdigest()[:32]


def _read(path: Path) -> ChartTable | None:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        return ChartTable(
            tuple(data["regions"]),
            tuple(map(tuple, data["states"])),
            tuple(data["commands"]),
            tuple(map(tuple, data["configurations"])),
            tuple(map(tuple, data["following"])),
            tuple(map(tuple, data["refusals"])),
            tuple(data["reasons"]),
        )
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _write(path: Path, table: ChartTable) -> None:
    data = asdict(table)
    data.pop("_index")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # Written aside and moved, so that two runs at once never read half a file.
        handle, name = tempfile.mkstemp(dir=path.parent, suffix=".part")
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            json.dump(data, file)
        Path(name).replace(path)
    except OSError:
        return
