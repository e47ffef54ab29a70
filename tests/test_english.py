"""Texts use engineers' words: phrases that read as translated may only become fewer."""

from __future__ import annotations

import ast
import io
import os
import re
import tokenize
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest
import yaml

from pirate_sm.cli import start

ROOT = Path(__file__).resolve().parents[1]
LIST = Path(__file__).with_name("english.yaml")
PHRASES = yaml.safe_load(LIST.read_text("utf-8"))
PACKAGE = sorted((ROOT / "pirate_sm").rglob("*.py"))
DOCS = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
FIRST_READ = [
    ROOT / "README.md",
    ROOT / "docs" / "how-to.md",
    *sorted((ROOT / "docs" / "tutorial").glob("*.md")),
    *sorted((ROOT / "docs" / "how-to").glob("*.md")),
]
CATALOGUE = sorted((ROOT / "pirate_sm" / "checking" / "catalogue").glob("*.yaml"))
HELP = sorted(Path(start.HELP_FOLDER).iterdir())

_FENCED = re.compile(r"^ *```.*?^ *```", re.MULTILINE | re.DOTALL)
_SPAN = re.compile(r"``[^`]*``|`[^`]*`")
_OPTION_VALUES = re.compile(r"<[^>]*>|\[[^\]]*\]")


def _of_python(path: Path) -> Iterator[str]:
    """Yield the docstrings, the messages and the comments of a module, without code in them."""
    source = path.read_text("utf-8")
    yield from _strings(ast.parse(source))
    comments = [
        token.string.lstrip("# ")
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type == tokenize.COMMENT
    ]
    yield " ".join(comments)


def _strings(node: ast.AST) -> Iterator[str]:
    """Yield the texts below a node; of a formatted one all parts together."""
    if isinstance(node, ast.JoinedStr):
        yield "".join(
            part.value if isinstance(part, ast.Constant) else "\u2026" for part in node.values
        )
        below = [part for part in node.values if isinstance(part, ast.FormattedValue)]
    elif isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
        yield node.value
        below = []
    else:
        below = list(ast.iter_child_nodes(node))
    for each in below:
        yield from _strings(each)


def _of_page(path: Path) -> Iterator[str]:
    yield _FENCED.sub("", path.read_text("utf-8"))


def _of_help(path: Path) -> Iterator[str]:
    yield _OPTION_VALUES.sub("", path.read_text("utf-8"))


def _of_catalogue(path: Path) -> Iterator[str]:
    """Yield what the catalogue says to people: the values of its entries, not their keys."""
    yield from _values(yaml.safe_load(path.read_text("utf-8")))


def _values(node: object) -> Iterator[str]:
    match node:
        case str():
            yield node
        case dict():
            for value in node.values():
                yield from _values(value)
        case list():
            for value in node:
                yield from _values(value)


def _occurrences(texts: Iterable[str]) -> dict[str, int]:
    joined = "\n".join(re.sub(r"\s+", " ", _SPAN.sub("", text)) for text in texts)
    return {
        entry["find"]: len(re.findall(entry["find"], joined, re.IGNORECASE)) for entry in PHRASES
    }


def _lower(found: dict[str, dict[str, int]]) -> None:
    """Write the counts that have fallen into the list; none is raised."""
    text = LIST.read_text("utf-8")
    for line, entry in zip(re.findall(r"^- .*$", text, re.MULTILINE), PHRASES, strict=True):
        lowered = line
        for where, counts in found.items():
            most = min(entry[where], counts[entry["find"]])
            lowered = re.sub(rf"{where}: \d+", f"{where}: {most}", lowered)
        text = text.replace(line, lowered)
    LIST.write_text(text, "utf-8")


@pytest.mark.thorough  # it takes the whole package apart
def test_phrases_that_read_as_translated_only_become_fewer():
    found = {
        "package": _occurrences(text for path in PACKAGE for text in _of_python(path)),
        "docs": _occurrences(text for path in DOCS for text in _of_page(path)),
    }
    if os.environ.get("GOLDEN") == "write":
        _lower(found)
        return
    other = [
        f"{where}: '{entry['find']}' {counts[entry['find']]} times, {entry[where]} in the list: "
        f"write {entry['write']}, or lower the list with GOLDEN=write"
        for where, counts in found.items()
        for entry in PHRASES
        if counts[entry["find"]] != entry[where]
    ]
    assert other == []


@pytest.mark.parametrize(
    ("path", "texts_of"),
    [
        *((path, _of_page) for path in FIRST_READ),
        *((path, _of_help) for path in HELP),
        *((path, _of_catalogue) for path in CATALOGUE),
    ],
    ids=lambda value: str(value.relative_to(ROOT)) if isinstance(value, Path) else "",
)
def test_what_users_read_first_has_none_of_these_phrases(path, texts_of):
    counts = _occurrences(texts_of(path))
    wrong = {entry["find"]: entry["write"] for entry in PHRASES if counts[entry["find"]]}
    assert wrong == {}
