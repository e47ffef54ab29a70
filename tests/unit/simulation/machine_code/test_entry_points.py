"""The table of the functions whose machine code is built."""

from __future__ import annotations

import ast
import sys
from functools import cache
from pathlib import Path

import pytest

from pirate_sm.simulation.machine_code.built_library import PACKAGE, files_behind
from pirate_sm.simulation.machine_code.entry_points import ENTRY_POINTS, EntryPoint, entry_point

HERE = "pirate_sm.simulation.machine_code"


@cache
def covered() -> tuple[str, ...]:
    """The files that the library is made of."""
    return files_behind([entry.module for entry in ENTRY_POINTS])


def parsed(file: Path) -> ast.Module:
    return ast.parse(file.read_text("utf-8"))


def annotations(entry: EntryPoint) -> tuple[list[str], str]:
    """The annotations of an entry point's arguments and of its result, as they are written."""
    tree = parsed(PACKAGE.parent.joinpath(*entry.module.split(".")).with_suffix(".py"))
    (function,) = (
        each for each in tree.body if isinstance(each, ast.FunctionDef) and each.name == entry.name
    )
    given = [ast.unparse(each.annotation) for each in function.args.args if each.annotation]
    assert function.returns is not None
    return [each.removeprefix("gliding.") for each in given], ast.unparse(function.returns)


@pytest.mark.parametrize("entry", ENTRY_POINTS, ids=lambda entry: entry.symbol)
def test_the_table_says_what_the_functions_say(entry: EntryPoint) -> None:
    assert annotations(entry) == ([each.kind for each in entry.arguments], entry.result)


@pytest.mark.thorough
def test_whatever_is_compiled_is_in_the_library() -> None:
    compiling = {
        file.relative_to(PACKAGE).as_posix()
        for file in PACKAGE.rglob("*.py")
        if "compiled" in {
            alias.name
            for node in ast.walk(parsed(file))
            if isinstance(node, ast.ImportFrom) and node.module == HERE
            for alias in node.names
        }
    }  # fmt: skip

    assert len(compiling) >= 3
    assert sorted(compiling - set(covered())) == [], "no entry point leads there: add its line"


def test_the_build_needs_nothing_but_numpy_for_what_it_compiles() -> None:
    needed = set()
    for name in covered():
        for node in parsed(PACKAGE / name).body:
            if isinstance(node, ast.Import):
                needed |= {each.name.partition(".")[0] for each in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module:
                needed.add(node.module.partition(".")[0])
    needed.discard("numba")  # of functions that are compiled when called

    assert needed - set(sys.stdlib_module_names) == {"numpy", "pirate_sm"}


@pytest.mark.parametrize("wrong", ["Floats", "Floats4", "Texts1", "str", "Ints2 complex"])
def test_what_is_no_machine_type_is_refused(wrong: str) -> None:
    with pytest.raises(ValueError, match=r"pkg\.module:name: '.*' is no machine type"):
        entry_point("pkg.module:name", wrong)


def test_an_array_cannot_be_returned() -> None:
    with pytest.raises(ValueError, match="'Floats1' cannot be returned"):
        entry_point("pkg.module:name", "int", "Floats1")
