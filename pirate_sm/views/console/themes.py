"""The themes of the console, made of the palettes, and styled lines in their colours."""

from __future__ import annotations

import os
from typing import Any

from rich.text import Text
from textual.app import App
from textual.color import Color
from textual.content import Content, Span
from textual.theme import Theme as Textual

from pirate_sm.core.palette import THEMES, Palette, Theme
from pirate_sm.views.showing import text_styles as styled
from pirate_sm.views.showing.text_styles import ACCENT, BAD, FLAG, GOOD, MUTED, STRONG, WARN, Part


def wear(app: App[Any], name: Theme) -> None:
    """Give the app all themes, and choose one."""
    for each, palette in THEMES.items():
        app.register_theme(_textual(each, palette, plain=app.no_color))
    app.theme = name


def next_theme(app: App[Any]) -> None:
    """Choose the theme after the present one, and say its name."""
    names = list(THEMES)
    app.theme = names[(names.index(app.theme) + 1) % len(names)]  # type: ignore[arg-type]
    app.clear_notifications()
    app.notify(f"theme {app.theme}", timeout=2)


def no_colour() -> dict[str, bool]:
    """Return the options of an app that is to have no colours, as ``NO_COLOR`` asks [no-color.org].

    Textual by itself would make them grey.
    """
    if os.environ.get("NO_COLOR") == "":  # the same as if it were not set
        del os.environ["NO_COLOR"]
    return {"ansi_color": True} if "NO_COLOR" in os.environ else {}


def _textual(name: str, palette: Palette, *, plain: bool) -> Textual:
    """Return the theme of the library with these colours; ``plain``: they will be left out."""
    return Textual(
        name,
        primary=palette["path"],
        secondary=palette["fault"],
        accent=palette["path"],
        success=palette["good"],
        warning=palette["late"],
        error=palette["bad"],
        foreground=palette["ink"],
        background=palette["ground"],
        surface=palette["paper"],
        panel=palette["box"],
        dark=Color.parse(palette["paper"]).brightness < 0.5,
        variables={
            "soft": palette["soft"],
            "line": palette["line"],
            "on-colour": palette["paper"],
            "text-muted": palette["soft"],
            "text-success": palette["good"],
            "text-warning": palette["late"],
            "text-error": palette["bad"],
            "block-cursor-foreground": palette["ink"],
            "block-cursor-background": palette["path_box"],
            "block-cursor-text-style": "bold underline" if plain else "bold",
            "scrollbar": palette["line"],
            "scrollbar-background": palette["ground"],
            "footer-key-foreground": palette["path"],
            "footer-description-foreground": palette["ink"],
            "footer-background": palette["box"],
        },
    )


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
