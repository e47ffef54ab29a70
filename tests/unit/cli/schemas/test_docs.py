"""The documents and the schemas name the same keys, with the same defaults and choices."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from typing import Any

import pytest

from pirate_sm.cli.schema_files import KINDS

from .shipped import ROOT

PAGES = {
    "mission": ["missions.md", "pipes.md"],
    "pipe": ["pipes.md"],
    "profile": ["robots.md", "connecting.md", "serial.md", "simulator.md", "traction.md"],
    "chart": ["robots.md"],
    "profile_extension": ["robots.md", "connecting.md", "serial.md", "simulator.md", "traction.md"],
    "chart_extension": ["robots.md"],
    "camera": ["camera.md"],
    "panel": ["panel.md"],
    "campaign": ["campaigns.md", "margins.md"],
    "scene": ["demo.md"],
    "twin": ["experiments.md", "campaigns.md"],
}
_CODE = re.compile(r"```.*?```|`[^`]+`", re.DOTALL)
_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


@cache
def schema(kind: str) -> dict[str, Any]:
    return KINDS[kind]()


def pages(kind: str) -> str:
    return "\n".join((ROOT / "docs" / page).read_text("utf-8") for page in PAGES[kind])


@pytest.mark.parametrize("kind", KINDS)
def test_the_documents_name_every_key(kind: str) -> None:
    written = {word for code in _CODE.findall(pages(kind)) for word in _WORD.findall(code)}
    assert sorted(set(keys(schema(kind))) - written) == []


@pytest.mark.parametrize(
    "kind", ["mission", "pipe", "profile", "camera", "panel", "campaign", "scene"]
)
def test_the_documents_name_every_choice(kind: str) -> None:
    written = {word for code in _CODE.findall(pages(kind)) for word in _WORD.findall(code)}
    choices = {str(each) for node in nodes(schema(kind)) for each in node.get("enum", ())}
    words = {choice for choice in choices if _WORD.fullmatch(choice)}
    assert sorted(words - written) == []


@pytest.mark.parametrize(
    "kind", ["mission", "pipe", "profile", "camera", "panel", "campaign", "scene"]
)
def test_every_key_in_a_table_of_the_documents_is_one(kind: str) -> None:
    page = (ROOT / "docs" / PAGES[kind][0]).read_text("utf-8")
    known = set(keys(schema(kind)))
    assert [key for key in table_keys(page) if key not in known] == []


@pytest.mark.parametrize("kind", ["mission", "pipe"])
def test_what_the_documents_call_needed_is_required(kind: str) -> None:
    text = (ROOT / "docs" / PAGES[kind][0]).read_text("utf-8")
    needed = {cells[0].strip("`") for cells in rows(text) if cells[-1] == "needed"}
    assert needed == set(schema(kind)["required"])


def nodes(node: Any) -> Iterator[dict[str, Any]]:
    if isinstance(node, dict):
        yield node
        for each in node.values():
            yield from nodes(each)
    elif isinstance(node, list):
        for each in node:
            yield from nodes(each)


def keys(schema: Any) -> Iterator[str]:
    for node in nodes(schema):
        found = node.get("properties")
        if isinstance(found, dict) and all(isinstance(each, dict) for each in found.values()):
            yield from found


def rows(text: str) -> Iterator[list[str]]:
    """The cells of each row of the tables whose first column is headed `key`."""
    inside = False
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if not line.startswith("|"):
            inside = False
        elif cells[0] == "key":
            inside = True
        elif inside and not set(line) <= set("|-"):
            yield cells


def table_keys(text: str) -> list[str]:
    return [key for cells in rows(text) for key in re.findall(r"`(\w+)`", cells[0])]
