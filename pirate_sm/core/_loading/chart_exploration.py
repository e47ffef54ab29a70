"""Explore a chart with the statechart library, and build and cache the table of its configurations.

The library defines the semantics. It computes the result of every command in every reachable
configuration; this module decides no transition itself.
"""

from __future__ import annotations

import ast
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, TypeAlias

from pirate_sm.core._engine.robot.robot_spec import ChartTable, Configuration
from pirate_sm.core._loading.chart_outline import (
    ChartOutline,
    StateNode,
    States,
    asked_by,
    conjuncts,
    holds,
)
from pirate_sm.core._loading.problems import Problems
from pirate_sm.core._loading.yaml.document import Document
from pirate_sm.core.kept_entries import charts, digest

MOST_CONFIGURATIONS = 20_000
"""Largest number of configurations of a chart, because later checks visit all of them."""

MOST_RESULTS = 2_000_000
"""Largest number of configurations times commands: the table holds the result of each pair."""


Watch: TypeAlias = Callable[[float], None]
"""Is called with the explored share of the configurations that have been reached, 0 to 1."""


def compile_chart(
    document: Document, outline: ChartOutline, problems: Problems, watch: Watch = lambda share: None
) -> ChartTable:
    """Return the table of every reachable configuration and every command in it.

    Raises:
        LoadError: The library refuses the chart, or it reaches too many configurations.
    """
    from statemachine.io import load  # noqa: PLC0415

    about = problems.about(document)
    try:
        # As JSON: the library would read the file as YAML 1.1, where `on` and `Off` are booleans.
        machine = load(json.dumps(_plain(outline)), format="json")()
    except Exception as error:  # any exception of the library is due to the file
        about.add("chart.invalid", (), f"the statechart library refuses this chart: {error}")
        about.raise_errors()
        raise
    explored = _explore(machine, outline, watch)
    if explored is None:
        count = len(outline.commands)
        most = min(MOST_CONFIGURATIONS, MOST_RESULTS // max(count, 1))
        message = f"the chart reaches more than {most} combinations of states with {count} commands"
        about.add("chart.too_large", (), message)
        about.raise_errors()
        raise AssertionError("raise_errors raises here")
    configurations, following = explored
    reasons: dict[str, int] = {"": 0}
    explain = _Reasons(outline).of
    refusals = tuple(
        tuple(
            reasons.setdefault(explain(states, command), len(reasons))
            if following[index][number] == index
            else 0
            for number, command in enumerate(outline.commands)
        )
        for index, states in enumerate(configurations)
    )
    return ChartTable(
        outline.regions,
        outline.states,
        outline.commands,
        configurations,
        following,
        refusals,
        tuple(reasons),
    )


def _plain(outline: ChartOutline) -> dict[str, Any]:
    """Return the chart with neutral names for regions and events.

    The library turns these names into attributes; a name such as `send` would replace its own.
    """
    regions = {
        f"region_{number}": {"states": {each.name: _state(each, outline) for each in nodes}}
        for number, nodes in enumerate(outline.nodes)
    }
    return {"name": "chart", "states": {"top": {"parallel": True, "states": regions}}}


def _state(node: StateNode, outline: ChartOutline) -> dict[str, Any]:
    moves = [
        {
            "event": " ".join(_event(outline.commands.index(event)) for event in move.events),
            "target": move.target,
            **({"cond": move.guard} if move.guard else {}),
        }
        for move in node.moves
    ]
    inner = {each.name: _state(each, outline) for each in node.inner}
    return {"initial": node.initial, "transitions": moves, **({"states": inner} if inner else {})}


def _event(number: int) -> str:
    return f"command_{number}"


def _explore(
    machine: Any, outline: ChartOutline, watch: Watch
) -> tuple[tuple[Configuration, ...], tuple[tuple[int, ...], ...]] | None:
    """Return all configurations and transitions, breadth-first; None if there are too many."""
    from statemachine.orderedset import OrderedSet  # noqa: PLC0415

    count, sources = len(outline.commands), _sources_of(outline)
    first = tuple(machine.configuration_values)
    found: dict[frozenset[str], int] = {frozenset(first): 0}
    order: list[tuple[str, ...]] = [first]
    following: list[tuple[int, ...]] = []
    for values in order:
        row = []
        for number, command in enumerate(outline.commands):
            if sources[command].isdisjoint(values):  # without a transition nothing changes
                row.append(len(following))
                continue
            machine.current_state_value = OrderedSet(values)
            machine.send(_event(number))
            reached = tuple(machine.configuration_values)
            index = found.setdefault(frozenset(reached), len(order))
            if index == len(order):
                order.append(reached)
                if len(order) > MOST_CONFIGURATIONS or len(order) * count > MOST_RESULTS:
                    return None
            row.append(index)
        following.append(tuple(row))
        watch(len(following) / len(order))
    return tuple(_names(outline, values) for values in order), tuple(following)


def _sources_of(outline: ChartOutline) -> dict[str, set[str]]:
    """Return the states from which each command has a transition."""
    sources: dict[str, set[str]] = {command: set() for command in outline.commands}
    for transition in outline.transitions:
        sources[transition.event].add(transition.source)
    return sources


def _names(outline: ChartOutline, values: tuple[str, ...]) -> Configuration:
    return tuple(
        next(name for name in names if f"{region}.{name}" in values)
        for region, names in zip(outline.regions, outline.states, strict=True)
    )


class _Reasons:
    """Says why commands are refused."""

    def __init__(self, outline: ChartOutline) -> None:
        self._regions = outline.regions
        self._states = {each: [*_sources(outline, each)] for each in outline.commands}
        self._guards: dict[str, list[tuple[str, ast.expr]]] = {}
        for each in outline.transitions:
            if each.tree:
                self._guards.setdefault(each.event, []).append((each.source, each.tree))

    def of(self, states: Configuration, command: str) -> str:
        """Return the unmet conditions of the command, or the states in which it is possible."""
        ways: dict[str, None] = {}
        if guards := self._guards.get(command):
            named = dict(zip(self._regions, states, strict=True))
            active = {f"{region}.{state}" for region, state in named.items()}
            needs = [_denials(tree, named) for source, tree in guards if source in active]
            ways = dict.fromkeys(map(_joined, filter(None, needs)))
        return f"it needs {', or '.join(ways or self._states[command])}"


def _sources(outline: ChartOutline, command: str) -> Iterator[str]:
    """Yield the states in which a command is possible, as conditions of a mission."""
    found: dict[str, dict[str, None]] = {}
    for transition in outline.transitions:
        if transition.event == command:
            state = transition.source.partition(".")[2]
            found.setdefault(transition.region, {})[state] = None
    for region, states in found.items():
        some = len(states) > 1
        yield f"{region} in ({', '.join(states)})" if some else f"{region} == {next(iter(states))}"


def _joined(parts: Sequence[str]) -> str:
    if len(parts) == 1:
        return parts[0]
    return " and ".join(f"({part})" if " or " in part else part for part in parts)


def _denials(guard: ast.expr, states: States) -> list[str]:
    """Return the conjuncts of a guard that are false in this configuration."""
    return [_said(part) for part in conjuncts(guard) if not holds(part, states)]


def _said(node: ast.expr) -> str:
    """Return a part of a guard as missions write it: ``Region == state``, ``Region in (…)``."""
    if isinstance(node, ast.Call):
        region, states = asked_by(node)
        return f"{region} in ({', '.join(states)})" if states[1:] else f"{region} == {states[0]}"
    if isinstance(node, ast.UnaryOp) and isinstance(node.operand, ast.Call):
        said = _said(node.operand)
        return said.replace(" == ", " != ") if " == " in said else f"not {said}"
    if isinstance(node, ast.BoolOp):
        word = " and " if isinstance(node.op, ast.And) else " or "
        parts = [_said(part) for part in node.values]
        regions = {part.partition(" == ")[0] for part in parts}
        if word == " or " and len(regions) == 1 and all(" == " in part for part in parts):
            return f"{regions.pop()} in ({', '.join(part.partition(' == ')[2] for part in parts)})"
        return word.join(
            f"({part})" if " and " in part or " or " in part else part for part in parts
        )
    return ast.unparse(node)


def cached_table(
    document: Document, outline: ChartOutline, problems: Problems, watch: Watch = lambda share: None
) -> ChartTable:
    """Return the chart's table, from the cache or from a new exploration.

    A cache that cannot be read or written is ignored.

    Raises:
        LoadError: The library refuses the chart.
    """
    entries, key = charts(), _key(document)
    try:
        return _read(entries.read(key))
    except (ValueError, LookupError, TypeError):  # there is none, or it is malformed
        table = compile_chart(document, outline, problems, watch)
    data = asdict(table)
    data.pop("_index")
    entries.write({key: data})
    return table


def _key(document: Document) -> str:
    try:
        library = version("python-statemachine")
    except PackageNotFoundError:  # pragma: no cover - it is a dependency
        library = "unknown"
    # An earlier version of the compiler may give other reasons for refusals.
    compiler = Path(__file__).read_text(encoding="utf-8")
    return digest(f"{library}\n{compiler}\n{document.complete_text}".encode())


def _read(data: Any) -> ChartTable:
    return ChartTable(
        tuple(data["regions"]),
        tuple(map(tuple, data["states"])),
        tuple(data["commands"]),
        tuple(map(tuple, data["configurations"])),
        tuple(map(tuple, data["following"])),
        tuple(map(tuple, data["refusals"])),
        tuple(data["reasons"]),
    )
