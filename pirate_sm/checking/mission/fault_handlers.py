"""A rule about `on_fault`: no line handles a fault that an earlier one handles."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.checking.findings import Finding, at
from pirate_sm.checking.mission.mission_view import MissionView


def fault_handlers(view: MissionView) -> Iterator[Finding]:
    """Yield a finding for each fault that an earlier line of `on_fault` has named."""
    loaded = view.loaded
    document, handled = loaded.documents[0], dict[str, int]()
    for number, handler in enumerate(loaded.mission.on_fault):
        for place, code in enumerate(handler.fault):
            if handled.setdefault(code, number) != number:
                message = f"'{code}' is handled by an earlier line"
            elif code in handler.fault[:place]:
                message = f"'{code}' appears twice in one list"
            else:
                continue
            where = document.place_of(("on_fault", number, "fault", place))
            yield at(document, where, "handler.twice", message)
