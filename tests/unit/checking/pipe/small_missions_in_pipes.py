"""Small missions in pipes, and what is found of them."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.pipe.check_in_pipe import pipe_findings, view_in_pipe
from pirate_sm.core.loading import LoadedMission, load_mission


def mission(do: str, pipe: str, *lines: str) -> str:
    return "\n".join(
        (
            "format: 1", "mission: m", "robot: pirate_ii", f"pipe: {pipe}", *lines, "start: a",
            "phases:", f"  a: {{do: {do}, go: e}}", "ends: {e: {succeed: ok}}",
        )
    )  # fmt: skip


def pipe(segments: str, rest: str = "") -> str:
    return f"{{diameter: 120 mm, segments: {segments}{rest}}}"


def found_in(loaded: LoadedMission) -> tuple[Finding, ...]:
    view = view_in_pipe(loaded)
    found = pipe_findings(view) if view is not None else ()
    return tuple(sorted(found, key=lambda each: each.order))


def findings(folder: Path, text: str, **options: str) -> tuple[Finding, ...]:
    file = folder / "m.yaml"
    file.write_text(text, encoding="utf-8")
    return found_in(load_mission(file, **options))
