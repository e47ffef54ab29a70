"""No file makes an answer fail, and what is answered is inside its text."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import chdir
from pathlib import Path
from typing import Any

import pytest

from benchmarks.mistakes import FILES, ODD, cases, written
from tests.mistakes.test_mistakes import SAMPLE, mistake
from tests.representative import thorough_but

from .client import Client, Json, served
from .test_findings_while_typing import FEW, ROOT, SHIPPED

WORD = re.compile(r"\w+")
WORDS = 12
"""Of each file so many are pointed at."""


def lengths(text: str) -> list[int]:
    """The lengths of the lines, in units of UTF-16, as the protocol has lines."""
    return [len(line.encode("utf-16-le")) // 2 for line in re.split(r"\r\n|\r|\n", text)]


def points(text: str) -> Iterator[Json]:
    """Some places of words."""
    found = [*WORD.finditer(text)]
    for match in found[:: max(len(found) // WORDS, 1)]:
        before = re.split(r"\r\n|\r|\n", text[: match.start()])
        yield {"line": len(before) - 1, "character": len(before[-1].encode("utf-16-le")) // 2}


def places_in(answer: Any) -> Iterator[Json]:
    """All positions in an answer."""
    if isinstance(answer, dict):
        if answer.keys() == {"line", "character"}:
            yield answer
        for each in answer.values():
            yield from places_in(each)
    elif isinstance(answer, list):
        for each in answer:
            yield from places_in(each)


def ask_everything(client: Client, path: Path, text: str) -> None:
    client.write(path, text)
    whole = {"start": {"line": 0, "character": 0}, "end": {"line": 10**6, "character": 0}}
    answers = [client.about("inlayHint", path, range=whole)]
    answers += [client.about("hover", path, position=each) for each in points(text)]
    data = client.about("semanticTokens/full", path)["data"]

    ends = lengths(text)
    for each in places_in(answers):
        assert each["character"] <= ends[each["line"]]
    line = character = 0
    for below, right, length, _, _ in zip(*[iter(data)] * 5, strict=True):
        assert below >= 0
        assert right > 0 or below or (line, character) == (0, 0)
        line, character = line + below, right if below else character + right
        assert character + length <= ends[line]
    client.close(path)


@pytest.mark.parametrize("name", thorough_but(FEW, SHIPPED))
def test_a_shipped_file(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    with served() as client:
        client.begin(ROOT)

        ask_everything(client, ROOT / name, (ROOT / name).read_text("utf-8"))


def ask_of_mistakes(found: list[Any], folder: Path) -> None:
    with chdir(folder), served() as client:
        client.begin(folder)
        for number, case in enumerate(found):
            inner = folder / str(number)
            inner.mkdir()
            with chdir(inner):
                written(case)
            path = inner / case.path
            if path.suffix in (".yaml", ".yml"):
                ask_everything(client, path, path.read_text("utf-8", errors="replace"))


@pytest.mark.thorough
@pytest.mark.timeout(900)
def test_mistakes(tmp_path: Path) -> None:
    ask_of_mistakes([*map(mistake, SAMPLE)], tmp_path)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("file", [*FILES, ODD])
def test_all_mistakes(file: str, tmp_path: Path) -> None:
    ask_of_mistakes([*cases([file])], tmp_path)


@pytest.mark.thorough
@pytest.mark.timeout(600)
def test_every_begin_of_a_mission() -> None:
    """A mission that is being written is completed and explained at its end."""
    text = (ROOT / "sequences" / "mitre_bend.yaml").read_text("utf-8")
    path = ROOT / "sequences" / "begun.yaml"
    with served() as client:
        client.begin(ROOT)
        for end in range(0, len(text), 7):
            begun = text[:end]
            client.put(path, begun)
            last = begun.split("\n")
            position = {"line": len(last) - 1, "character": len(last[-1])}
            client.about("completion", path, position=position)
            client.about("hover", path, position=position)
