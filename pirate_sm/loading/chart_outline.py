"""What a chart file declares: regions, states, events and guards, each with its place.

Checked here, before the library runs the chart, because there it would pass in silence or fail
without a line: a misspelt key or target, an unquoted or dangling ``In``, a guard of other things.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pirate_sm.expressions import EnumType, Vocabulary
from pirate_sm.loading.problems import Path, Problems
from pirate_sm.spelling import nearest, one_of

if TYPE_CHECKING:
    from pirate_sm.loading.source import Document

_EVENT = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")
RESERVED = ("detector", "segment")
"""Words that conditions know besides the regions."""

_TOP_KEYS = ("name", "description", "states")
_STATE_KEYS = ("initial", "transitions")
_TRANSITION_KEYS = ("event", "target", "cond")
_NOT_SUPPORTED = frozenset(
    {"final", "history", "states", "parallel", "enter", "exit", "on", "before", "after", "unless",
     "internal", "validators", "donedata", "invoke", "datamodel"}
)  # fmt: skip
"""Keys that a statechart may have, and that are not supported here."""


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
    """What a chart file declares.

    Attributes:
        top: Name of the parallel state that holds the regions.
    """

    top: str
    regions: tuple[str, ...]
    states: tuple[tuple[str, ...], ...]
    initial: tuple[str, ...]
    transitions: tuple[Transition, ...]

    @property
    def commands(self) -> tuple[str, ...]:
        """Every event name, in the order of the file."""
        return tuple(dict.fromkeys(transition.event for transition in self.transitions))

    def place_of(self, region: str, state: str) -> Path:
        """Where a state stands in the file."""
        return ("states", self.top, "states", region, "states", f"{region}.{state}")


def outline_chart(document: Document, problems: Problems) -> ChartOutline | None:
    """The chart's declarations are known and consistent, or the problems say what is wrong."""
    about = problems.about(document)
    before = len(problems.errors)
    found = _regions(document.data, about)
    if found is None:
        return None
    outline = _outline(*found, about)
    known = [
        f"{region}.{state}"
        for region, states in zip(outline.regions, outline.states, strict=True)
        for state in states
    ]
    for transition in outline.transitions:
        _check_target(transition, known, about)
        if transition.guard:
            _check_guard(transition, known, about)
    return outline if len(problems.errors) == before else None


def _regions(data: Any, problems: Problems) -> tuple[str, Mapping[str, Any]] | None:
    """The one parallel state's name, and the regions in it."""
    top = data.get("states") if isinstance(data, dict) else None
    if not isinstance(top, dict) or len(top) != 1:
        message = "a chart has `states` with exactly one parallel state in it"
        problems.add("chart.shape", (), message)
        return None
    _refuse_unknown(data, _TOP_KEYS, (), problems)
    for key in ("name", "description"):
        if not isinstance(data.get(key, ""), str):
            problems.add("chart.shape", (key,), f"`{key}` must be text")
    name, body = next(iter(top.items()))
    regions = body.get("states") if isinstance(body, dict) else None
    if not isinstance(regions, dict) or not regions or body.get("parallel") is not True:
        problems.add(
            "chart.shape", ("states", name),
            "the chart's one state needs `parallel: true` and `states`, one per state machine",
            key=True,
        )  # fmt: skip
        return None
    _refuse_unknown(body, ("parallel", "states"), ("states", name), problems)
    whole = True
    for region, inside in regions.items():
        path = ("states", name, "states", region)
        states = inside.get("states") if isinstance(inside, dict) else None
        if not isinstance(states, dict) or not states:
            problems.add("chart.shape", path, "a region needs `states`", key=True)
            whole = False
        else:
            _refuse_unknown(inside, ("states",), path, problems)
    return (name, regions) if whole else None


def _outline(top: str, regions: Mapping[str, Any], problems: Problems) -> ChartOutline:
    states: list[tuple[str, ...]] = []
    initial: list[str] = []
    transitions: list[Transition] = []
    for region, inside in regions.items():
        at: Path = ("states", top, "states", region, "states")
        names = [state.removeprefix(f"{region}.") for state in inside["states"]]
        first = []
        for state, body in inside["states"].items():
            path = (*at, state)
            if not state.startswith(f"{region}.") or state.count(".") != 1:
                message = f"a state of {region} is named `{region}.<State>`"
                problems.add("chart.name", path, message, key=True)
            if body is not None and not isinstance(body, dict):
                message = "a state has `initial`, `transitions`, both, or nothing"
                problems.add("chart.state", path, message)
                continue
            _refuse_unknown(body or {}, _STATE_KEYS, path, problems)
            if not isinstance((body or {}).get("initial", False), bool):
                problems.add("chart.state", (*path, "initial"), "`initial` is true or false")
            if (body or {}).get("initial") is True:
                first.append(state.removeprefix(f"{region}."))
            transitions += _transitions(region, state, body or {}, path, problems)
        if len(first) != 1:
            message = f"{region} needs exactly one `initial: true`"
            problems.add("chart.initial", at[:-1], message, key=True)
        _check_words(region, names, at[:-1], problems)
        states.append(tuple(names))
        initial.append(first[0] if first else names[0])
    return ChartOutline(top, tuple(regions), tuple(states), tuple(initial), tuple(transitions))


def _check_words(region: str, states: Iterable[str], path: Path, problems: Problems) -> None:
    """Conditions must be able to name the region and its states."""
    if region in RESERVED:
        message = f"'{region}' means something else in conditions: choose another name"
        problems.add("chart.name", path, message, key=True)
        return
    try:
        Vocabulary({region: EnumType(tuple(states))})
    except ValueError as error:
        problems.add("chart.name", path, str(error), key=True)


def _transitions(
    region: str, state: str, body: Mapping[str, Any], at: Path, problems: Problems
) -> Iterator[Transition]:
    listed = body.get("transitions")
    if listed is None:
        return
    if not isinstance(listed, list):
        problems.add("chart.transition", (*at, "transitions"), "expected a list of transitions")
        return
    for number, item in enumerate(listed):
        path = (*at, "transitions", number)
        if not isinstance(item, dict) or not {"event", "target"} <= item.keys():
            problems.add("chart.transition", path, "a transition needs `event` and `target`")
            continue
        _refuse_unknown(item, _TRANSITION_KEYS, path, problems)
        wrong = [key for key in _TRANSITION_KEYS if key in item and not _is_text(item[key])]
        for key in wrong:
            several = key == "event" and isinstance(item[key], list)
            message = "several events in one transition are not supported here: write one for each"
            message = message if several else f"`{key}` must be text"
            problems.add("chart.transition", (*path, key), message)
        if wrong:
            continue
        if not _EVENT.fullmatch(item["event"]):
            message = "an event is named by letters, digits and underscores"
            problems.add("chart.name", (*path, "event"), message)
            continue
        guard = item.get("cond", "").strip()
        yield Transition(region, state, item["event"], item["target"], guard, path)


def _is_text(value: object) -> bool:
    return isinstance(value, str) and bool(value.strip())


def _refuse_unknown(
    mapping: Mapping[str, Any], known: tuple[str, ...], path: Path, problems: Problems
) -> None:
    for key in mapping:
        if key not in known and key in _NOT_SUPPORTED:
            message = f"'{key}' is known in statecharts and not supported here"
            problems.add("unknown-key", (*path, key), message, expected=one_of(known), key=True)
        elif key not in known:
            problems.add(
                "unknown-key", (*path, key), f"unknown key '{key}'", expected=one_of(known),
                suggestion=nearest(key, known) or "", key=True,
            )  # fmt: skip


def _check_target(transition: Transition, known: list[str], problems: Problems) -> None:
    path, target = (*transition.path, "target"), transition.target
    if target not in known:
        message = f"there is no state '{target}'"
        problems.add("chart.target", path, message, suggestion=nearest(target, known) or "")
    elif not target.startswith(f"{transition.region}."):
        message = f"a transition of {transition.region} must stay in {transition.region}"
        problems.add("chart.target", path, message)


def _check_guard(transition: Transition, known: list[str], problems: Problems) -> None:
    path = (*transition.path, "cond")
    try:
        guard = ast.parse(transition.guard, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        expected = "In('…') with and, or, not"
        problems.add("chart.guard", path, "this guard cannot be read", expected=expected)
        return
    for message, name in dict.fromkeys(_faults(guard, known)):
        problems.add("chart.guard", path, message, suggestion=name)


def _faults(node: ast.expr, known: list[str]) -> Iterator[tuple[str, str]]:
    """What is wrong with a guard, each with the state that was meant or nothing."""
    match node:
        case ast.BoolOp(values=parts):
            for part in parts:
                yield from _faults(part, known)
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            yield from _faults(operand, known)
        case ast.Call(func=ast.Name(id="In"), args=[ast.Constant(value=str(name))], keywords=[]):
            if name not in known:
                yield f"there is no state '{name}'", nearest(name, known) or ""
        case ast.Call(func=ast.Name(id="In"), args=[argument], keywords=[]):
            written = ast.unparse(argument)
            yield f"In({written}) is always true without quotes; write In('{written}')", ""
        case _:
            yield "a guard may only use In('Region.State'), and, or, not, and parentheses", ""
