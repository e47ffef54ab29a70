"""The page of all codes says what the catalogue says. `make golden` writes its table anew."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from pirate_sm.checking import catalogue

PAGE = Path(__file__).parents[2] / "docs" / "checks.md"
HEADING = "## Every code\n"


def table() -> Iterator[str]:
    yield "Severity is what a code usually has; ✓ marks what a comment can allow.\n"
    for group in catalogue.groups():
        yield f"\n### {group.group}\n\n{group.about}\n"
        yield f"Decided by {group.decided_by}. Not decided: {group.not_decided}.\n\n"
        yield "| code | severity | | what is wrong |\n|---|---|---|---|\n"
        for code, entry in group.codes.items():
            mark = "✓" if code in catalogue.allowable() else ""
            title = entry.title.replace("|", "\\|")
            yield f"| `{code}` | {entry.severity} | {mark} | {title} |\n"


def test_the_page_lists_every_code() -> None:
    text = PAGE.read_text("utf-8")
    by_hand, heading, _ = text.partition(HEADING)
    wanted = f"{by_hand}{heading}\n{''.join(table())}"
    if os.environ.get("GOLDEN") == "write":
        PAGE.write_text(wanted, encoding="utf-8")
        text = wanted

    assert heading
    assert text == wanted
