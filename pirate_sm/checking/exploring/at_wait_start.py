"""Reduce a condition to the beginning of its wait, when all changes of signals are 0."""

from __future__ import annotations

from collections.abc import Callable, Set
from dataclasses import replace

from pirate_sm.expressions import tree


def at_beginning(node: tree.Node, changes: Set[str]) -> tree.Node:
    """Return the condition with 0 for each change of a signal.

    A test whether a change is known is kept, because a signal may be unknown when the wait begins.

    Args:
        node: The condition, or a part of it.
        changes: Names of the changes, as :func:`~pirate_sm.expressions.vocabulary.change_of` gives
            them.
    """
    if isinstance(node, tree.Signal) and node.name in changes:
        return tree.Number(0.0)
    if isinstance(node, tree.Known):
        return node
    return _rebuilt(node, lambda each: at_beginning(each, changes))


def _rebuilt(node: tree.Node, change: Callable[[tree.Node], tree.Node]) -> tree.Node:
    """Return the node with a change of each node directly below it."""
    match node:
        case tree.Negate(operand) | tree.Not(operand):
            return replace(node, operand=change(operand))
        case tree.Arithmetic(_, left, right) | tree.Compare(_, left, right):
            return replace(node, left=change(left), right=change(right))
        case tree.Call(_, parts):
            return replace(node, arguments=tuple(map(change, parts)))
        case tree.And(parts) | tree.Or(parts):
            return replace(node, parts=tuple(map(change, parts)))
        case _:
            return node
