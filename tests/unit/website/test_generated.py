"""The pages that are made of the program have all of it."""

from __future__ import annotations

import pytest

import pirate_sm
from pirate_sm.cli.entry import COMMANDS
from pirate_sm.core.events import BUILT_IN_FAULTS
from website.generated import MERMAID, pages, with_drawings


@pytest.fixture(scope="module")
def made() -> dict[str, str]:
    return dict(pages())


@pytest.mark.thorough
def test_the_command_line_has_every_command(made: dict[str, str]) -> None:
    text = made["reference/command_line.md"]

    assert [name for name in COMMANDS if f"\n## pirate {name}\n" not in text] == []


def test_every_fault_is_in_the_list(made: dict[str, str]) -> None:
    text = made["reference/faults.md"]

    assert [code for code in BUILT_IN_FAULTS if f"| `{code}` |" not in text] == []
    assert "\n## Of the robot pirate_ii\n" in text


def test_every_public_name_is_in_the_api(made: dict[str, str]) -> None:
    text = made["api/pirate_sm.md"]

    assert [name for name in pirate_sm.__all__ if f"::: pirate_sm.api.{name}\n" not in text] == []


def test_a_page_of_keys_says_which_are_needed(made: dict[str, str]) -> None:
    text = made["reference/keys/mission.md"]

    assert "| `start` | text | The first phase. | needed |" in text
    assert "[Phase](#phase)" in text
    assert "\n## Phase\n" in text


def test_graphs_in_mermaid_become_pictures_that_are_there(made: dict[str, str]) -> None:
    text = "# r\n\n```mermaid\na\n```\n\n```mermaid\nb\n```\n"

    shown = with_drawings(text, "robots/pirate_ii.md")

    assert not MERMAID.search(shown)
    assert "![](pirate_ii_0.svg)" in shown
    assert "![](pirate_ii_1.svg)" in shown
    assert made["robots/pirate_ii_1.svg"].startswith("<svg")


def test_the_decisions_are_listed_with_their_titles(made: dict[str, str]) -> None:
    assert "- 7: [The safe state holds](0007-the-safe-state-holds.md)" in made["decisions/index.md"]
