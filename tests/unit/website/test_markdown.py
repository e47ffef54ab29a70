"""Lists as viewers of repositories read them are lists on the site too."""

from __future__ import annotations

import markdown
import pytest

from website.markdown import for_site


def shown(text: str) -> str:
    """The page as the site's parser makes it, without line breaks."""
    html = markdown.markdown(for_site(text), extensions=["fenced_code", "pymdownx.superfences"])
    return html.replace("\n", "")


def test_code_in_an_item_stays_in_it() -> None:
    html = shown("1. Write:\n\n   ```text\n   a:\n     b: 1\n   ```\n\n2. Run it.\n")

    assert html.count("<ol>") == 1
    assert html.count("<li>") == 2
    assert html.index("b: ") < html.index("</li>")
    assert html.endswith("Run it.</p></li></ol>")


@pytest.mark.parametrize("marker", ["- ", "* ", "1. "])
def test_a_list_right_after_a_paragraph_is_one(marker: str) -> None:
    html = shown(f"These:\n{marker}one\n{marker}two\n")

    assert html.startswith("<p>These:</p>")
    assert html.count("<li>") == 2


def test_a_list_in_a_list_is_one() -> None:
    html = shown("- a\n  - b\n  - c\n- d\n")

    assert html.count("<ul>") == 2
    assert html.count("<li>") == 4


def test_a_line_of_an_item_that_is_not_indented_belongs_to_it() -> None:
    html = shown("- one that is\nlong\n- two\n")

    assert html.count("<li>") == 2
    assert "long" in html.partition("</li>")[0]


@pytest.mark.parametrize(
    "text",
    [
        "A paragraph.\n\n    pirate check\n\nAnother.\n",
        "```yaml\n- a\n  - b\n```\n",
        "| a | b |\n|---|---|\n| - | 1. |\n",
        "# Title\n\n> quoted\n",
    ],
)
def test_what_is_no_list_stays_as_it_is(text: str) -> None:
    assert for_site(text) == text


def test_a_paragraph_after_a_list_is_not_in_it() -> None:
    assert shown("- a\n\nAfter.\n").endswith("</ul><p>After.</p>")
