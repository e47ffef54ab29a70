"""Build a tree of plain values with places from YAML events, by our stricter rules.

PyYAML follows YAML 1.1, in which `on` and `Off` are booleans, `12:30` and `1_000` numbers. Here
they are text: unquoted scalars are resolved by the YAML 1.2 core schema (section 10.3.2), with
finite numbers.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Final, TypeAlias, cast

import yaml

_Children: TypeAlias = "dict[str, tuple[YamlNode, int, int]] | list[YamlNode] | None"


@dataclass(slots=True)
class YamlNode:
    """A value with its place; lines and columns count from 1, start and end from 0.

    Attributes:
        value: The plain data.
        children: For a mapping each value with line and column of its key, for a list the items.
        file: Name of the file that it is from; empty for the document's own file.
        size: Number of nodes in this tree, with aliases counted as their targets.
        height: Number of levels of this tree.
    """

    line: int
    column: int
    start: int
    end: int
    value: Any = None
    children: _Children = None
    size: int = 1
    height: int = 1
    file: str = ""

    def child(self, part: str | int) -> tuple[YamlNode, int, int] | None:
        """Return the value at a key or index, with the place of its key; None if missing."""
        if isinstance(self.children, dict) and isinstance(part, str):
            return self.children.get(part)
        if not isinstance(self.children, list) or not isinstance(part, int):
            return None
        if not 0 <= part < len(self.children):
            return None
        item = self.children[part]
        return item, item.line, item.column


@dataclass(frozen=True, slots=True)
class YamlFault:
    """A fault at a line and column; the caller knows the file."""

    code: str
    line: int
    column: int
    message: str
    expected: str = ""
    suggestion: str = ""


def from_file(node: YamlNode, name: str) -> YamlNode:
    """Return a copy of a tree whose nodes know the file that they are from."""
    children: _Children = node.children
    if isinstance(children, dict):
        children = {
            key: (from_file(it, name), line, column) for key, (it, line, column) in children.items()
        }
    elif isinstance(children, list):
        children = [from_file(each, name) for each in children]
    return replace(node, children=children, file=node.file or name)


def overlaid(base: YamlNode, over: YamlNode, *, without: str = "") -> YamlNode:
    """Return the tree of two mappings that are merged, else ``over``.

    Args:
        base: The tree below; its nodes keep their places.
        over: The tree above; a merged mapping has the place that it has there.
        without: A key of ``over`` that is left out.
    """
    if not isinstance(base.children, dict) or not isinstance(over.children, dict):
        return over
    children, value = dict(base.children), dict(base.value)
    for key, (node, line, column) in over.children.items():
        if key == without:
            continue
        below = base.children.get(key)
        merged = node if below is None else overlaid(below[0], node)
        children[key] = (merged, line, column)
        value[key] = merged.value
    return replace(over, value=value, children=children)


Scalar: TypeAlias = "str | int | float | bool | None"

_CORE_PREFIX: Final = "tag:yaml.org,2002:"

_WORDS: Final[dict[str, bool | None]] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
_SPECIAL_FLOATS: Final = {
    **{sign + word: math.inf for sign in ("", "+") for word in (".inf", ".Inf", ".INF")},
    **{"-" + word: -math.inf for word in (".inf", ".Inf", ".INF")},
    **dict.fromkeys((".nan", ".NaN", ".NAN"), math.nan),
}
_INT: Final = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT: Final = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_MOST_DIGITS: Final = 18  # fits 64 bits, and keeps int() from quadratic work


class ScalarError(ValueError):
    """Raised for a scalar that does not fit its tag, or a number out of range."""

    def __init__(self, code: str, message: str) -> None:
        self.code = code
        super().__init__(message)


def resolve_plain(text: str) -> Scalar:
    """Return the value of an unquoted scalar.

    Raises:
        ScalarError: The number is too large.
    """
    if text in _WORDS:
        return _WORDS[text]
    if text[0] not in "+-.0123456789":
        return text
    if _INT.fullmatch(text):
        if len(text) > _MOST_DIGITS:
            raise ScalarError("number", f"the number has more than {_MOST_DIGITS} digits")
        return int(text, 0) if text[:2] in ("0o", "0x") else int(text)
    if text in _SPECIAL_FLOATS:
        return _SPECIAL_FLOATS[text]
    if _FLOAT.fullmatch(text):
        value = float(text)
        if math.isinf(value):
            raise ScalarError("number", "the number is too large")
        return value
    return text


def _resolve_tagged(tag: str, text: str) -> Scalar:
    """Return the value of a scalar with an explicit tag of the core schema.

    Raises:
        ScalarError: The tag is not allowed, or the text does not fit it.
    """
    kind = tag.removeprefix(_CORE_PREFIX)
    if not tag.startswith(_CORE_PREFIX) or kind not in ("str", "int", "float", "bool", "null"):
        shown = tag.replace(_CORE_PREFIX, "!!")
        raise ScalarError("tag", f"the tag '{shown}' is not allowed: files hold plain data only")
    if kind == "str":
        return text
    value = resolve_plain(text)
    if kind == "float" and type(value) is int:
        return float(value)
    if type(value).__name__ != {"null": "NoneType"}.get(kind, kind):
        raise ScalarError("tag", f"'{text}' does not fit its tag '!!{kind}'")
    return value


# A part of the parser's message, our message, and the expected input.
_ADVICE: Final = (
    (
        "mapping values are not allowed",
        "a ':' is not allowed here",
        "the same indentation as the line before, or text with ': ' in quotes",
    ),
    ("entries are not allowed", "a '- ' is not allowed here", "list items on lines of their own"),
    ("tab character", "a tab cannot indent a line", "blanks"),
    ("unknown escape", "an unknown escape in double quotes", "single quotes, or '\\\\' for '\\'"),
    ("flow node", "a value, or a closing bracket, is missing", ""),
    ("node content", "no value can begin here", ""),
    ("flow sequence", "a '[' is not closed, or a ',' is missing", "',' or ']'"),
    ("flow mapping", "a '{' is not closed, or a ',' is missing", "',' or '}'"),
    ("end of stream", "a quote is not closed", "the closing quote"),
    ("expected ':'", "a ':' is missing after a key", "'key: value', with a space after the ':'"),
    (
        "block mapping",
        "this does not continue the mapping",
        "'key: value' in line with the keys above, and nothing after a closing quote",
    ),
    ("block collection", "this does not continue the list", "'- ' in line with the items above"),
)


def _syntax_fault(error: yaml.MarkedYAMLError, innermost: YamlNode | None) -> YamlFault:
    """Return a syntax error as a fault with a helpful message."""
    said = f"{error.context or ''} {error.problem or ''}"
    mark, opening = error.problem_mark or error.context_mark, error.context_mark
    if ("end of stream" in said or "expected ':'" in said) and opening is not None:
        mark = opening
    line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
    if "flow" in said and innermost is not None and line > innermost.line:
        # The parser notices a missing end only some lines later, so report the beginning.
        line, column = innermost.line, innermost.column
    if "cannot start any token" in said:
        return _bad_character(error, line, column)
    for needle, message, expected in _ADVICE:
        if needle in said:
            return YamlFault("syntax", line, column, message, expected)
    return YamlFault("syntax", line, column, f"is not YAML: {error.problem or error.context}")


def _bad_character(error: yaml.MarkedYAMLError, line: int, column: int) -> YamlFault:
    """Return the fault of an invalid first character, usually a tab, '%', '@' or '`'."""
    # Only PyYAML's own parser names it; for both, a tab is what people trip over at a line start.
    if "'\\t'" in (error.problem or "") or column == 1:
        return YamlFault("syntax", line, column, "a tab cannot indent a line", "blanks")
    message = "a value cannot begin with this character"
    return YamlFault("syntax", line, column, message, "the text in quotes")


def _key_fault(key: YamlNode) -> YamlFault:
    """Return the fault of a key that is not text."""
    if isinstance(key.value, dict | list):
        message = "a mapping or list cannot be a key"
        expected = "text as the key; text in braces or brackets needs quotes"
    else:
        shown = json.dumps(key.value)
        message = f"the key '{shown}' is not text"
        expected = f"text as the key; in quotes ('{shown}') it is text"
    return YamlFault("key", key.line, key.column, message, expected)


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
            _earlier_fault(text, error) or _syntax_fault(error, composer.innermost)
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
                node.value = _resolve_tagged(event.tag, event.value)
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
        if event.tag not in (None, "!", _CORE_PREFIX + kind):
            shown = event.tag.replace(_CORE_PREFIX, "!!")
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
            self.faults.append(_key_fault(key))
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
