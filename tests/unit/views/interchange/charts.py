"""Charts of robots, and charts drawn at random, with what other programs make of them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hypothesis import strategies as st
from statemachine.io import load

from pirate_sm.core._loading.chart_exploration import compile_chart
from pirate_sm.core.documents import Document, Problems, parse_document
from pirate_sm.core.loading import ChartOutline, outline_chart
from pirate_sm.core.robot import ChartTable

ROOT = Path(__file__).resolve().parents[4]
ROBOTS = sorted(each.parent for each in ROOT.glob("hardware_profiles/*/profile.yaml"))
ROBOTS += sorted(each.parent for each in ROOT.glob("tests/robots/*/profile.yaml"))

COMMANDS = ("Open", "Close", "Go")


def outlined(document: Document) -> ChartOutline:
    problems = Problems(document)
    outline = outline_chart(document, problems)
    problems.raise_errors()
    assert outline is not None
    return outline


def outline_of(data: dict[str, Any]) -> ChartOutline:
    return outlined(parse_document(json.dumps(data), "chart.yaml"))


def table_of(data: dict[str, Any]) -> ChartTable:
    document = parse_document(json.dumps(data), "chart.yaml")
    return compile_chart(document, outlined(document), Problems(document))


class Reread:
    """A statechart that python-statemachine has read from SCXML."""

    def __init__(self, scxml: str) -> None:
        self.machine = load(scxml, format="scxml")()

    def follow(self, commands: Sequence[str], regions: Sequence[str]) -> list[tuple[str, ...]]:
        """Send the commands, and return the states of the regions after each."""
        found = []
        for command in commands:
            self.machine.send(command)
            active = set(self.machine.configuration_values)
            leaves = [name.partition(".") for name in active if "." in name]
            inner = {(region, name) for region, _, name in leaves}
            compound = {parent.id for parent in self._parents(active)}
            found.append(
                tuple(
                    next(n for r, n in sorted(inner) if r == region and f"{r}.{n}" not in compound)
                    for region in regions
                )
            )
        return found

    def _parents(self, active: set[str]) -> list[Any]:
        return [state for state in self.machine.configuration if state.states]


def _guards(states: Sequence[str]) -> st.SearchStrategy[str]:
    leaves = st.sampled_from([f"In('{state}')" for state in states])
    return st.recursive(
        leaves,
        lambda inner: (
            inner.map(lambda it: f"not ({it})")
            | st.tuples(inner, st.sampled_from(["and", "or"]), inner).map(
                lambda it: f"({it[0]}) {it[1]} ({it[2]})"
            )
        ),
        max_leaves=4,
    )


@st.composite
def charts(draw: st.DrawFn) -> dict[str, Any]:
    """Draw the data of a chart: regions with states, some with states inside, and guards."""
    sizes = {f"Region{n}": draw(st.integers(1, 4)) for n in range(draw(st.integers(1, 3)))}
    leaves = {region: [f"{region}.S{n}" for n in range(size)] for region, size in sizes.items()}
    guards = st.none() | _guards([state for each in leaves.values() for state in each])

    def moves(targets: list[str]) -> list[dict[str, Any]]:
        found = []
        for _ in range(draw(st.integers(0, 3))):
            events = draw(st.lists(st.sampled_from(COMMANDS), min_size=1, max_size=2, unique=True))
            move = {"event": " ".join(events), "target": draw(st.sampled_from(targets))}
            guard = draw(guards)
            found.append(move | ({"cond": guard} if guard else {}))
        return found

    regions = {}
    for region, names in leaves.items():
        held = names[: draw(st.integers(0, len(names)))]
        targets = [*names, *([f"{region}.Held"] if held else [])]
        outside = {name: {"transitions": moves(targets)} for name in names if name not in held}
        if held:
            inside = {name: {"transitions": moves(targets)} for name in held}
            inside[draw(st.sampled_from(held))]["initial"] = True  # type: ignore[assignment]
            outside[f"{region}.Held"] = {"transitions": moves(targets), "states": inside}  # type: ignore[dict-item]
        outside[draw(st.sampled_from(list(outside)))]["initial"] = True  # type: ignore[assignment]
        regions[region] = {"states": outside}
    return {"name": "drawn", "states": {"whole": {"parallel": True, "states": regions}}}
