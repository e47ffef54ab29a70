"""Rules about `on_fault`: no fault is handled twice, and none of a part that holds is ignored."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

from pirate_sm.checking.findings import Finding, at
from pirate_sm.checking.mission.mission_view import MissionView


def fault_handlers(view: MissionView) -> Iterator[Finding]:
    """Yield a finding for each fault in `on_fault` that an earlier line handles already."""
    loaded = view.loaded
    document, owners = loaded.documents[0], loaded.robot.owners
    handled = list[tuple[str, frozenset[str] | None, int]]()
    for number, handler in enumerate(loaded.mission.on_fault):
        of = owners.things_of(handler.of) if handler.of else None
        for place, code in enumerate(handler.fault):
            before = [
                line
                for known, whose, line in handled
                if known == code and (whose is None or (of is not None and of <= whose))
            ]
            handled.append((code, of, number))
            if not before:
                continue
            message = f"'{code}' is handled by an earlier line"
            if before[0] == number:
                message = f"'{code}' appears twice in one list"
            where = document.place_of(("on_fault", number, "fault", place))
            yield at(document, where, "handler.twice", message)


def ignored_holding(view: MissionView) -> Iterator[Finding]:
    """Yield a finding for each line that only logs a fault of a part while that part holds."""
    found: dict[tuple[str, str], set[int]] = defaultdict(set)
    for book in view.seen:
        robot, program = book.found.robot, book.found.program
        for pc, configuration in {
            (node.state.mission.pc, node.state.robot.configuration) for node in book.found.nodes
        }:
            for handler in program.handlers[pc] if pc < len(program.handlers) else ():
                if handler.go is None:
                    can_be = robot.possible_owners.get(handler.code, frozenset())
                    of = can_be if handler.of is None else can_be & handler.of
                    held = (part for part in robot.held[configuration] if robot.proofs[part] & of)
                    found[handler.place, handler.code].update(held)
    for (place, code), parts in found.items():
        if parts:
            names = " and ".join(f"the {view.loaded.robot.parts[part]}" for part in sorted(parts))
            message = f"continues after '{code}' of a joint of {names}, while that part holds"
            yield view.places.finding(view.places.read(place), "handler.holding", message)
