"""No text on the way to another one stops the server, or what it shows afterwards."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from benchmarks.editor import QUESTIONS, type_at_random

from .client import served
from .test_findings_while_typing import ROOT, SHIPPED, said_by_the_check, shown_by

NAMES = [each for each in SHIPPED if each.startswith(("sequences", "panels", "cameras"))]


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(5))
def test_forty_edits(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    with served() as client:
        able = client.begin(ROOT)
        can = {question for question, name in QUESTIONS.items() if able.get(name)}

        def settled(path: Path) -> None:
            assert shown_by(client) == said_by_the_check(path)

        type_at_random(client, NAMES, 40, random.Random(seed), can, settled)
