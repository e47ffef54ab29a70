"""The look of drawings in light and dark mode.

No difference is shown by colour alone: kinds of edges differ in their dashes, ends in their signs,
and visited parts have numbers and thicker lines.
"""

from __future__ import annotations

from pirate_sm.palette import DAY, NIGHT, Palette

FONT = 'ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, "Liberation Mono", monospace'


_SHAPES = f"""
.drawing text {{ font-family: {FONT} }}
.drawing .title {{ font-size: 13px; font-weight: bold }}
.drawing .text {{ font-size: 12px }}
.drawing .label {{ font-size: 11px }}
.drawing path {{ fill: none; stroke-linecap: round; stroke-linejoin: round }}
.drawing .line {{ stroke-width: 1.3 }}
.drawing .within .line {{ stroke-dasharray: 7 4 }}
.drawing .failure .line {{ stroke-dasharray: 1 4; stroke-width: 1.8 }}
.drawing .fault .line {{ stroke-dasharray: 9 4 1 4 }}
.drawing .taken .line {{ stroke-width: 3.2 }}
.drawing .taken .chosen {{ font-weight: bold }}
.drawing .box {{ stroke-width: 1.2 }}
.drawing .sign {{ stroke-width: 2 }}
.drawing .anywhere .box, .drawing .frame {{ stroke-dasharray: 4 3 }}
.drawing .visited .box {{ stroke-width: 2.8 }}
.drawing .ring {{ stroke-width: 1.6; fill: none }}
.drawing .number {{ font-size: 11px; font-weight: bold }}
"""

_COLOURS = """
.drawing .paper {{ fill: {paper} }}
.drawing text {{ fill: {ink} }}
.drawing .soft {{ fill: {soft} }}
.drawing .frame {{ fill: none; stroke: {line} }}
.drawing .box {{ fill: {box}; stroke: {line} }}
.drawing .initial .box {{ fill: {ink}; stroke: {ink} }}
.drawing .anywhere .box {{ fill: {paper} }}
.drawing .succeed .box {{ fill: {good_box}; stroke: {good} }}
.drawing .succeed .sign {{ stroke: {good} }}
.drawing .fail .box {{ fill: {bad_box}; stroke: {bad} }}
.drawing .fail .sign {{ stroke: {bad} }}
.drawing .visited .box {{ stroke: {path} }}
.drawing .phase.visited .box, .drawing .state.visited .box {{ fill: {path_box} }}
.drawing .ring {{ stroke: {path} }}
.drawing .badge {{ fill: {path} }}
.drawing .number {{ fill: {paper} }}
.drawing .line {{ stroke: {line} }}
.drawing .head {{ fill: {line} }}
.drawing .within .line {{ stroke: {late} }}
.drawing .within .head {{ fill: {late} }}
.drawing .failure .line {{ stroke: {bad} }}
.drawing .failure .head {{ fill: {bad} }}
.drawing .fault .line {{ stroke: {fault} }}
.drawing .fault .head {{ fill: {fault} }}
.drawing .taken .line {{ stroke: {path} }}
.drawing .taken .head {{ fill: {path} }}
"""


def stylesheet(style: str = "", more: str = "") -> str:
    """Return the style of every drawing, in the light or dark mode of the reader's system.

    Every rule is limited to ``.drawing``, so that it can be part of a larger page.

    Args:
        style: Rules of one kind of drawing.
        more: Its rules for colours, with names of the palette in braces.
    """
    day, night = (colours(palette) + more.format(**palette) for palette in (DAY, NIGHT))
    return f"{_SHAPES}{style}{day}@media screen and (prefers-color-scheme: dark) {{{night}}}\n"


def colours(palette: Palette) -> str:
    """Return the rules for the colours of the palette."""
    return _COLOURS.format(**palette)
