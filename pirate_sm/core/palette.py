"""The colours of everything that is shown: pages, drawings, plots, the console, terminals.

A role has one name in all palettes. Okabe and Ito chose eight colours that people with any kind of
colour vision tell apart (https://jfly.uni-koeln.de/color/, 2008). On white or dark paper not all of
them have the contrast that text needs (4.5) or graphics (3) [WCAG 2.2, level AA], so ours have
their hues and other lightnesses, found by trying many against both [decided]. A test computes the
contrasts and how far apart the colours look in each kind of colour vision.

No difference is shown by colour alone: beside it stands a sign, a word, a dash or a shape.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, TypeAlias

Palette: TypeAlias = Mapping[str, str]
"""A colour, ``#rrggbb``, for each role."""

Theme: TypeAlias = Literal["dark", "light", "contrast", "contrast_light", "okabe_ito"]
"""Names of the console's themes."""

USUAL: Theme = "dark"


def _palette(text: str) -> dict[str, str]:
    """Return the colours in a text of names, each followed by its colour."""
    words = text.split()
    return dict(zip(words[::2], words[1::2], strict=True))


DAY: Palette = _palette(
    "paper #ffffff  ground #f4f6f8  box #f6f8fa  ink #1f2328  soft #59636e"
    " faint #b5bdc6  grid #e2e6ea  border #d0d7de  line #6e7781"
    " good #00785e  good_box #e3f5f0  bad #902812  bad_box #fbebe6"
    " late #995b08  late_box #fff3d6  path #104b99  path_box #ddeaff  fault #713965"
    " bore #eef3f7  wall #59636e  body #b8cbe0  held #104b99  touch #902812  drive #995b08"
    " light #ffc800"
    " tint0 #ddeaff  tint1 #e3f5f0  tint2 #fff3d6  tint3 #f3e6f0  tint4 #fbe3da  tint5 #e8ebee"
    " curve0 #0261e7  curve1 #772403  curve2 #086559  curve3 #b7089f"
    " curve4 #976713  curve5 #3b9ad8  curve6 #b58e00  curve7 #838383"
)
NIGHT: Palette = _palette(
    "paper #151b23  ground #0d1117  box #1a2029  ink #e6edf3  soft #9aa4af"
    " faint #4b545e  grid #2a313a  border #30363d  line #8b949e"
    " good #6edec5  good_box #10302a  bad #ff6a33  bad_box #2a1209"
    " late #f4c521  late_box #2b2510  path #5b9dff  path_box #10294a  fault #c5769d"
    " bore #1c242e  wall #8b949e  body #40566e  held #5b9dff  touch #ff6a33  drive #f4c521"
    " light #ffd65a"
    " tint0 #10294a  tint1 #10302a  tint2 #2b2510  tint3 #331c2b  tint4 #3a1a0e  tint5 #2a313a"
    " curve0 #3289fc  curve1 #f99519  curve2 #b4f7e7  curve3 #ef10c0"
    " curve4 #9f7d54  curve5 #80c4ff  curve6 #f7e36f  curve7 #b6ae9f"
)
CONTRAST_DAY: Palette = {
    **DAY,
    **_palette(
        "ground #ffffff  box #ffffff  ink #000000  soft #333333  faint #767676"
        " grid #949494  border #000000  line #000000  wall #000000"
        " good #065b4d  bad #380f02  late #4d3100  path #052c5d  fault #8f0093"
        " held #052c5d  touch #380f02  drive #4d3100"
        " curve0 #0b2742  curve1 #a66515  curve2 #346a62  curve3 #dd0f9d"
        " curve4 #452605  curve5 #284561  curve6 #5c4701  curve7 #11110d"
    ),
}
CONTRAST_NIGHT: Palette = {
    **NIGHT,
    **_palette(
        "paper #000000  ground #000000  box #000000  ink #ffffff  soft #d0d0d0  faint #949494"
        " grid #767676  border #ffffff  line #ffffff  wall #ffffff  bore #000000"
        " good #a1fded  bad #fbc18e  late #bea44b  path #89b6fe  fault #fe7ab3"
        " held #89b6fe  touch #fbc18e  drive #bea44b"
        " curve0 #3184e1  curve1 #bd7129  curve2 #aad7b2  curve3 #f3219f"
        " curve4 #ef9538  curve5 #37b6ef  curve6 #f9d345  curve7 #f3f3f3"
    ),
}
OKABE_ITO: Palette = {
    **NIGHT,
    **_palette(
        "paper #000000  ground #000000  box #1a1a1a  ink #ffffff  soft #c0c0c0  wall #b0b0b0"
        " good_box #00261c  bad_box #2b0f00  late_box #2b1c00"
        " good #009e73  bad #d55e00  late #e69f00  path #56b4e9  fault #cc79a7"
        " held #56b4e9  touch #d55e00  drive #e69f00"
    ),
}
"""The colours as published, on black."""

EITHER: Palette = _palette(
    "good #709d97  bad #b23e17  late #c28717  path #1e5ccf  fault #7f547d"
    " curve0 #0b66ed  curve1 #cd8529  curve2 #3e6b65  curve3 #c23cb1"
    " curve4 #9b7750  curve5 #3797f8  curve6 #75620f  curve7 #949494"
)
"""For lines that may stand on white or on black, as in other programs."""

CURVES = tuple(f"curve{number}" for number in range(8))
"""The roles of curves, in the order in which they are used."""

THEMES: Mapping[Theme, Palette] = {
    "dark": NIGHT,
    "light": DAY,
    "contrast": CONTRAST_NIGHT,
    "contrast_light": CONTRAST_DAY,
    "okabe_ito": OKABE_ITO,
}
"""The palette of each theme of the console."""
