"""A chart as seen by the rules: its file, its declarations, its table, and what its guards say."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod
from typing import TYPE_CHECKING

from pirate_sm.checking.findings import Finding, at
from pirate_sm.core.documents import Document, Place
from pirate_sm.core.loading import ChartOutline, States, asked_by, holds
from pirate_sm.core.robot import ChartTable

if TYPE_CHECKING:
    from pirate_sm.core.robot import ChartTable


# --- guards --------------------------------------------------------------------------------------
# A guard consists of `In('Region.State')`, and, or, not (the loader refuses anything else), so it
# depends on the states of the regions that it names. Every combination of states is *thinkable*;
# the combinations that commands lead to are *reached*.


MOST_COMBINATIONS = 4096
"""With more thinkable combinations a guard counts as not constant."""

_ELSEWHERE = ""


def offset_of(guard: str, node: ast.expr) -> int:
    """Return the offset of a part of a guard in the guard's text."""
    lines = guard.split("\n")
    before = sum(len(line) + 1 for line in lines[: node.lineno - 1])
    return before + len(lines[node.lineno - 1].encode()[: node.col_offset].decode())


def regions_of(node: ast.expr) -> frozenset[str]:
    """Return the regions that a part of a guard names."""
    return frozenset(region for region, _ in _questions(node))


def constant(
    node: ast.expr, states: Mapping[str, Iterable[str]], fixed: States | None = None
) -> bool | None:
    """Return the constant value of a part of a guard in all thinkable combinations, or None.

    Args:
        node: The part.
        states: The states of each region.
        fixed: Regions whose state is known.
    """
    named: dict[str, set[str]] = {}
    for region, asked in _questions(node):
        named.setdefault(region, set()).update(asked)
    choices = []
    for region, mentioned in named.items():
        if fixed and region in fixed:
            choices.append([fixed[region]])
        else:
            # All states that it does not name are equivalent.
            others = [_ELSEWHERE] if set(states[region]) - mentioned else []
            choices.append([*sorted(mentioned), *others])
    if prod(map(len, choices)) > MOST_COMBINATIONS:
        return None
    found = {holds(node, dict(zip(named, each, strict=True))) for each in product(*choices)}
    return found.pop() if len(found) == 1 else None


def constant_parts(
    node: ast.expr, states: Mapping[str, Iterable[str]]
) -> Iterator[tuple[ast.expr, bool]]:
    """Yield the largest parts that are constant in all thinkable combinations, with the value."""
    value = constant(node, states)
    if value is not None:
        yield node, value
    elif isinstance(node, ast.BoolOp):
        for part in node.values:
            yield from constant_parts(part, states)
    elif isinstance(node, ast.UnaryOp):
        yield from constant_parts(node.operand, states)


class ReachedCombinations:
    """The reached combinations, projected on a few regions at a time."""

    def __init__(self, table: ChartTable) -> None:
        self._table = table
        self._seen: dict[frozenset[str], list[dict[str, str]]] = {}

    def through(self, regions: frozenset[str]) -> list[dict[str, str]]:
        """Return the distinct reached combinations of the states of these regions."""
        if regions not in self._seen:
            places = [number for number, name in enumerate(self._table.regions) if name in regions]
            names = [self._table.regions[place] for place in places]
            rows = {tuple(row[p] for p in places): None for row in self._table.configurations}
            self._seen[regions] = [dict(zip(names, row, strict=True)) for row in rows]
        return self._seen[regions]


def _questions(node: ast.expr) -> Iterator[tuple[str, list[str]]]:
    for each in ast.walk(node):
        if isinstance(each, ast.Call):
            yield asked_by(each)


# --- the view ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ChartView:
    """A chart that is being checked."""

    document: Document
    outline: ChartOutline
    table: ChartTable

    @cached_property
    def reached(self) -> ReachedCombinations:
        """Return the combinations of states that commands reach."""
        return ReachedCombinations(self.table)

    @cached_property
    def states(self) -> dict[str, tuple[str, ...]]:
        """Return the states of each region."""
        return dict(zip(self.outline.regions, self.outline.states, strict=True))

    def at(
        self, place: Place, code: str, message: str, *, related: Sequence[tuple[Place, str]] = ()
    ) -> Finding:
        """Return a finding at a place of the chart's file."""
        return at(self.document, place, code, message, related=related)
