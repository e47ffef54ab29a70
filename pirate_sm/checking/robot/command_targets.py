"""A rule about commands: `asks_for` describes the states that a command leads to."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.robot.robot_view import RobotView


def command_targets(view: RobotView) -> Iterator[Finding]:
    """Yield commands whose `asks_for` does not describe the states that they lead to."""
    table, unneeded = view.loaded.table, view.loaded.normal.unneeded
    for number, name in enumerate(table.commands):
        if view.profile.commands[name].asks_for.strip() == "false":
            continue  # a toggle is never unneeded
        message = ""
        met = [row[number] for row in unneeded]
        if not any(met):
            message = f"no combination of states is ever what {name} asks for"
        elif all(met):
            message = f"every combination of states is what {name} asks for"
        else:
            missed = [after for _, after in view.moves(number) if not met[after]]
            if missed:
                pairs = zip(table.regions, table.configurations[missed[0]], strict=True)
                states = ", ".join(f"{region} {state}" for region, state in pairs)
                message = f"{name} leads to {states}, which is not what it asks for"
        if message:
            yield view.at(("commands", name, "asks_for"), "robot.asks_for", message, offset=0)
