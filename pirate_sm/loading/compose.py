"""YAML events → a tree of plain values with places: the rules of our YAML, kept in one pass."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final, TypeAlias, cast

import yaml

from pirate_sm.loading.scalars import CORE_PREFIX, ScalarError, resolve_plain, resolve_tagged

DEEPEST_NESTING: Final = 32
MOST_ALIASES: Final = 100
MOST_FAULTS: Final = 200
MOST_NODES: Final = 100_000  # with every alias counted as what it stands for

# libyaml is about ten times as fast; a build of PyYAML without it says the same more slowly.
_Loader: Final = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

Children: TypeAlias = "dict[str, tuple[Node, int, int]] | list[Node] | None"


@dataclass(slots=True)
class Node:
    """Is a value with its place; lines and columns count from 1, start and end from 0.

    Attributes:
        value: The plain data.
        children: For a mapping each value with line and column of its key, for a list the items.
        size: Nodes in this tree, with aliases counted as what they stand for.
        height: Levels of this tree.
    """

    line: int
    column: int
    start: int
    end: int
    value: Any = None
    children: Children = None
    size: int = 1
    height: int = 1

    def child(self, part: str | int) -> tuple[Node, int, int] | None:
        """Return the value under a key or index with the place of its key, if there is one."""
        if isinstance(self.children, dict) and isinstance(part, str):
            return self.children.get(part)
        if not isinstance(self.children, list) or not isinstance(part, int):
            return None
        if not 0 <= part < len(self.children):
            return None
        item = self.children[part]
        return item, item.line, item.column


@dataclass(frozen=True, slots=True)
class Fault:
    """Is something wrong at a line and column; the caller knows the file."""

    code: str
    line: int
    column: int
    message: str
    expected: str = ""
    suggestion: str = ""


class _FatalError(Exception):
    """Ends the reading: what follows makes no sense or costs too much."""

    def __init__(self, fault: Fault) -> None:
        self.fault = fault


@dataclass(slots=True)
class _Open:
    """Is a mapping or list that is still being read."""

    node: Node
    anchor: str | None
    # The key that waits for its value; None in a list and where a key comes next.
    key: Node | None = None


def compose(text: str) -> tuple[Node | None, tuple[Fault, ...]]:
    """Return the tree of a YAML text, None when it is empty, and everything wrong with it."""
    composer = _Composer()
    try:
        for event in _events(text):
            composer.take(event)
    except _FatalError as stop:
        composer.faults.append(stop.fault)
    except yaml.MarkedYAMLError as error:
        composer.faults.append(_syntax_fault(error, composer.innermost))
    except (yaml.YAMLError, UnicodeError) as error:
        composer.faults.append(Fault("syntax", 1, 1, f"is not YAML: {error}"))
    return composer.root, tuple(composer.faults)


def _events(text: str) -> Iterator[yaml.Event]:
    return iter(yaml.parse(text, Loader=_Loader))


class _Composer:
    """Builds the tree with a stack of its own, so that no nesting can exhaust Python's."""

    def __init__(self) -> None:
        self.root: Node | None = None
        self.faults: list[Fault] = []
        self._stack: list[_Open] = []
        self._anchors: dict[str, Node | None] = {}  # None while the node is still being read
        self._aliases = 0
        self._documents = 0

    @property
    def innermost(self) -> Node | None:
        """Return the mapping or list that was being read last, if one still is."""
        return self._stack[-1].node if self._stack else None

    def take(self, event: yaml.Event) -> None:
        """Add one event to the tree."""
        if len(self.faults) >= MOST_FAULTS:
            raise _FatalError(_fault("more", event, "too many faults to read on"))
        if isinstance(event, yaml.ScalarEvent):
            self._add(self._scalar(event), event.anchor)
        elif isinstance(event, yaml.MappingStartEvent):
            self._start(event, {}, {}, "map")
        elif isinstance(event, yaml.SequenceStartEvent):
            self._start(event, [], [], "seq")
        elif isinstance(event, yaml.CollectionEndEvent):
            opened = self._stack.pop()
            opened.node.end = _marks(event)[1].index
            self._add(opened.node, opened.anchor)
        elif isinstance(event, yaml.AliasEvent):
            self._add(self._alias(event), None)
        elif isinstance(event, yaml.DocumentStartEvent):
            self._documents += 1
            if self._documents > 1:
                raise _FatalError(
                    _fault("documents", event, "a second document ('---') in one file")
                )

    def _scalar(self, event: yaml.ScalarEvent) -> Node:
        node = _node(event)
        try:
            if event.tag is not None and event.tag != "!":
                node.value = resolve_tagged(event.tag, event.value)
            elif event.tag is None and event.implicit[0]:
                node.value = resolve_plain(event.value)
            else:
                node.value = event.value
        except ScalarError as error:
            self.faults.append(_fault(error.code, event, str(error)))
        return node

    def _start(
        self, event: yaml.CollectionStartEvent, value: Any, children: Any, kind: str
    ) -> None:
        if len(self._stack) >= DEEPEST_NESTING:
            raise _FatalError(_too_deep(event))
        if event.tag not in (None, "!", CORE_PREFIX + kind):
            shown = event.tag.replace(CORE_PREFIX, "!!")
            self.faults.append(_fault("tag", event, f"the tag '{shown}' is not allowed here"))
        node = _node(event)
        node.value, node.children = value, children
        if event.anchor is not None:
            self._anchors[event.anchor] = None
        self._stack.append(_Open(node, event.anchor))

    def _alias(self, event: yaml.AliasEvent) -> Node:
        self._aliases += 1
        if self._aliases > MOST_ALIASES:
            raise _FatalError(
                _fault("aliases", event, f"more than {MOST_ALIASES} aliases ('*name')")
            )
        anchor = event.anchor or ""
        target = self._anchors.get(anchor)
        node = _node(event)
        if target is None:
            inside = anchor in self._anchors
            message = "stands for what it is part of" if inside else "has no anchor before it"
            self.faults.append(_fault("alias", event, f"the alias '*{anchor}' {message}"))
            return node
        if len(self._stack) + target.height > DEEPEST_NESTING:
            raise _FatalError(_too_deep(event))
        node.value, node.children = target.value, target.children
        node.size, node.height = target.size, target.height
        return node

    def _add(self, node: Node, anchor: str | None) -> None:
        """Put a finished node where it belongs."""
        if anchor is not None:
            self._anchors[anchor] = node
        if not self._stack:
            self.root = node
            return
        opened = self._stack[-1]
        parent = opened.node
        parent.size += node.size
        parent.height = max(parent.height, node.height + 1)
        if parent.size > MOST_NODES:
            message = f"more than {MOST_NODES} values, each alias counted as what it stands for"
            raise _FatalError(Fault("too-large", node.line, node.column, message))
        if isinstance(parent.children, list):
            parent.children.append(node)
            parent.value.append(node.value)
        elif opened.key is None:
            opened.key = node
        else:
            self._add_entry(parent, opened.key, node)
            opened.key = None

    def _add_entry(self, parent: Node, key: Node, node: Node) -> None:
        assert isinstance(parent.children, dict)
        name = key.value
        if not isinstance(name, str):
            self.faults.append(_key_fault(key))
            return
        if name == "<<":
            message = "merge keys ('<<') are not supported: write the entries out"
            self.faults.append(Fault("merge-key", key.line, key.column, message))
            return
        if name in parent.children:
            _, line, column = parent.children[name]
            message = f"the key '{name}' stands twice; first in line {line}, column {column}"
            self.faults.append(Fault("duplicate-key", key.line, key.column, message))
            return
        parent.children[name] = (node, key.line, key.column)
        parent.value[name] = node.value


def _key_fault(key: Node) -> Fault:
    if isinstance(key.value, dict | list):
        message = "a mapping or list cannot be a key"
        expected = "text as the key; text in braces or brackets needs quotes"
    else:
        shown = json.dumps(key.value)
        message = f"the key '{shown}' is not text"
        expected = f"text as the key; in quotes ('{shown}') it is text"
    return Fault("key", key.line, key.column, message, expected)


def _node(event: yaml.Event) -> Node:
    start, end = _marks(event)
    return Node(start.line + 1, start.column + 1, start.index, end.index)


def _fault(code: str, event: yaml.Event, message: str) -> Fault:
    start, _ = _marks(event)
    return Fault(code, start.line + 1, start.column + 1, message)


def _marks(event: yaml.Event) -> tuple[yaml.Mark, yaml.Mark]:
    """Return where an event begins and ends: events of a parser always know."""
    start, end = event.start_mark, event.end_mark
    assert start is not None
    assert end is not None
    return cast("yaml.Mark", start), cast("yaml.Mark", end)


def _too_deep(event: yaml.Event) -> Fault:
    return _fault("too-deep", event, f"nested deeper than {DEEPEST_NESTING} levels")


# What the parser says, in part, and what a person can do about it.
_ADVICE: Final = (
    ("mapping values are not allowed", "a ':' cannot stand here",
     "the same indentation as the line before, or text with ': ' in quotes"),
    ("entries are not allowed", "a '- ' cannot stand here", "list items on lines of their own"),
    ("tab character", "a tab cannot indent a line", "blanks"),
    ("unknown escape", "an unknown escape in double quotes", "single quotes, or '\\\\' for '\\'"),
    ("flow node", "a value, or a closing bracket, is missing", ""),
    ("node content", "no value can begin here", ""),
    ("flow sequence", "a '[' is not closed, or a ',' is missing", "',' or ']'"),
    ("flow mapping", "a '{' is not closed, or a ',' is missing", "',' or '}'"),
    ("end of stream", "a quote is not closed", "the closing quote"),
    ("expected ':'", "a ':' is missing after a key", "'key: value'"),
    ("block mapping", "this does not continue the mapping",
     "'key: value' in line with the keys above, and nothing after a closing quote"),
    ("block collection", "this does not continue the list", "'- ' in line with the items above"),
)  # fmt: skip


def _syntax_fault(error: yaml.MarkedYAMLError, innermost: Node | None) -> Fault:
    """Return a syntax error in words that help someone who does not know YAML's grammar."""
    said = f"{error.context or ''} {error.problem or ''}"
    mark, opening = error.problem_mark or error.context_mark, error.context_mark
    if "end of stream" in said and opening is not None:
        mark = opening
    line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
    if "flow" in said and innermost is not None and line > innermost.line:
        # What is not closed is noticed lines later, where nothing is wrong.
        line, column = innermost.line, innermost.column
    if "cannot start any token" in said:
        return _bad_character(error, line, column)
    for needle, message, expected in _ADVICE:
        if needle in said:
            return Fault("syntax", line, column, message, expected)
    return Fault("syntax", line, column, f"is not YAML: {error.problem or error.context}")


def _bad_character(error: yaml.MarkedYAMLError, line: int, column: int) -> Fault:
    """Return the fault of a character that begins nothing: mostly a tab, '%', '@' or '`'."""
    # Only PyYAML's own parser names it; for both, a tab is what people trip over at a line start.
    if "'\\t'" in (error.problem or "") or column == 1:
        return Fault("syntax", line, column, "a tab cannot indent a line", "blanks")
    message = "a value cannot begin with this character"
    return Fault("syntax", line, column, message, "the text in quotes")
