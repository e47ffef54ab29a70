"""Read a chart file: its regions, states, events and guards, with their places, and their faults.

The checks precede the library, which would ignore such faults or fail without a line number: a
misspelt key or target, an unquoted or unknown state in ``In``, an unsupported guard.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from pirate_sm.core._engine.state import OUTSIDE
from pirate_sm.core._expressions import EnumType, Vocabulary
from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core.spelling import nearest, one_of

if TYPE_CHECKING:
    from pirate_sm.core._loading.yaml.document import Document


class WrittenTransition(NamedTuple):
    """A transition as written in the file, with one or several events."""

    events: tuple[str, ...]
    target: str
    guard: str
    path: Path


@dataclass(frozen=True)
class StateNode:
    """A state as written in the file; a compound state contains others.

    Attributes:
        name: Its name, prefixed by that of its region.
    """

    name: str
    initial: bool
    path: Path
    moves: tuple[WrittenTransition, ...] = ()
    inner: tuple[StateNode, ...] = ()

    @property
    def short_name(self) -> str:
        """Return the name without the region."""
        return self.name.partition(".")[2]

    @property
    def first(self) -> StateNode:
        """Return the leaf that is entered with this state; itself if it is a leaf."""
        return next((each.first for each in self.inner if each.initial), self)

    @property
    def leaves(self) -> tuple[StateNode, ...]:
        """Return the leaves inside this state; itself if it is a leaf."""
        return tuple(leaf for each in self.inner for leaf in each.leaves) or (self,)

    def walk(self) -> Iterator[StateNode]:
        """Yield this state and all states inside it, in the order of the file."""
        yield self
        for each in self.inner:
            yield from each.walk()

    def chains(self) -> Iterator[tuple[StateNode, ...]]:
        """Yield each leaf with its enclosing states, innermost first."""
        if not self.inner:
            yield (self,)
        for each in self.inner:
            yield from ((*chain, self) for chain in each.chains())


@dataclass(frozen=True)
class ChartTransition:
    """A transition of one leaf state on one event.

    Attributes:
        source: The leaf, named as in the file.
        target: The leaf that is entered, named as in the file.
        guard: The guard as written.
        owner: The state that declares the transition: the source or a state that encloses it.
        tree: The parsed guard with compound states expanded; None without one.
    """

    region: str
    source: str
    event: str
    target: str
    guard: str
    path: Path
    owner: str
    tree: ast.expr | None = field(compare=False)


@dataclass(frozen=True)
class ChartOutline:
    """The declarations of a chart file.

    Attributes:
        top: Name of the parallel state that holds the regions.
        states: The leaf states of each region.
        initial: The initial leaf of each region.
        transitions: The transitions of every leaf, those of inner states first.
        commands: All event names, in the order of the file.
        nodes: The states of each region as written.
    """

    top: str
    regions: tuple[str, ...]
    states: tuple[tuple[str, ...], ...]
    initial: tuple[str, ...]
    transitions: tuple[ChartTransition, ...]
    commands: tuple[str, ...]
    nodes: tuple[tuple[StateNode, ...], ...]

    def place_of(self, region: str, state: str) -> Path:
        """Return the path of a state in the file."""
        inside = self.nodes[self.regions.index(region)]
        every = (node for each in inside for node in each.walk())
        return next(node.path for node in every if node.name == f"{region}.{state}")


States = Mapping[str, str]
"""The state of each region."""

_ANY_OF = "|"
"""Separator of states in an expanded guard: ``In('Region.one|two')``."""


def _guard_on_leaves(guard: str, every: Mapping[str, StateNode]) -> ast.expr | None:
    """Return the guard with compound states replaced by their leaves; None without a guard."""
    tree = _read_guard(guard)
    for node in ast.walk(tree) if tree is not None else ():
        named = every.get(str(node.value)) if isinstance(node, ast.Constant) else None
        if named is not None and named.inner and isinstance(node, ast.Constant):
            region = named.name.partition(".")[0]
            node.value = f"{region}.{_ANY_OF.join(leaf.short_name for leaf in named.leaves)}"
    return tree


def _read_guard(guard: str) -> ast.expr | None:
    """Return a guard as a tree; None if there is none, or a faulty one."""
    try:
        return ast.parse(guard, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


def _check_guard(move: WrittenTransition, known: list[str], problems: Problems) -> None:
    """Report the faults of a transition's guard."""
    path = (*move.path, "cond")
    guard = _read_guard(move.guard)
    if guard is None:
        expected = "In('…') with and, or, not"
        problems.add("chart.guard", path, "this guard cannot be read", expected=expected)
        return
    for message, name in dict.fromkeys(_guard_faults(guard, known)):
        problems.add("chart.guard", path, message, suggestion=name)


def _guard_faults(node: ast.expr, known: list[str]) -> Iterator[tuple[str, str]]:
    """Yield each fault of a guard, with the state that was probably meant, or an empty text."""
    match node:
        case ast.BoolOp(values=parts):
            for part in parts:
                yield from _guard_faults(part, known)
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            yield from _guard_faults(operand, known)
        case ast.Call(func=ast.Name(id="In"), args=[ast.Constant(value=str(name))], keywords=[]):
            if name not in known:
                yield f"there is no state '{name}'", nearest(name, known) or ""
        case ast.Call(func=ast.Name(id="In"), args=[argument], keywords=[]):
            written = ast.unparse(argument)
            yield f"In({written}) is always true without quotes; write In('{written}')", ""
        case _:
            yield "a guard may only use In('Region.State'), and, or, not, and parentheses", ""


def holds(node: ast.expr, states: States) -> bool:
    """Return whether a part of a guard is true in these states."""
    match node:
        case ast.BoolOp(op=ast.And(), values=parts):
            return all(holds(part, states) for part in parts)
        case ast.BoolOp(values=parts):
            return any(holds(part, states) for part in parts)
        case ast.UnaryOp(operand=operand):
            return not holds(operand, states)
        case _:
            region, asked = asked_by(node)
            return states.get(region) in asked


def conjuncts(node: ast.expr) -> list[ast.expr]:
    """Return the parts that must all be true."""
    if isinstance(node, ast.BoolOp) and isinstance(node.op, ast.And):
        return node.values
    return [node]


def asked_by(node: ast.expr) -> tuple[str, list[str]]:
    """Return region and states of an `In('…')`; several for a compound state."""
    if isinstance(node, ast.Call) and isinstance(node.args[0], ast.Constant):
        region, _, states = str(node.args[0].value).partition(".")
        return region, states.split(_ANY_OF)
    raise AssertionError(f"the loader has let {ast.dump(node)} pass")


_EVENT = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")
RESERVED = OUTSIDE
"""Names that conditions know besides the regions."""

_TOP_KEYS = ("name", "description", "states")
_STATE_KEYS = ("initial", "transitions", "states")
_TRANSITION_KEYS = ("event", "target", "cond")
_NOT_SUPPORTED = frozenset(
    {"final", "history", "parallel", "enter", "exit", "on", "before", "after", "unless",
     "internal", "validators", "donedata", "invoke", "datamodel"}
)  # fmt: skip
"""Keys of statecharts that are not supported here."""


def outline_chart(document: Document, problems: Problems) -> ChartOutline | None:
    """Return the declarations of a chart, or None after reporting their faults."""
    about = problems.about(document)
    before = len(problems.errors)
    found = _regions(document.data, about)
    if found is None:
        return None
    outline = _outline(*found, about)
    return outline if len(problems.errors) == before else None


def _regions(data: Any, problems: Problems) -> tuple[str, Mapping[str, Any]] | None:
    """Return the name of the parallel state, and its regions."""
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
        wrong = isinstance(body, dict) and body.get("parallel", True) is not True
        problems.add(
            "chart.shape",
            ("states", name, "parallel") if wrong else ("states", name),
            "the chart's one state needs `parallel: true` and `states`, one per state machine",
            key=True,
        )
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
    nodes = []
    for region, inside in regions.items():
        at: Path = ("states", top, "states", region)
        found = _states(region, region, inside["states"], at, problems)
        names = [node.name.removeprefix(f"{region}.") for each in found for node in each.walk()]
        for name in sorted({each for each in names if names.count(each) > 1}):
            message = f"a state of {region} stands twice: '{region}.{name}'"
            problems.add("chart.name", at, message, key=True)
        _check_words(region, names, at, problems)
        nodes.append(found)
    every = {node.name: node for found in nodes for each in found for node in each.walk()}
    for node in every.values():
        for move in node.moves:
            _check_move(node, move, every, problems)
    return ChartOutline(
        top,
        tuple(regions),
        tuple(tuple(leaf.short_name for each in found for leaf in each.leaves) for found in nodes),
        tuple(next((e for e in found if e.initial), found[0]).first.short_name for found in nodes),
        tuple(each for found in nodes for each in _flat(found, every)),
        tuple(dict.fromkeys(e for n in every.values() for move in n.moves for e in move.events)),
        tuple(nodes),
    )


def _flat(found: Iterable[StateNode], every: Mapping[str, StateNode]) -> Iterator[ChartTransition]:
    """Yield the transitions of each leaf, its own before those of its enclosing states."""
    for node in found:
        for chain in node.chains():
            leaf = chain[0].name
            for owner in chain:
                for move in owner.moves:
                    tree = _guard_on_leaves(move.guard, every)
                    target = every[move.target].first.name if move.target in every else move.target
                    for event in move.events:
                        yield ChartTransition(
                            leaf.partition(".")[0],
                            leaf,
                            event,
                            target,
                            move.guard,
                            move.path,
                            owner.name,
                            tree,
                        )


def _states(
    region: str, around: str, states: Mapping[str, Any], at: Path, problems: Problems
) -> tuple[StateNode, ...]:
    """Return the states of a region, or of a compound state in it.

    Args:
        region: The region.
        around: Name of the region or compound state.
        states: The states as in the file.
        at: Path of the region or compound state.
        problems: Collects the faults.
    """
    found = tuple(
        _state(region, name, body, (*at, "states", name), problems) for name, body in states.items()
    )
    if sum(each.initial for each in found) != 1:
        problems.add("chart.initial", at, f"{around} needs exactly one `initial: true`", key=True)
    return found


def _state(region: str, name: str, body: Any, path: Path, problems: Problems) -> StateNode:
    if not name.startswith(f"{region}.") or name.count(".") != 1:
        message = f"a state of {region} is named `{region}.<State>`"
        problems.add("chart.name", path, message, key=True)
    if body is not None and not isinstance(body, dict):
        message = "a state has `initial`, `transitions`, `states`, or nothing"
        problems.add("chart.state", path, message)
        return StateNode(name, initial=False, path=path)
    body = body or {}
    _refuse_unknown(body, _STATE_KEYS, path, problems)
    if not isinstance(body.get("initial", False), bool):
        problems.add("chart.state", (*path, "initial"), "`initial` is true or false")
    inside = body.get("states")
    inner: tuple[StateNode, ...] = ()
    if isinstance(inside, dict) and inside:
        inner = _states(region, name, inside, path, problems)
    elif "states" in body:
        message = "a state with `states` has at least one state in it"
        problems.add("chart.state", (*path, "states"), message)
    moves = tuple(_moves(body, path, problems))
    return StateNode(name, body.get("initial") is True, path, moves, inner)


def _check_words(region: str, states: Iterable[str], path: Path, problems: Problems) -> None:
    """Report a region or state that conditions cannot name."""
    if region in RESERVED:
        message = f"'{region}' means something else in conditions: choose another name"
        problems.add("chart.name", path, message, key=True)
        return
    try:
        Vocabulary({region: EnumType(tuple(states))})
    except ValueError as error:
        problems.add("chart.name", path, str(error), key=True)


def _moves(body: Mapping[str, Any], at: Path, problems: Problems) -> Iterator[WrittenTransition]:
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
        wrong = [k for k in ("target", "cond") if k in item and not _is_text(item[k])]
        for key in wrong:
            problems.add("chart.transition", (*path, key), f"`{key}` must be text")
        events = tuple(_events(item["event"], (*path, "event"), problems))
        if events and not wrong:
            yield WrittenTransition(events, item["target"], item.get("cond", "").strip(), path)


def _events(given: Any, path: Path, problems: Problems) -> Iterator[str]:
    """Yield the events of a transition: one name, several separated by blanks, or a list."""
    if isinstance(given, list) and given:
        named = [(each, (*path, number)) for number, each in enumerate(given)]
    elif _is_text(given):
        named = [(each, path) for each in given.split()]
    else:
        problems.add("chart.transition", path, "`event` must be text, or a list of names")
        return
    for name, at in named:
        if isinstance(name, str) and _EVENT.fullmatch(name):
            yield name
        else:
            message = "an event is named by letters, digits and underscores"
            problems.add("chart.name", at, message)


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
            problems.add_unknown(
                "unknown-key",
                (*path, key),
                "",
                key,
                known,
                message=f"unknown key '{key}'",
                key=True,
            )


def _check_move(
    node: StateNode, move: WrittenTransition, every: Mapping[str, StateNode], problems: Problems
) -> None:
    region, known = str(node.path[3]), list(every)
    path, target = (*move.path, "target"), move.target
    if target not in every:
        message = f"there is no state '{target}'"
        problems.add("chart.target", path, message, suggestion=nearest(target, known) or "")
    elif not target.startswith(f"{region}."):
        problems.add("chart.target", path, f"a transition of {region} must stay in {region}")
    if move.guard:
        _check_guard(move, known, problems)
