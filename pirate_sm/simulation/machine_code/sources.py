"""The source files that machine code was made of, and one number for what they hold."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parents[2]
"""The folder of the package."""


def files_behind(modules: Iterable[str], package: Path = PACKAGE) -> tuple[str, ...]:
    """Return the files of modules and of all they import from the package, themselves included.

    Of a module that only hands a name on, its file counts, but not what else it imports.

    Args:
        modules: Full names of modules; one of another package is passed over.
        package: The folder of the package.

    Returns:
        Sorted paths below the package, with `/`.
    """
    tree_of = cache(_tree_of)
    found: set[Path] = set()
    handing_on: set[Path] = set()
    left = [file for name in modules if (file := _file_of(name, package))]
    while left:
        file = left.pop()
        if file in found:
            continue
        found.add(file)
        for imported in _imports(tree_of(file)):
            module, name = imported
            while (via := _file_of(module, package)) and (origin := _origin(tree_of(via), name)):
                if origin == (module, name):
                    break
                handing_on.add(via)
                module, name = origin
            names = (module, f"{module}.{name}")
            left += [each for full in names if (each := _file_of(full, package))]
    every = found | handing_on
    return tuple(sorted(file.relative_to(package).as_posix() for file in every))


def digest(files: Iterable[str], package: Path = PACKAGE) -> str:
    """Return a number for names and contents of files; empty if one of them cannot be read."""
    hashed = hashlib.sha256()
    try:
        for name in files:
            content = (package / name).read_bytes()
            hashed.update(f"{name} {len(content)}\n".encode())
            hashed.update(content)
    except OSError:
        return ""
    return hashed.hexdigest()


def _file_of(module: str, package: Path) -> Path | None:
    first, *rest = module.split(".")
    if first != package.name or not rest:
        return None
    place = package.joinpath(*rest)
    for file in (place.with_name(f"{place.name}.py"), place / "__init__.py"):
        if file.is_file():
            return file
    return None


def _tree_of(file: Path) -> ast.Module:
    return ast.parse(file.read_bytes())


def _imports(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Yield what a module imports: the module, and the name in it, which is empty for a module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((each.name, "") for each in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from ((node.module, each.name) for each in node.names)


def _origin(tree: ast.Module, name: str) -> tuple[str, str] | None:
    """Return from where a module has a name, and its name there; None for one of its own."""
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.module:
            for each in node.names:
                if (each.asname or each.name) == name:
                    return node.module, each.name
    return None
