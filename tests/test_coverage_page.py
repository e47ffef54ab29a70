"""The page on coverage: its example does what it says."""

from __future__ import annotations

import pytest
from followed_page import steps
from page_reader import ROOT, Reader, reader

__all__ = ["reader"]


@pytest.mark.thorough
@pytest.mark.timeout(300)
def test_the_example_does_what_the_page_says(reader: Reader) -> None:
    for step in steps((ROOT / "docs" / "coverage.md").read_text("utf-8")):
        reader.follow(step)
