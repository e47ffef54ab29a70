"""A mission is written from an empty file with what the editor offers."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from pirate_sm.core.documents import YamlNode, parse_document

from .client import Client, Json, served

ROOT = Path(__file__).resolve().parents[4]
SEQUENCES = ROOT / "sequences"
DRIVE = ROOT / "tests" / "mistakes" / "bases" / "drive.yaml"
WORD = re.compile(r"[A-Za-z_][\w.]*")
FREE_TEXT = {"description", "succeed", "fail", "ask", "log", "mission", "name"}
OWN_NAMES = ("parameters", "phases", "ends")
GLUE = {"and", "or", "not", "in", "x"}
"""Words of conditions between their signals; and what a test puts in place of a folded text."""


def closed(text: str) -> str:
    """A text with the brackets that an editor closes by itself."""
    opened = ""
    for line in text.splitlines():
        for each in re.sub(r"(^|\s)#.*|\"[^\"]*\"", "", line):
            if each in "[{(":
                opened += {"[": "]", "{": "}", "(": ")"}[each]
            elif each in "]})" and opened:
                opened = opened[:-1]
    return opened[::-1]


def free_spans(node: YamlNode, key: str = "") -> Iterator[range]:
    """Where the author's own texts are."""
    if isinstance(node.children, dict):
        for name, (inner, _, _) in node.children.items():
            yield from free_spans(inner, name)
    elif isinstance(node.children, list):
        for inner in node.children:
            yield from free_spans(inner, key)
    elif key in FREE_TEXT:
        yield range(node.start, node.end)


def offered_words(target: str) -> Iterator[tuple[int, str]]:
    """The words of a mission that an editor must offer, each with its place.

    They are not the author's own texts, and not names that the mission declares further below.
    """
    document = parse_document(target, "target")
    spans = [*free_spans(document.root)]
    own = {name for section in OWN_NAMES for name in document.data.get(section, {})}
    comments = [range(*each.span()) for each in re.finditer(r"(?m)(?<![^\s])#.*$", target)]
    for match in WORD.finditer(target):
        start, word = match.start(), match[0]
        if any(start in span for span in (*spans, *comments)) or target[start - 1].isdigit():
            continue
        declared = re.search(rf"(?m)^\s+{word}:", target[:start])
        if word not in GLUE and (word not in own or declared):
            yield start, word


def refused_words(client: Client, path: Path, target: str, step: int) -> list[str]:
    """The words of a mission that are not offered where it is written from its begin on."""
    refused = []
    for start, word in [*offered_words(target)][::step]:
        before = target[:start]
        line = before.rpartition("\n")[2]
        client.put(path, before + closed(before))
        position = {"line": before.count("\n"), "character": len(line)}
        items: list[Json] = client.about("completion", path, position=position)
        if word not in [each["label"] for each in items]:
            refused.append(f"{line}|{word}")
    return refused


def write(path: Path, target: str, step: int = 1) -> None:
    with served() as client:
        client.begin(path.parent)

        assert refused_words(client, path, target, step) == []
        assert client.write(path, target) == []


def test_words_are_offered_in_a_mission_that_is_being_written(tmp_path: Path) -> None:
    write(tmp_path / "drive.yaml", DRIVE.read_text("utf-8"), step=11)


@pytest.mark.thorough
@pytest.mark.timeout(600)
def test_a_small_mission_is_written_with_completions_only(tmp_path: Path) -> None:
    write(tmp_path / "drive.yaml", DRIVE.read_text("utf-8"))


@pytest.mark.thorough
@pytest.mark.timeout(900)
def test_a_mission_of_twelve_phases_is_written_with_completions_only() -> None:
    target = (SEQUENCES / "take_branch.yaml").read_text("utf-8")
    assert len(parse_document(target, "target").data["phases"]) == 12
    write(SEQUENCES / "written.yaml", target)
