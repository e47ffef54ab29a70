"""Handlers of faults that never get their turn."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.checking.findings import Finding, Severity, at
from pirate_sm.loading.mission import LoadedMission


def handler_findings(loaded: LoadedMission) -> Iterator[Finding]:
    """A finding for each fault that an earlier line of `on_fault` handles already."""
    document, handled = loaded.documents[0], set[str]()
    for number, handler in enumerate(loaded.mission.on_fault):
        for place, code in enumerate(handler.fault):
            if code in handled:
                yield at(
                    document, document.place_of(("on_fault", number, "fault", place)),
                    "handler.twice", Severity.ERROR, f"'{code}' is handled by an earlier line",
                )  # fmt: skip
            handled.add(code)
