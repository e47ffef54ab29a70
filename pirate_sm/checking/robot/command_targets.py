"""Rules about where commands lead, and about the missions that travel along routes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.robot.robot_view import RobotView
from pirate_sm.core.documents import LoadError, Path, read_document
from pirate_sm.core.errors import UsageError
from pirate_sm.core.files import find_mission
from pirate_sm.core.loading import followed


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


def travel_missions(view: RobotView) -> Iterator[Finding]:
    """Yield missions and states of `travel` that are not there, and a `last` without its way."""
    travel, table = view.profile.travel, view.loaded.table
    if travel is None:
        return
    named: list[tuple[Path, str]] = [(("last",), travel.last)]
    named += [(("turns", n, "call"), each.call) for n, each in enumerate(travel.turns)]
    for number, passage in enumerate(travel.passages):
        calls = enumerate(passage.calls)
        named += [(("passages", number, "calls", place), call) for place, call in calls]
    for path, name in named:
        message = ""
        try:
            file = find_mission(name, view.loaded.folder)
            mission = read_document(followed(file, view.loaded.folder)).data
            parameters = mission.get("parameters")
            known = parameters if isinstance(parameters, Mapping) else {}
            if path == ("last",) and "way" not in known:
                message = f"'{name}' has no parameter `way`, by which it would drive on"
        except UsageError as error:
            message = str(error)
        except (LoadError, AttributeError):
            continue  # reported for the mission
        if message:
            yield view.at(("travel", *path), "robot.reference", message)
    states = dict(zip(table.regions, table.states, strict=True))
    for region, state in travel.starts_in.items():
        if state not in states.get(region, ()):
            message = f"{region} has no state '{state}'"
            yield view.at(("travel", "starts_in", region), "robot.reference", message)
