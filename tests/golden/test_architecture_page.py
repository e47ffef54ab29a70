"""docs/architecture.md names every layer and folder. `make golden` writes both lists anew."""

from __future__ import annotations

import ast
import os
import tomllib
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "pirate_sm"
PAGE = ROOT / "docs" / "architecture.md"


def layers() -> Iterator[str]:
    """Yield a line for each layer, as the contract of import-linter orders them."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    (wanted,) = (each for each in contracts if each["id"] == "layers")
    for number, layer in enumerate(wanted["layers"], 1):
        names = layer.replace("(", "").replace(")", "").split(" | ")
        yield f"{number:>2}  {'   '.join(names)}"


def tree(folder: Path = PACKAGE, depth: int = 0) -> Iterator[str]:
    """Yield a line for each package and each module beside them."""
    yield line(f"{folder.name}/", folder / "__init__.py", depth)
    for path in sorted(folder.iterdir()):
        if (path / "__init__.py").is_file():
            yield from tree(path, depth + 1)
        elif not depth and path.suffix == ".py" and path.name != "__init__.py":
            yield line(path.name, path, depth + 1)


def line(name: str, file: Path, depth: int) -> str:
    said = ast.get_docstring(ast.parse(file.read_text("utf-8"))) or ""
    return f"{'  ' * depth + name:<20}{said.partition(chr(10))[0].rstrip('.')}"


def test_the_page_lists_every_layer_and_every_folder() -> None:
    text = wanted = PAGE.read_text("utf-8")
    for name, lines in (("layers", layers()), ("tree", tree())):
        before, mark, rest = wanted.partition(f"<!-- {name}: written by `make golden` -->\n")
        _, end, after = rest.partition("<!-- end -->")
        assert mark, f"no place for: {name}"
        assert end, f"no end of: {name}"
        wanted = f"{before}{mark}```text\n" + "\n".join(lines) + f"\n```\n{end}{after}"
    if os.environ.get("GOLDEN") == "write":
        PAGE.write_text(wanted, encoding="utf-8")
        text = wanted

    assert text == wanted
