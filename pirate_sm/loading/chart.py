"""A chart file becomes a table: the library runs it, once, over everything it can reach.

The library is the semantics. It is asked what follows from every reachable configuration by
every command; nothing here decides a transition. What it silently accepts and we do not
(an unquoted or dangling ``In``, a missing target) is refused before, with its place.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pirate_sm.engine.chart_table import ChartTable, Configuration
from pirate_sm.loading.problems import Path, Problems
from pirate_sm.spelling import nearest, one_of

if TYPE_CHECKING:
    from pirate_sm.loading.source import Document

MOST_CONFIGURATIONS = 20_000
"""A chart that reaches more is refused: everything after this relies on walking all of them."""

_CALL = re.compile(r"\bIn\s*\(([^()]*)\)")


@dataclass(frozen=True)
class Transition:
    """A transition as the file has it; used to say why a command is refused."""

    region: str
    source: str
    event: str
    target: str
    guard: str
    path: Path


@dataclass(frozen=True)
class ChartOutline:
    """What a chart file declares, with places: its regions, states, events and guards."""

    regions: tuple[str, ...]
    states: tuple[tuple[str, ...], ...]
    initial: tuple[str, ...]
    transitions: tuple[Transition, ...]

    @property
    def commands(self) -> tuple[str, ...]:
        """Every event name, in the order of the file."""
        return tuple(dict.fromkeys(transition.event for transition in self.transitions))


def outline_chart(document: Document, problems: Problems) -> ChartOutline | None:
    """The chart's declarations are known and consistent, or the problems say what is wrong."""
    about = problems.about(document)
    before = len(problems.errors)
    regions = _regions(document.data, about)
    if regions is None:
        return None
    outline = _outline(regions, about)
    _check_transitions(outline, about)
    return outline if len(problems.errors) == before else None


def compile_chart(document: Document, outline: ChartOutline, problems: Problems) -> ChartTable:
    """Every reachable configuration and what each command does to it is in the table.

    Raises:
        LoadError: The library refuses the chart, or it reaches too many configurations.
    """
    from statemachine.exceptions import StateMachineError  # noqa: PLC0415
    from statemachine.io import load  # noqa: PLC0415

    about = problems.about(document)
    try:
        machine = load("\n".join(document.lines), format="yaml")()
    except (StateMachineError, ValueError, TypeError, KeyError) as error:
        about.add("chart.invalid", (), f"the statechart library refuses this chart: {error}")
        about.raise_errors()
        raise
    explored = _explore(machine, outline)
    if explored is None:
        about.add(
            "chart.too_large", (), f"the chart reaches more than {MOST_CONFIGURATIONS} combinations"
        )
        about.raise_errors()
        raise AssertionError("raise_errors raises here")
    configurations, following = explored
    reasons: dict[str, int] = {"": 0}
    refusals = tuple(
        tuple(
            reasons.setdefault(_reason(outline, states, command), len(reasons))
            if following[index][number] == index
            else 0
            for number, command in enumerate(outline.commands)
        )
        for index, states in enumerate(configurations)
    )
    return ChartTable(
        outline.regions, outline.states, outline.commands,
        configurations, following, refusals, tuple(reasons),
    )  # fmt: skip


def _regions(data: Any, problems: Problems) -> Mapping[str, Any] | None:
    """The mapping of regions under the one parallel state."""
    top = data.get("states") if isinstance(data, dict) else None
    if not isinstance(top, dict) or len(top) != 1:
        problems.add(
            "chart.shape", (), "a chart has `states` with exactly one parallel state in it"
        )
        return None
    name, body = next(iter(top.items()))
    regions = body.get("states") if isinstance(body, dict) else None
    if not isinstance(regions, dict) or not regions or body.get("parallel") is not True:
        problems.add(
            "chart.shape", ("states", name),
            "the chart's one state needs `parallel: true` and `states`, one per state machine",
        )  # fmt: skip
        return None
    for region, inside in regions.items():
        states = inside.get("states") if isinstance(inside, dict) else None
        if not isinstance(states, dict) or not states:
            problems.add(
                "chart.shape", ("states", name, "states", region), "a region needs `states`"
            )
            return None
    return {f"{name}": regions}


def _outline(tree: Mapping[str, Any], problems: Problems) -> ChartOutline:
    (top, regions), *_ = tree.items()
    states: list[tuple[str, ...]] = []
    initial: list[str] = []
    transitions: list[Transition] = []
    for region, inside in regions.items():
        at: Path = ("states", top, "states", region, "states")
        names = []
        for state, body in inside["states"].items():
            if not state.startswith(f"{region}.") or state.count(".") != 1:
                problems.add(
                    "chart.name", (*at, state), f"a state of {region} is named `{region}.<State>`",
                    key=True,
                )  # fmt: skip
            names.append(state.removeprefix(f"{region}."))
            if isinstance(body, dict) and body.get("initial") is True:
                initial.append(names[-1])
            transitions += _transitions(region, state, body, (*at, state), problems)
        states.append(tuple(names))
        if len(initial) != len(states):
            problems.add("chart.initial", at[:-1], f"{region} needs exactly one `initial: true`")
            initial[len(states) - 1 :] = [names[0]]
    return ChartOutline(tuple(regions), tuple(states), tuple(initial), tuple(transitions))


def _transitions(
    region: str, state: str, body: Any, at: Path, problems: Problems
) -> Iterator[Transition]:
    listed = (body or {}).get("transitions") or [] if isinstance(body or {}, dict) else []
    for number, item in enumerate(listed):
        path = (*at, "transitions", number)
        if not isinstance(item, dict) or not {"event", "target"} <= item.keys():
            problems.add("chart.transition", path, "a transition needs `event` and `target`")
            continue
        unknown = sorted(item.keys() - {"event", "target", "cond"})
        for key in unknown:
            problems.add(
                "chart.key", (*path, key), f"a command's transition cannot have `{key}`",
                expected="event, target, cond", key=True,
            )  # fmt: skip
        yield Transition(
            region, state, str(item["event"]), str(item["target"]), str(item.get("cond", "")), path
        )


def _check_transitions(outline: ChartOutline, problems: Problems) -> None:
    known = [
        f"{region}.{state}"
        for region, states in zip(outline.regions, outline.states, strict=True)
        for state in states
    ]
    for transition in outline.transitions:
        if transition.target not in known:
            problems.add(
                "chart.target", (*transition.path, "target"),
                f"there is no state '{transition.target}'",
                suggestion=nearest(transition.target, known) or "",
            )  # fmt: skip
        elif not transition.target.startswith(f"{transition.region}."):
            problems.add(
                "chart.target", (*transition.path, "target"),
                f"a transition of {transition.region} must stay in {transition.region}",
            )  # fmt: skip
        _check_guard(transition, known, problems)


def _check_guard(transition: Transition, known: list[str], problems: Problems) -> None:
    path = (*transition.path, "cond")
    if not transition.guard:
        return
    for call in _CALL.finditer(transition.guard):
        argument = call.group(1).strip()
        name = argument.strip("'\"")
        if argument[:1] not in {"'", '"'} or argument[-1:] != argument[:1]:
            problems.add(
                "chart.guard", path,
                f"In({argument}) is always true without quotes; write In('{name}')",
            )  # fmt: skip
        elif name not in known:
            problems.add(
                "chart.guard", path, f"there is no state '{name}'",
                suggestion=nearest(name, known) or "",
            )  # fmt: skip
    try:
        guard = ast.parse(transition.guard.strip(), mode="eval")
    except SyntaxError:
        problems.add(
            "chart.guard", path, "this guard cannot be read", expected="In('…') with and, or, not"
        )
        return
    foreign = [node for node in ast.walk(guard.body) if not _is_guard_node(node)]
    if foreign:
        problems.add(
            "chart.guard", path, "a guard may only use In('…'), and, or, not, and parentheses"
        )


def _is_guard_node(node: ast.AST) -> bool:
    allowed = (
        ast.BoolOp, ast.And, ast.Or, ast.UnaryOp, ast.Not,
        ast.Call, ast.Load, ast.Name, ast.Constant,
    )  # fmt: skip
    if isinstance(node, ast.Name):
        return node.id == "In" or not node.id.startswith("_")
    return isinstance(node, allowed)


def _explore(
    machine: Any, outline: ChartOutline
) -> tuple[tuple[Configuration, ...], tuple[tuple[int, ...], ...]] | None:
    """Breadth-first over everything that the library says can be reached."""
    from statemachine.orderedset import OrderedSet  # noqa: PLC0415

    first = tuple(machine.configuration_values)
    found: dict[frozenset[str], int] = {frozenset(first): 0}
    order: list[tuple[str, ...]] = [first]
    following: list[tuple[int, ...]] = []
    for values in order:
        row = []
        for command in outline.commands:
            machine.current_state_value = OrderedSet(values)
            machine.send(command)
            reached = tuple(machine.configuration_values)
            index = found.setdefault(frozenset(reached), len(order))
            if index == len(order):
                order.append(reached)
                if len(order) > MOST_CONFIGURATIONS:
                    return None
            row.append(index)
        following.append(tuple(row))
    return tuple(_names(outline, values) for values in order), tuple(following)


def _names(outline: ChartOutline, values: tuple[str, ...]) -> Configuration:
    by_region = dict(value.split(".", 1) for value in values if "." in value)
    return tuple(by_region[region] for region in outline.regions)


def _reason(outline: ChartOutline, states: Configuration, command: str) -> str:
    """Which guard says no, or that no state machine knows the command here."""
    active = {f"{region}.{state}" for region, state in zip(outline.regions, states, strict=True)}
    denials: list[str] = []
    for transition in outline.transitions:
        if transition.event == command and transition.source in active and transition.guard:
            denials += _denials(ast.parse(transition.guard.strip(), mode="eval").body, active)
    if denials:
        return f"{one_of(dict.fromkeys(denials)).removeprefix('one of ')} says no"
    moves = sorted({t.source for t in outline.transitions if t.event == command})
    return f"no state machine knows it here (only from {', '.join(moves)})"


def _denials(guard: ast.expr, active: set[str]) -> list[str]:
    """The conjuncts of a guard that are false in this configuration."""
    parts = (
        guard.values if isinstance(guard, ast.BoolOp) and isinstance(guard.op, ast.And) else [guard]
    )
    return [f"guard {ast.unparse(part)}" for part in parts if not _holds(part, active)]


def _holds(node: ast.expr, active: set[str]) -> bool:
    """Whether a part of a guard holds; for explaining only, the library decides what happens."""
    if isinstance(node, ast.BoolOp):
        values = [_holds(part, active) for part in node.values]
        return all(values) if isinstance(node.op, ast.And) else any(values)
    if isinstance(node, ast.UnaryOp):
        return not _holds(node.operand, active)
    if isinstance(node, ast.Call) and isinstance(node.args[0], ast.Constant):
        return node.args[0].value in active
    return True
