"""Values and faults of a YAML file with their places, and one tree of values over another."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeAlias

Children: TypeAlias = "dict[str, tuple[YamlNode, int, int]] | list[YamlNode] | None"


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
    children: Children = None
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
    children: Children = node.children
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
