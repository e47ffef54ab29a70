"""Lines of text whose styles say what they mean; each kind of view chooses the looks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich.text import Text

from pirate_sm.visible import visible

MUTED, STRONG, GOOD, WARN, BAD, ACCENT = "muted", "bold", "good", "warn", "bad", "accent"

FLAG = "flag"
"""A word that stands out: ``flag`` alone, or one of ``flag.good``, ``flag.bad`` and so on."""

ON_A_TERMINAL: Mapping[str, str] = {
    MUTED: "bright_black",
    STRONG: "bold",
    GOOD: "green",
    WARN: "yellow",
    BAD: "red",
    ACCENT: "cyan",
    FLAG: "bold reverse",
    f"{FLAG}.{GOOD}": "bold reverse green",
    f"{FLAG}.{WARN}": "bold reverse yellow",
    f"{FLAG}.{BAD}": "bold reverse red",
    f"{FLAG}.{ACCENT}": "bold reverse cyan",
}
"""How each of them looks in the colours that every terminal has."""

Part = str | tuple[str, str]


def line(*parts: Part) -> Text:
    """Return one line; what a reader could not see is written out."""
    shown = (
        visible(each) if isinstance(each, str) else (visible(each[0]), each[1]) for each in parts
    )
    return Text.assemble(*shown, no_wrap=True, end="")


def fitted(text: Text, width: int) -> Text:
    """Return the line cut or filled to a width."""
    text = text.copy()
    text.truncate(width, overflow="ellipsis", pad=True)
    return text


def in_columns(cells: Sequence[Text], width: int, count: int) -> list[Text]:
    """Return the cells in columns of one width, to be read downwards."""
    rows = -(-len(cells) // count)
    return [
        Text("", no_wrap=True, end="").join(
            fitted(each, width // count) for each in cells[row::rows]
        )
        for row in range(rows)
    ]
