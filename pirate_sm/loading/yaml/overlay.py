"""Lay one YAML tree over another: mappings are merged, any other value is replaced."""

from __future__ import annotations

from dataclasses import replace

from pirate_sm.loading.yaml.nodes import Children, Node


def from_file(node: Node, name: str) -> Node:
    """Return a copy of a tree whose nodes know the file that they are from."""
    children: Children = node.children
    if isinstance(children, dict):
        children = {
            key: (from_file(it, name), line, column) for key, (it, line, column) in children.items()
        }
    elif isinstance(children, list):
        children = [from_file(each, name) for each in children]
    return replace(node, children=children, file=node.file or name)


def overlaid(base: Node, over: Node, *, without: str = "") -> Node:
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
