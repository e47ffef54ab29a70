"""Read and evaluate the guards of a chart, and report their faults."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping

from pirate_sm.core._loading.chart.outline import StateNode, WrittenTransition
from pirate_sm.core._loading.problems import Problems
from pirate_sm.core.spelling import nearest

States = Mapping[str, str]
"""The state of each region."""

ANY_OF = "|"
"""Separator of states in an expanded guard: ``In('Region.one|two')``."""


def guard_on_leaves(guard: str, every: Mapping[str, StateNode]) -> ast.expr | None:
    """Return the guard with compound states replaced by their leaves; None without a guard."""
    tree = _read(guard)
    for node in ast.walk(tree) if tree is not None else ():
        named = every.get(str(node.value)) if isinstance(node, ast.Constant) else None
        if named is not None and named.inner and isinstance(node, ast.Constant):
            region = named.name.partition(".")[0]
            node.value = f"{region}.{ANY_OF.join(leaf.short_name for leaf in named.leaves)}"
    return tree


def _read(guard: str) -> ast.expr | None:
    """Return a guard as a tree; None if there is none, or a faulty one."""
    try:
        return ast.parse(guard, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


def check_guard(move: WrittenTransition, known: list[str], problems: Problems) -> None:
    """Report the faults of a transition's guard."""
    path = (*move.path, "cond")
    guard = _read(move.guard)
    if guard is None:
        expected = "In('…') with and, or, not"
        problems.add("chart.guard", path, "this guard cannot be read", expected=expected)
        return
    for message, name in dict.fromkeys(_faults(guard, known)):
        problems.add("chart.guard", path, message, suggestion=name)


def _faults(node: ast.expr, known: list[str]) -> Iterator[tuple[str, str]]:
    """Yield each fault of a guard, with the state that was probably meant, or an empty text."""
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
        return region, states.split(ANY_OF)
    raise AssertionError(f"the loader has let {ast.dump(node)} pass")
