"""States and parts of which the profile does not say how they show themselves to the sensors."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.robot_view import RobotView
from pirate_sm.loading.problems import Path


def check_sight(view: RobotView) -> Iterator[Finding]:
    """Find states and parts that are left open at a start without a reason."""
    profile, table = view.profile, view.loaded.table
    seen = profile.seen
    if "seen" not in profile.model_fields_set:
        message = "the profile does not say how states show themselves: add `seen`"
        yield view.at(("robot",), "robot.unseen", Severity.WARNING, message, key=True)
        return
    for region, states in zip(table.regions, table.states, strict=True):
        missing = [state for state in states if state not in seen.states.get(region, {})]
        if missing:
            path: Path = ("seen", "states", region) if region in seen.states else ("seen",)
            message = f"`seen` says nothing of {region}: {', '.join(missing)}"
            yield view.at(path, "robot.unseen", Severity.WARNING, message, key=True)
    parts = [name for name in profile.body.parts if name not in seen.parts]
    if parts:
        message = f"`seen` does not say how a held part shows itself: {', '.join(parts)}"
        path = ("seen", "parts") if seen.parts else ("seen",)
        yield view.at(path, "robot.unseen", Severity.WARNING, message, key=True)
