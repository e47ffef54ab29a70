"""No text on the way to another one stops the server, or what it shows afterwards."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from .client import Client, served
from .test_findings_while_typing import ROOT, SHIPPED, said_by_the_check, shown_by

_TYPED = [
    "\n",
    " ",
    ":",
    "{",
    "}",
    "[",
    "]",
    "-",
    "'",
    "🤖",
    "\u2028",
    "go: ",
    "$",
    "&a",
    "*a",
    "\t",
]
_QUESTIONS = ("documentSymbol", "foldingRange", "completion", "definition", "rename", "codeAction")


def edited(text: str, draw: random.Random) -> str:
    """A text with something typed, deleted or moved."""
    start = draw.randrange(len(text) + 1)
    end = min(len(text), start + draw.randrange(12))
    match draw.randrange(4):
        case 0:
            return text[:start] + draw.choice(_TYPED) + text[start:]
        case 1:
            return text[:start] + text[end:]
        case 2:
            return text[:start] + text[start:end] * 2 + text[end:]
    return text[:end] + text[start:end][::-1] + text[end:]


def ask(client: Client, path: Path, text: str, draw: random.Random) -> None:
    """Ask anything anywhere; an error as the answer fails the test."""
    start = {"line": draw.randrange(text.count("\n") + 2), "character": draw.randrange(40)}
    more = {"position": start, "newName": draw.choice(["other", "2 x", ""])}
    question = draw.choice(_QUESTIONS)
    if question == "codeAction":
        more = {"range": {"start": start, "end": start}, "context": {"diagnostics": []}}
    client.about(question, path, **more)


def type_at_random(edits: int, seed: int) -> None:
    """Edit shipped files in turn, and compare with the check when they are as before."""
    draw = random.Random(seed)
    names = [each for each in SHIPPED if each.startswith(("sequences", "panels", "cameras"))]
    with served() as client:
        client.begin(ROOT)
        while edits > 0:
            path = ROOT / draw.choice(names)
            text = path.read_text("utf-8")
            client.write(path, text)
            for _ in range(20):
                text = edited(text, draw)
                client.put(path, text)
                if draw.randrange(4) == 0:
                    ask(client, path, text, draw)
            edits -= 20
            client.write(path, path.read_text("utf-8"))
            assert shown_by(client) == said_by_the_check(path)
            client.close(path)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(3))
def test_twenty_edits(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    type_at_random(20, seed)
