"""The tutorial works as it is written: its pages are followed one after the other, in a folder.

A picture that a page has drawn is the one in docs/pictures; `make golden` writes these anew.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest
from followed_page import Command, Edit, apply, steps
from page_reader import Reader, reader
from representative import thorough_but

__all__ = ["reader"]

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
STEPS = sorted((ROOT / "docs" / "tutorial").glob("[0-9]*.md"))


@pytest.mark.parametrize("page", thorough_but(STEPS[:-1], STEPS), ids=lambda page: page.stem)
def test_a_step_works_as_it_is_written(page: Path, reader: Reader) -> None:
    for earlier in STEPS[: STEPS.index(page)]:
        for step in steps(earlier.read_text("utf-8")):
            if isinstance(step, Edit):
                apply(step, reader.folder)

    for step in steps(page.read_text("utf-8")):
        reader.follow(step)


@pytest.mark.parametrize("page", STEPS, ids=lambda page: page.stem)
def test_a_picture_that_a_step_draws_is_the_one_that_it_shows(page: Path, reader: Reader) -> None:
    for earlier in STEPS[: STEPS.index(page) + 1]:
        for step in steps(earlier.read_text("utf-8")):
            if isinstance(step, Edit):
                apply(step, reader.folder)
            elif earlier == page and step.line.startswith("pirate graph "):
                reader.follow(step)

    for drawing in reader.folder.glob("*.svg"):
        stored = PICTURES / drawing.name
        if os.environ.get("GOLDEN") == "write":
            shutil.copy(drawing, stored)
        assert drawing.read_text("utf-8") == stored.read_text("utf-8")
        assert f"(../pictures/{drawing.name})" in page.read_text("utf-8")


def test_the_tutorial_has_six_steps_that_all_run_something() -> None:
    assert len(STEPS) == 6
    for page in STEPS:
        assert any(isinstance(step, Command) for step in steps(page.read_text("utf-8")))
