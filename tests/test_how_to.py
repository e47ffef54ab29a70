"""The guides of docs/how-to work as they are written: each is followed in an empty folder."""

from __future__ import annotations

from pathlib import Path

import pytest
from followed_page import Command, steps
from page_reader import ROOT, Reader, reader

__all__ = ["reader"]

GUIDES = sorted((ROOT / "docs" / "how-to").glob("*.md"))


@pytest.mark.timeout(300)  # some wait for an emulated robot in real time
@pytest.mark.thorough
@pytest.mark.parametrize("page", GUIDES, ids=lambda page: page.stem)
def test_a_guide_works_as_it_is_written(page: Path, reader: Reader) -> None:
    for step in steps(page.read_text("utf-8")):
        reader.follow(step)


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_the_guide_to_a_real_robot_works_in_real_time(reader: Reader) -> None:
    reader.in_real_time = True
    for step in steps((ROOT / "docs" / "how-to" / "real-robot.md").read_text("utf-8")):
        reader.follow(step)


@pytest.mark.parametrize("page", GUIDES, ids=lambda page: page.stem)
def test_a_guide_says_what_it_is_for_and_runs_something(page: Path) -> None:
    text = page.read_text("utf-8")

    assert text.startswith("# How to ")
    assert any(isinstance(step, Command) and step.prints for step in steps(text))
