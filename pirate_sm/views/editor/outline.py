"""The outline of a YAML file, and its parts that an editor can fold."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from lsprotocol.types import DocumentSymbol, FoldingRange, SymbolKind

from pirate_sm.core.documents import Document, YamlNode
from pirate_sm.views.editor.positions import Positions

_DEEPEST = 2
"""Deeper than this only what takes several lines is in the outline. [decided]"""

_KINDS = {
    dict: SymbolKind.Object,
    list: SymbolKind.Array,
    str: SymbolKind.String,
    bool: SymbolKind.Boolean,
    int: SymbolKind.Number,
    float: SymbolKind.Number,
}
_LONGEST = 60


class _Entry(NamedTuple):
    """A value with its key or, in a list, the first text in it as its name.

    Attributes:
        start: Where the key begins, or the value that has none.
    """

    name: str
    start: int
    node: YamlNode


def symbols(document: Document, positions: Positions) -> list[DocumentSymbol]:
    """Return the outline of a file."""
    return _symbols(document, document.root, positions, 1)


def folds(document: Document, positions: Positions) -> list[FoldingRange]:
    """Return what can be folded: values of several lines, from the lines of their keys."""
    return [*_folds(document, document.root, positions)]


def _symbols(
    document: Document, node: YamlNode, positions: Positions, depth: int
) -> list[DocumentSymbol]:
    found = []
    for name, start, inner in _entries(node, positions):
        whole = positions.between(start, max(end_of(document, inner), start))
        if depth > _DEEPEST and whole.start.line == whole.end.line:
            continue
        named = positions.between(start, start + len(name))
        value, kind = inner.value, _KINDS.get(type(inner.value), SymbolKind.Null)
        chosen = named if named.end <= whole.end else whole
        shown = "" if inner.children is not None else str(value)[:_LONGEST]
        below = _symbols(document, inner, positions, depth + 1)
        found.append(DocumentSymbol(name or "…", kind, whole, chosen, shown, children=below))
    return found


def _folds(document: Document, node: YamlNode, positions: Positions) -> Iterator[FoldingRange]:
    for _, start, inner in _entries(node, positions):
        whole = positions.between(start, max(end_of(document, inner), start))
        if whole.start.line < whole.end.line:
            yield FoldingRange(whole.start.line, whole.end.line)
            yield from _folds(document, inner, positions)


def _entries(node: YamlNode, positions: Positions) -> Iterator[_Entry]:
    """Yield what is written in a mapping or a list; nothing that an alias stands for."""
    if isinstance(node.children, dict):
        for name, (inner, line, column) in node.children.items():
            if node.start <= inner.start <= node.end:
                yield _Entry(name, positions.index(line, column), inner)
    for number, inner in enumerate(node.children if isinstance(node.children, list) else ()):
        if node.start <= inner.start <= node.end:
            content = inner.value.values() if isinstance(inner.value, dict) else [inner.value]
            texts = (each for each in content if isinstance(each, str))
            yield _Entry(next(texts, str(number + 1))[:_LONGEST], inner.start, inner)


def end_of(document: Document, node: YamlNode) -> int:
    """Return where a value ends, without comments and empty lines below it."""
    children = node.children or ()
    written = document.text[node.start : node.end]
    if children and not written.startswith(("{", "[", "*")):
        last = [*children][-1]
        inner = node.children[last][0] if isinstance(node.children, dict) else last
        return max(end_of(document, inner), inner.start)
    return node.start + len(written.rstrip())
