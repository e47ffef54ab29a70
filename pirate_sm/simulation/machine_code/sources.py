"""The source files that machine code was made of, and one number for what they hold."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterable, Iterator
from pathlib import Path

PACKAGE = Path(__file__).parents[2]
"""The folder of the package."""


def files_behind(modules: Iterable[str], package: Path = PACKAGE) -> tuple[str, ...]:
    """Return the files of modules and of all they import from the package, themselves included.

    Args:
        modules: Full names of modules; one of another package is passed over.
        package: The folder of the package.

    Returns:
        Sorted paths below the package, with `/`.
    """
    found: set[Path] = set()
    left = [file for name in modules if (file := _file_of(name, package))]
    while left:
        file = left.pop()
        if file not in found:
            found.add(file)
            left += [each for name in _imports(file, package) if (each := _file_of(name, package))]
    return tuple(sorted(file.relative_to(package).as_posix() for file in found))


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


def _imports(file: Path, package: Path) -> Iterator[str]:
    """Yield the names of the modules that a file imports, and some that are no modules."""
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import):
            yield from (each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            for each in node.names:
                yield from _origin(node.module, each.name, package)


def _origin(module: str, name: str, package: Path) -> tuple[str, str]:
    """Return the module that a name is from, past those that only hand it on, and both joined."""
    file = _file_of(module, package)
    for node in ast.parse(file.read_bytes()).body if file else ():
        if isinstance(node, ast.ImportFrom) and any(each.name == name for each in node.names):
            return _origin(node.module or module, name, package)
    return module, f"{module}.{name}"
