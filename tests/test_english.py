"""Texts use engineers' words: phrases that read as translated may only become fewer."""

from __future__ import annotations

import io
import os
import re
import tokenize
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest
import yaml

from pirate_sm.cli import stored_help

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
HELP = sorted(Path(stored_help.FOLDER).iterdir())

_FENCED = re.compile(r"^ *```.*?^ *```", re.MULTILINE | re.DOTALL)
_SPAN = re.compile(r"``[^`]*``|`[^`]*`")
_FIELD = re.compile(r"\{[^{}]*\}")
_OPTION_VALUES = re.compile(r"<[^>]*>|\[[^\]]*\]")


def _of_python(path: Path) -> str:
    """Return the comments, docstrings and messages of a module, without code in them."""
    tokens = tokenize.generate_tokens(io.StringIO(path.read_text("utf-8")).readline)
    texts = [
        token.string
        for token in tokens
        if token.type == tokenize.COMMENT or (token.type == tokenize.STRING and " " in token.string)
    ]
    return _FIELD.sub("", _SPAN.sub("", "\n".join(texts)))


def _of_page(path: Path) -> str:
    return _SPAN.sub("", _FENCED.sub("", path.read_text("utf-8")))


def _of_help(path: Path) -> str:
    return _OPTION_VALUES.sub("", path.read_text("utf-8"))


def _of_catalogue(path: Path) -> str:
    """Return what the catalogue says to people: the values of its entries, not their keys."""
    return "\n".join(_values(yaml.safe_load(path.read_text("utf-8"))))


def _values(node: object) -> Iterator[str]:
    match node:
        case str():
            yield _SPAN.sub("", node)
        case dict():
            for value in node.values():
                yield from _values(value)
        case list():
            for value in node:
                yield from _values(value)


def _occurrences(texts: Iterable[str]) -> dict[str, int]:
    joined = "\n".join(re.sub(r"\s+", " ", text) for text in texts)
    return {entry["find"]: len(re.findall(entry["find"], joined)) for entry in PHRASES}


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
        "package": _occurrences(map(_of_python, PACKAGE)),
        "docs": _occurrences(map(_of_page, DOCS)),
    }
    if os.environ.get("GOLDEN") == "write":
        _lower(found)
        return
    more = [
        f"{where}: '{entry['find']}' {counts[entry['find']]} times (at most {entry[where]}): "
        f"write {entry['write']}"
        for where, counts in found.items()
        for entry in PHRASES
        if counts[entry["find"]] > entry[where]
    ]
    assert more == []


@pytest.mark.parametrize(
    ("path", "text_of"),
    [
        *((path, _of_page) for path in FIRST_READ),
        *((path, _of_help) for path in HELP),
        *((path, _of_catalogue) for path in CATALOGUE),
    ],
    ids=lambda value: str(value.relative_to(ROOT)) if isinstance(value, Path) else "",
)
def test_what_users_read_first_has_none_of_these_phrases(path, text_of):
    counts = _occurrences([text_of(path)])
    wrong = {entry["find"]: entry["write"] for entry in PHRASES if counts[entry["find"]]}
    assert wrong == {}
