"""Reduce a condition to the beginning of its wait, when all changes of signals are 0."""

from __future__ import annotations

from collections.abc import Set

from pirate_sm.expressions import tree


def at_beginning(node: tree.Node, changes: Set[str]) -> tree.Node:
    """Return the condition with 0 for each change of a signal.

    A test whether a change is known is kept, because a signal may be unknown when the wait begins.

    Args:
        node: The condition, or a part of it.
        changes: Names of the changes, as :func:`~pirate_sm.expressions.vocabulary.change_of` gives
            them.
    """
    match node:
        case tree.Signal(name) if name in changes:
            return tree.Number(0.0)
        case tree.Negate(operand):
            return tree.Negate(at_beginning(operand, changes))
        case tree.Not(operand):
            return tree.Not(at_beginning(operand, changes))
        case tree.Arithmetic(operator, left, right):
            return tree.Arithmetic(
                operator, at_beginning(left, changes), at_beginning(right, changes)
            )
        case tree.Compare(order, left, right):
            return tree.Compare(order, at_beginning(left, changes), at_beginning(right, changes))
        case tree.Call(function, parts):
            return tree.Call(function, tuple(at_beginning(each, changes) for each in parts))
        case tree.And(parts):
            return tree.And(tuple(at_beginning(part, changes) for part in parts))
        case tree.Or(parts):
            return tree.Or(tuple(at_beginning(part, changes) for part in parts))
        case _:
            return node
