"""docs/reference/exit_codes.md has every code of the program. `make golden` writes it anew."""

from __future__ import annotations

import os
from pathlib import Path

from pirate_sm.core.errors import PirateError
from website.generated import EXIT_CODES, exit_codes

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "exit_codes.md"


def test_the_page_has_every_exit_code() -> None:
    if os.environ.get("GOLDEN") == "write":
        PAGE.write_text(exit_codes(), encoding="utf-8")

    assert PAGE.read_text("utf-8") == exit_codes()


def test_every_error_ends_with_a_code_that_has_a_meaning() -> None:
    known = [PirateError]
    for each in known:
        known += each.__subclasses__()

    assert {each.exit_code for each in known} <= EXIT_CODES.keys()
