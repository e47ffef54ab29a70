"""The faults that are put into the code on purpose."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from benchmarks.mutants.making import mutants_of


def changes(code: str) -> set[tuple[str, str]]:
    """Return what a function with this body becomes, by the kind of its fault."""
    source = f"def f(a, b, c):\n    {code}\n".encode()
    return {(m.kind, m.apply(source).decode()[20:-1]) for m in mutants_of("f.py", source)}


@pytest.mark.parametrize(
    ("code", "kind", "after"),
    [
        ("return a < b", "comparison", "return a <= b"),
        ("return a < b <= c", "comparison", "return a < b < c"),
        ("return a is not None", "comparison", "return a is None"),
        ("return a and b or c", "term", "return ((a and b))"),
        ("return a + b", "term", "return a"),
        ("return not a", "term", "return (a)"),
        ("a.b = c", "statement", "pass"),
        ("raise a", "statement", "pass"),
        ("return f(a, b, c)", "arguments", "return f(a, c, b)"),
        ("return 7", "constant", "return 8"),
        ("return True", "constant", "return False"),
    ],
)
def test_code_gets_the_fault(code: str, kind: str, after: str) -> None:
    assert (kind, after) in changes(code)


@pytest.mark.parametrize(
    "code",
    [
        *('"""Says it."""', "assert a > 7", "return f'{a + b}'", "return f(*a, b)", "return a"),
        *("return max(a, b)", "return hypot(a, b)", "return f(a, strict=True)"),
    ],
)
def test_what_decides_nothing_gets_none(code: str) -> None:
    assert changes(code) == set()


def test_a_mutant_names_its_place() -> None:
    source = b"class A:\n    def f(self, a=2):\n        return a\n"
    (mutant,) = mutants_of("a.py", source)
    assert (mutant.path, mutant.line, mutant.function) == ("a.py", 2, "A.f")


@pytest.mark.thorough
def test_every_mutant_of_a_file_is_python() -> None:
    source = Path(ast.__file__).read_bytes()
    mutants = mutants_of("ast.py", source)
    assert len(mutants) > 100
    for mutant in mutants[::20]:
        ast.parse(mutant.apply(source))
