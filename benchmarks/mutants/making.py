"""The small faults that can be made in a Python file, each as a change of its text."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

_SYMBOLS: dict[type[ast.cmpop], str] = {
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
    ast.Is: "is",
    ast.IsNot: "is not",
    ast.In: "in",
    ast.NotIn: "not in",
}

_FLIPPED = {
    **{"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="},
    **{"is": "is not", "is not": "is", "in": "not in", "not in": "in"},
}

_SKIPPED = (ast.JoinedStr, ast.Assert, ast.pattern)
"""Parts of the tree without mutants: texts for people, what only documents the code, and patterns
of a ``match``, whose parts are no expressions."""


_SYMMETRIC = frozenset({"min", "max", "suppress", "hypot", "dot"})
"""Functions whose arguments may be in any order."""


class Mutant(NamedTuple):
    """One small fault.

    Attributes:
        path: File, relative to the root of the tree.
        line: Line of the code that is changed, from 1.
        function: Qualified name of the function that holds it.
        kind: ``comparison``, ``term``, ``statement``, ``arguments`` or ``constant``.
        start: Offset in bytes of the code that is changed; ``end`` that after it.
    """

    path: str
    line: int
    function: str
    kind: str
    before: str
    after: str
    start: int
    end: int

    def apply(self, source: bytes) -> bytes:
        """Return the source with the fault."""
        return source[: self.start] + self.after.encode() + source[self.end :]


def mutants_of(path: str, source: bytes) -> list[Mutant]:
    """Return every mutant of the functions in a file; what a file does on import is left out."""
    return list(_Maker(path, source).of(ast.parse(source), ()))


class _Maker:
    def __init__(self, path: str, source: bytes) -> None:
        self._path = path
        self._source = source
        self._begins = [0]
        for line in source.splitlines(keepends=True):
            self._begins.append(self._begins[-1] + len(line))

    def of(self, node: ast.AST, names: tuple[str, ...]) -> Iterator[Mutant]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.ClassDef):
                yield from self.of(child, (*names, child.name))
            elif isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
                name = ".".join((*names, child.name))
                for each in (*child.args.defaults, *child.args.kw_defaults, *_body(child)):
                    if each is not None:
                        yield from self._inside(each, name)
            elif isinstance(child, ast.If | ast.Try | ast.With):
                yield from self.of(child, names)

    def _inside(self, node: ast.AST, name: str) -> Iterator[Mutant]:
        if isinstance(node, _SKIPPED) or _is_promise(node):
            return
        for kind, part, after in self._changes(node):
            start, end = self._range(part)
            before = self._source[start:end].decode()
            if before != after:
                yield Mutant(self._path, part.lineno, name, kind, before, after, start, end)
        annotation = getattr(node, "annotation", None)
        for child in ast.iter_child_nodes(node):
            if child is not annotation:
                yield from self._inside(child, name)

    def _changes(self, node: ast.AST) -> Iterator[tuple[str, ast.expr | ast.stmt, str]]:
        if isinstance(node, ast.stmt):
            if _is_removable(node):
                yield "statement", node, "pass"
        elif isinstance(node, ast.Compare):
            yield from (("comparison", node, text) for text in self._flipped(node))
        elif isinstance(node, ast.BoolOp | ast.BinOp | ast.UnaryOp):
            yield from (("term", node, text) for text in self._shorter(node))
        elif isinstance(node, ast.Call):
            if not (_is_symmetric(node) or any(isinstance(a, ast.Starred) for a in node.args)):
                yield from (("arguments", node, text) for text in self._swapped(node))
        elif isinstance(node, ast.Constant) and isinstance(node.value, bool | int | float):
            other = not node.value if isinstance(node.value, bool) else node.value + 1
            yield "constant", node, repr(other)

    def _flipped(self, node: ast.Compare) -> Iterator[str]:
        """Yield the comparison with each of its operators flipped."""
        left, *rights = (self._text(each) for each in (node.left, *node.comparators))
        for number in range(len(rights)):
            words = [_SYMBOLS[type(each)] for each in node.ops]
            words[number] = _FLIPPED[words[number]]
            yield left + "".join(
                f" {word} {side}" for word, side in zip(words, rights, strict=True)
            )

    def _shorter(self, node: ast.BoolOp | ast.BinOp | ast.UnaryOp) -> Iterator[str]:
        """Yield the expression without each of its terms, or without its sign or ``not``."""
        match node:
            case ast.BoolOp(operator, values):
                word = " and " if isinstance(operator, ast.And) else " or "
                for left_out in values:
                    kept = (self._text(each) for each in values if each is not left_out)
                    yield f"({word.join(kept)})"
            case ast.BinOp(left, ast.Add() | ast.Sub() | ast.Mult() | ast.Div(), _):
                yield self._text(left)
            case ast.UnaryOp(ast.Not() | ast.USub(), operand):
                yield f"({self._text(operand)})"
            case _:  # nothing can be left out of `a % b` or `~a`
                pass

    def _swapped(self, node: ast.Call) -> Iterator[str]:
        """Yield the call with each two neighbours of its arguments swapped."""
        begin, end = self._range(node)
        for first, second in pairwise(node.args):
            (a, b), (c, d) = self._range(first), self._range(second)
            parts = ((begin, a), (c, d), (b, c), (a, b), (d, end))
            yield b"".join(self._source[start:stop] for start, stop in parts).decode()

    def _text(self, node: ast.expr) -> str:
        """Return the source of an expression, in parentheses where it had them or needs them."""
        start, end = self._range(node)
        text = self._source[start:end].decode()
        plain = isinstance(node, ast.Name | ast.Constant | ast.Attribute | ast.Call | ast.Subscript)
        return text if plain else f"({text})"

    def _range(self, node: ast.expr | ast.stmt) -> tuple[int, int]:
        """Return where the code begins and ends, as offsets in bytes."""
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        begins = self._begins
        return (
            begins[node.lineno - 1] + node.col_offset,
            begins[node.end_lineno - 1] + node.end_col_offset,
        )


def _is_symmetric(node: ast.Call) -> bool:
    """Whether the order of the arguments changes nothing, as for the least of some numbers."""
    return isinstance(node.func, ast.Name) and node.func.id in _SYMMETRIC and not node.keywords


def _is_promise(node: ast.AST) -> bool:
    """Whether this is the ``strict=True`` of a ``zip``, which only documents equal lengths."""
    return isinstance(node, ast.keyword) and ast.unparse(node) == "strict=True"


def _is_removable(node: ast.stmt) -> bool:
    """Whether the code still runs, though otherwise, without this statement."""
    match node:
        case ast.Expr(ast.Constant()):
            return False
        case ast.Expr() | ast.AugAssign() | ast.Raise() | ast.Continue() | ast.Break():
            return True
        case ast.Assign([ast.Attribute() | ast.Subscript()]):
            return True
        case ast.If(orelse=[]):
            return True
        case _:
            return False


def _body(function: ast.FunctionDef | ast.AsyncFunctionDef) -> list[ast.stmt]:
    documented = ast.get_docstring(function, clean=False) is not None
    return function.body[1:] if documented else function.body
