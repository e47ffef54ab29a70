"""The style of every page: its colours, and what all pages share."""

from __future__ import annotations

from importlib.resources import files

from pirate_sm.core.palette import CONTRAST_DAY, CONTRAST_NIGHT, DAY, NIGHT, Palette, variables


def page_style() -> str:
    """Return the stylesheet, in the light, dark or contrast that the reader's system asks for.

    Printed paper is white: the attribute ``data-printing`` stands while a page is laid out for it.
    """
    rules = (
        _root(DAY),
        _for("screen and (prefers-color-scheme: dark)", NIGHT),
        _for("(prefers-contrast: more)", CONTRAST_DAY),
        _for(
            "screen and (prefers-color-scheme: dark) and (prefers-contrast: more)", CONTRAST_NIGHT
        ),
        f":root[data-printing] {{ {variables(DAY)} }}",
    )
    shapes = (files("pirate_sm.views.report") / "page" / "page.css").read_text("utf-8")
    return "\n".join((*rules, shapes))


def _root(palette: Palette) -> str:
    return f":root {{ {variables(palette)} }}"


def _for(medium: str, palette: Palette) -> str:
    return f"@media {medium} {{ {_root(palette)} }}"
