"""What a chart file declares: regions, states, events and guards, each with its place.

Checked here, before the library runs the chart, because there it would pass in silence or fail
without a line: a misspelt key or target, an unquoted or dangling ``In``, a guard of other things.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from pirate_sm.expressions import EnumType, Vocabulary
from pirate_sm.loading.problems import Path, Problems
from pirate_sm.spelling import nearest, one_of

if TYPE_CHECKING:
    from pirate_sm.loading.source import Document

_EVENT = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")
RESERVED = ("detector", "segment")
"""Words that conditions know besides the regions."""

_TOP_KEYS = ("name", "description", "states")
_STATE_KEYS = ("initial", "transitions", "states")
_TRANSITION_KEYS = ("event", "target", "cond")
_NOT_SUPPORTED = frozenset(
    {"final", "history", "parallel", "enter", "exit", "on", "before", "after", "unless",
     "internal", "validators", "donedata", "invoke", "datamodel"}
)  # fmt: skip
"""Keys that a statechart may have, and that are not supported here."""


class Move(NamedTuple):
    """A transition as it is written: several events may lead the same way."""

    events: tuple[str, ...]
    target: str
    guard: str
    path: Path


@dataclass(frozen=True)
class Node:
    """A state as it is written; a compound one has others inside.

    Attributes:
        name: With that of its region.
    """

    name: str
    initial: bool
    path: Path
    moves: tuple[Move, ...] = ()
    inner: tuple[Node, ...] = ()

    @property
    def first(self) -> Node:
        """The state that is entered with this one: itself, unless others are inside."""
        return next((each.first for each in self.inner if each.initial), self)

    @property
    def leaves(self) -> tuple[Node, ...]:
        """The states inside that have no others inside; itself if it is one."""
        return tuple(leaf for each in self.inner for leaf in each.leaves) or (self,)

    def walk(self) -> Iterator[Node]:
        """This one and all that are inside, in the order of the file."""
        yield self
        for each in self.inner:
            yield from each.walk()

    def chains(self) -> Iterator[tuple[Node, ...]]:
        """Each leaf with the states around it, from the inside out."""
        if not self.inner:
            yield (self,)
        for each in self.inner:
            yield from ((*chain, self) for chain in each.chains())


@dataclass(frozen=True)
class Transition:
    """Where an event leads from a state without others inside.

    Attributes:
        source: The state, named as in the file.
        target: The state that is entered in the end, likewise.
        guard: As it is written.
        owner: The state that has the transition in the file: the source, or one around it.
        tree: The guard for looking at, compound states in it written out; None without one.
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
    """What a chart file declares.

    Attributes:
        top: Name of the parallel state that holds the regions.
        states: Of each region those that have no others inside.
        initial: Of each region the one of them that it begins in.
        transitions: Each for each state in which it counts, what is written inside first.
        commands: Every event name, in the order of the file.
        nodes: Of each region the states as they are written.
    """

    top: str
    regions: tuple[str, ...]
    states: tuple[tuple[str, ...], ...]
    initial: tuple[str, ...]
    transitions: tuple[Transition, ...]
    commands: tuple[str, ...]
    nodes: tuple[tuple[Node, ...], ...]

    def place_of(self, region: str, state: str) -> Path:
        """Where a state stands in the file."""
        inside = self.nodes[self.regions.index(region)]
        every = (node for each in inside for node in each.walk())
        return next(node.path for node in every if node.name == f"{region}.{state}")


def outline_chart(document: Document, problems: Problems) -> ChartOutline | None:
    """The chart's declarations are known and consistent, or the problems say what is wrong."""
    about = problems.about(document)
    before = len(problems.errors)
    found = _regions(document.data, about)
    if found is None:
        return None
    outline = _outline(*found, about)
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
        top, tuple(regions),
        tuple(tuple(_short(leaf) for each in found for leaf in each.leaves) for found in nodes),
        tuple(_short(next((e for e in found if e.initial), found[0]).first) for found in nodes),
        tuple(each for found in nodes for each in _flat(found, every)),
        tuple(dict.fromkeys(e for n in every.values() for move in n.moves for e in move.events)),
        tuple(nodes),
    )  # fmt: skip


def _short(node: Node) -> str:
    return node.name.partition(".")[2]


def _flat(found: Iterable[Node], every: Mapping[str, Node]) -> Iterator[Transition]:
    """The transitions of each leaf, those of the states around it after its own."""
    for node in found:
        for chain in node.chains():
            leaf = chain[0].name
            for owner in chain:
                for move in owner.moves:
                    tree = _written_out(move.guard, every)
                    target = every[move.target].first.name if move.target in every else move.target
                    for event in move.events:
                        yield Transition(
                            leaf.partition(".")[0], leaf, event, target, move.guard, move.path,
                            owner.name, tree,
                        )  # fmt: skip


ANY_OF = "|"
"""Between the names of states in a guard that is written out: ``In('Region.one|two')``."""


def _written_out(guard: str, every: Mapping[str, Node]) -> ast.expr | None:
    """The guard with the states inside of a compound one in its place; None without a guard."""
    try:
        tree = ast.parse(guard, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None  # none, or one of which that is said
    for node in ast.walk(tree):
        named = every.get(str(node.value)) if isinstance(node, ast.Constant) else None
        if named is not None and named.inner and isinstance(node, ast.Constant):
            region = named.name.partition(".")[0]
            node.value = f"{region}.{ANY_OF.join(map(_short, named.leaves))}"
    return tree


def _states(
    region: str, around: str, states: Mapping[str, Any], at: Path, problems: Problems
) -> tuple[Node, ...]:
    """The states of a region, or of a compound state in it.

    Args:
        region: The region.
        around: Name of what they stand in.
        states: As the file has them.
        at: Where what they stand in does.
        problems: Are added to.
    """
    found = tuple(
        _state(region, name, body, (*at, "states", name), problems) for name, body in states.items()
    )
    if sum(each.initial for each in found) != 1:
        problems.add("chart.initial", at, f"{around} needs exactly one `initial: true`", key=True)
    return found


def _state(region: str, name: str, body: Any, path: Path, problems: Problems) -> Node:
    if not name.startswith(f"{region}.") or name.count(".") != 1:
        message = f"a state of {region} is named `{region}.<State>`"
        problems.add("chart.name", path, message, key=True)
    if body is not None and not isinstance(body, dict):
        message = "a state has `initial`, `transitions`, `states`, or nothing"
        problems.add("chart.state", path, message)
        return Node(name, initial=False, path=path)
    body = body or {}
    _refuse_unknown(body, _STATE_KEYS, path, problems)
    if not isinstance(body.get("initial", False), bool):
        problems.add("chart.state", (*path, "initial"), "`initial` is true or false")
    inside = body.get("states")
    inner: tuple[Node, ...] = ()
    if isinstance(inside, dict) and inside:
        inner = _states(region, name, inside, path, problems)
    elif "states" in body:
        message = "a state with `states` has at least one state in it"
        problems.add("chart.state", (*path, "states"), message)
    moves = tuple(_moves(body, path, problems))
    return Node(name, body.get("initial") is True, path, moves, inner)


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


def _moves(body: Mapping[str, Any], at: Path, problems: Problems) -> Iterator[Move]:
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
            yield Move(events, item["target"], item.get("cond", "").strip(), path)


def _events(given: Any, path: Path, problems: Problems) -> Iterator[str]:
    """The events of a transition: one name, several with blanks between them, or a list."""
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
            problems.add(
                "unknown-key", (*path, key), f"unknown key '{key}'", expected=one_of(known),
                suggestion=nearest(key, known) or "", key=True,
            )  # fmt: skip


def _check_move(node: Node, move: Move, every: Mapping[str, Node], problems: Problems) -> None:
    region, known = str(node.path[3]), list(every)
    path, target = (*move.path, "target"), move.target
    if target not in every:
        message = f"there is no state '{target}'"
        problems.add("chart.target", path, message, suggestion=nearest(target, known) or "")
    elif not target.startswith(f"{region}."):
        problems.add("chart.target", path, f"a transition of {region} must stay in {region}")
    if move.guard:
        _check_guard(move, known, problems)


def _check_guard(move: Move, known: list[str], problems: Problems) -> None:
    path = (*move.path, "cond")
    try:
        guard = ast.parse(move.guard, mode="eval").body
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
