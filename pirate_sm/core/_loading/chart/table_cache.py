"""Cache explored charts between runs, by the hash of the chart's text."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import asdict
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from platformdirs import user_cache_path

from pirate_sm.core._engine.robot.robot_spec import ChartTable
from pirate_sm.core._loading.chart import exploration as chart
from pirate_sm.core._loading.chart.exploration import Watch, compile_chart
from pirate_sm.core._loading.chart.outline import ChartOutline
from pirate_sm.core._loading.problems import Problems
from pirate_sm.core._loading.yaml.document import Document
from pirate_sm.core.on_disk import replace_file


def cached_table(
    document: Document, outline: ChartOutline, problems: Problems, watch: Watch = lambda share: None
) -> ChartTable:
    """Return the chart's table, from the cache or from a new exploration.

    A cache that cannot be read or written is ignored.

    Raises:
        LoadError: The library refuses the chart.
    """
    path = cache_folder() / f"chart-{_key(document)}.json"
    table = _read(path)
    if table is None or not _is_sound(table, outline):
        table = compile_chart(document, outline, problems, watch)
        _write(path, table)
    return table


def cache_folder() -> Path:
    """Return the user's cache folder."""
    return user_cache_path("pirate_sm", appauthor=False)


def _key(document: Document) -> str:
    try:
        library = version("python-statemachine")
    except PackageNotFoundError:  # pragma: no cover - it is a dependency
        library = "unknown"
    # An earlier version of the compiler may give other reasons for refusals.
    compiler = Path(chart.__file__).read_text(encoding="utf-8")
    return sha256(f"{library}\n{compiler}\n{document.complete_text}".encode()).hexdigest()[:32]


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
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None


def _is_sound(table: ChartTable, outline: ChartOutline) -> bool:
    """Return whether a table from a file is valid for this chart."""
    if (table.regions, table.states) != (outline.regions, outline.states):
        return False
    if table.commands != outline.commands or not table.configurations:
        return False
    states = [set(names) for names in table.states]
    return (
        all(_is_row(row, len(states)) for row in table.configurations)
        and all(
            name in names
            for row in table.configurations
            for name, names in zip(row, states, strict=True)
        )
        and _is_matrix(table.following, table, len(table.configurations))
        and _is_matrix(table.refusals, table, len(table.reasons))
        and all(isinstance(reason, str) for reason in table.reasons)
    )


def _is_row(row: tuple[object, ...], length: int) -> bool:
    return len(row) == length and all(isinstance(name, str) for name in row)


def _is_matrix(rows: tuple[tuple[object, ...], ...], table: ChartTable, limit: int) -> bool:
    """Return whether there is an index below ``limit`` for each configuration and command."""
    return len(rows) == len(table.configurations) and all(
        len(row) == len(table.commands)
        and all(type(index) is int and 0 <= index < limit for index in row)
        for row in rows
    )


def _write(path: Path, table: ChartTable) -> None:
    data = asdict(table)
    data.pop("_index")
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_file(path, json.dumps(data).encode())
