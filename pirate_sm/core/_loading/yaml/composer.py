"""Build a tree of plain values with places from YAML events, by our stricter rules."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final, cast

import yaml

from pirate_sm.core._loading.yaml.nodes import YamlFault, YamlNode
from pirate_sm.core._loading.yaml.scalars import (
    CORE_PREFIX,
    ScalarError,
    resolve_plain,
    resolve_tagged,
)
from pirate_sm.core._loading.yaml.syntax_faults import key_fault, syntax_fault

DEEPEST_NESTING: Final = 32
MOST_ALIASES: Final = 100
MOST_FAULTS: Final = 200
MOST_NODES: Final = 100_000  # with every alias counted as its target

# libyaml is about ten times as fast. PyYAML without it gives the same tree, but refuses a `?` in
# text without quotes between brackets, and places some faults of syntax a character later.
_Loader: Final = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _FatalError(Exception):
    """Raised to stop reading: the rest is meaningless or too expensive to read."""

    def __init__(self, fault: YamlFault) -> None:
        self.fault = fault


@dataclass(slots=True)
class _Open:
    """A mapping or list that is still being read."""

    node: YamlNode
    anchor: str | None
    # The key of the next value; None in a list, and where a key comes next.
    key: YamlNode | None = None


def compose(text: str) -> tuple[YamlNode | None, tuple[YamlFault, ...]]:
    """Return the tree of a YAML text, None if it is empty, and all faults found."""
    composer = _Composer()
    try:
        for event in _events(text):
            composer.take(event)
    except _FatalError as stop:
        composer.faults.append(stop.fault)
    except yaml.MarkedYAMLError as error:
        composer.faults.append(
            _earlier_fault(text, error) or syntax_fault(error, composer.innermost)
        )
    except (yaml.YAMLError, UnicodeError) as error:
        composer.faults.append(YamlFault("syntax", 1, 1, f"is not YAML: {error}"))
    return composer.root, tuple(composer.faults)


def _earlier_fault(text: str, error: yaml.MarkedYAMLError) -> YamlFault | None:
    """Return the fault that ends reading before the place of a syntax error, if there is one.

    libyaml looks up to a thousand characters ahead and has limits of its own, so it can refuse a
    text before it returns the events that break ours.
    """
    composer = _Composer()
    try:
        for event in _events(text[: error.problem_mark.index] if error.problem_mark else ""):
            composer.take(event)
    except _FatalError as stop:
        return stop.fault
    except yaml.YAMLError:
        return None
    return None


def _events(text: str) -> Iterator[yaml.Event]:
    return iter(yaml.parse(text, Loader=_Loader))


class _Composer:
    """Builds the tree with its own stack, so that deep nesting cannot exhaust Python's."""

    def __init__(self) -> None:
        self.root: YamlNode | None = None
        self.faults: list[YamlFault] = []
        self._stack: list[_Open] = []
        self._anchors: dict[str, YamlNode | None] = {}  # None while the node is still being read
        self._aliases = 0
        self._documents = 0

    @property
    def innermost(self) -> YamlNode | None:
        """Return the innermost mapping or list that is still open, None if there is none."""
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

    def _scalar(self, event: yaml.ScalarEvent) -> YamlNode:
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

    def _alias(self, event: yaml.AliasEvent) -> YamlNode:
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

    def _add(self, node: YamlNode, anchor: str | None) -> None:
        """Add a finished node to the tree."""
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
            raise _FatalError(YamlFault("too-large", node.line, node.column, message))
        if isinstance(parent.children, list):
            parent.children.append(node)
            parent.value.append(node.value)
        elif opened.key is None:
            opened.key = node
        else:
            self._add_entry(parent, opened.key, node)
            opened.key = None

    def _add_entry(self, parent: YamlNode, key: YamlNode, node: YamlNode) -> None:
        assert isinstance(parent.children, dict)
        name = key.value
        if not isinstance(name, str):
            self.faults.append(key_fault(key))
            return
        if name == "<<":
            message = "merge keys ('<<') are not supported: write the entries out"
            self.faults.append(YamlFault("merge-key", key.line, key.column, message))
            return
        if name in parent.children:
            _, line, column = parent.children[name]
            message = f"the key '{name}' appears twice; first in line {line}, column {column}"
            self.faults.append(YamlFault("duplicate-key", key.line, key.column, message))
            return
        parent.children[name] = (node, key.line, key.column)
        parent.value[name] = node.value


def _node(event: yaml.Event) -> YamlNode:
    start, end = _marks(event)
    return YamlNode(start.line + 1, start.column + 1, start.index, end.index)


def _fault(code: str, event: yaml.Event, message: str) -> YamlFault:
    start, _ = _marks(event)
    return YamlFault(code, start.line + 1, start.column + 1, message)


def _marks(event: yaml.Event) -> tuple[yaml.Mark, yaml.Mark]:
    """Return where an event begins and ends; events of a parser always have both marks."""
    start, end = event.start_mark, event.end_mark
    assert start is not None
    assert end is not None
    return cast("yaml.Mark", start), cast("yaml.Mark", end)


def _too_deep(event: yaml.Event) -> YamlFault:
    return _fault("too-deep", event, f"nested deeper than {DEEPEST_NESTING} levels")
