"""Styled lines in the colours of Textual's theme."""

from __future__ import annotations

from rich.text import Text
from textual.content import Content, Span

from pirate_sm.showing import text_styles as styled
from pirate_sm.showing.text_styles import ACCENT, BAD, FLAG, GOOD, MUTED, STRONG, WARN, Part

_THEMED = {
    MUTED: "$soft",
    STRONG: "bold",
    GOOD: "$text-success",
    WARN: "$text-warning",
    BAD: "$text-error",
    ACCENT: "$accent",
    FLAG: "bold reverse",
}
_THEMED |= {f"{FLAG}.{role}": f"bold reverse {_THEMED[role]}" for role in (GOOD, WARN, BAD, ACCENT)}


def themed(text: Text) -> Content:
    """Return the text as Textual content."""
    spans = [
        Span(each.start, each.end, _THEMED[style])
        for each in text.spans
        if (style := str(each.style))
    ]
    return Content(text.plain, spans)


def line(*parts: Part) -> Content:
    """Return one line of these parts."""
    return themed(styled.line(*parts))
