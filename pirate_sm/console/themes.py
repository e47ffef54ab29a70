"""The themes of the console, made of the palettes; a setting is connected here, by its name."""

from __future__ import annotations

import os
from typing import Any

from textual.app import App
from textual.color import Color
from textual.theme import Theme as Textual

from pirate_sm.palette import THEMES, Palette, Theme


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
