"""Lines of text whose styles say what they mean; each kind of view chooses the looks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import isnan

from rich.text import Text

from pirate_sm.core.visible import visible
from pirate_sm.views.showing import roles
from pirate_sm.views.showing.roles import ACCENT, BAD, GOOD, MUTED, STRONG, WARN

__all__ = ["ACCENT", "BAD", "FLAG", "GOOD", "MUTED", "STRONG", "WARN", "Part", "fitted", "line"]

FLAG = "flag"
"""A word that stands out: ``flag`` alone, or one of ``flag.good``, ``flag.bad`` and so on."""

ON_A_TERMINAL: Mapping[str, str] = {
    **roles.ON_A_TERMINAL,
    FLAG: "bold reverse",
    **{
        f"{FLAG}.{role}": f"bold reverse {roles.ON_A_TERMINAL[role]}"
        for role in (GOOD, WARN, BAD, ACCENT)
    },
}
"""How each of them looks in the colours that every terminal has."""

Part = str | tuple[str, str]


def line(*parts: Part) -> Text:
    """Return one line; what a reader could not see is written out."""
    shown = (
        visible(each) if isinstance(each, str) else (visible(each[0]), each[1]) for each in parts
    )
    return Text.assemble(*shown, no_wrap=True, end="")


STALE = "┄"
"""Before a value that was once so and that nothing shows to be so now."""


def ago(age_s: float) -> str:
    """Return an age in few characters, in its largest unit; empty for NaN."""
    if isnan(age_s):
        return ""
    units = ((86400, "d"), (3600, "h"), (60, "m"), (1, "s"))
    size, unit = next((each for each in units if age_s >= each[0]), units[-1])
    return f"{int(age_s / size)}{unit}"


def fitted(text: Text, width: int) -> Text:
    """Return the line cut or filled to a width."""
    text = text.copy()
    text.truncate(width, overflow="ellipsis", pad=True)
    return text


def flowed(cells: Iterable[Text], width: int, indent: str = "") -> list[Text]:
    """Return cells one after the other, in lines of a width; blanks at the end do not count."""
    lines = [line(indent)]
    for cell in cells:
        if len(lines[-1]) + len(cell) > width + 2 and len(lines[-1]) > len(indent):
            lines.append(line(indent))
        lines[-1].append_text(cell)
    for each in lines:
        each.rstrip()
    return lines


def in_columns(cells: Sequence[Text], width: int, count: int) -> list[Text]:
    """Return the cells in columns of one width, to be read downwards."""
    rows = -(-len(cells) // count)
    return [
        Text("", no_wrap=True, end="").join(
            fitted(each, width // count) for each in cells[row::rows]
        )
        for row in range(rows)
    ]
