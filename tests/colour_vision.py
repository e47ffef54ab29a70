"""How colours look: their contrast, and how far apart they are for people who see fewer of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

Rgb = tuple[float, float, float]
"""Red, green, blue, 0 to 1, linear in light."""

TEXT, GRAPHICS = 4.5, 3.0
"""Least contrast [WCAG 2.2, 1.4.3 and 1.4.11, level AA]."""

VISIONS: dict[str, tuple[Rgb, Rgb, Rgb]] = {
    "usual": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "protanopia": (
        (0.152286, 1.052583, -0.204868),
        (0.114503, 0.786281, 0.099216),
        (-0.003882, -0.048116, 1.051998),
    ),
    "deuteranopia": (
        (0.367322, 0.860646, -0.227968),
        (0.280085, 0.672501, 0.047413),
        (-0.011820, 0.042940, 0.968881),
    ),
    "tritanopia": (
        (1.255528, -0.076749, -0.178779),
        (-0.078411, 0.930809, 0.147602),
        (0.004733, 0.691367, 0.303900),
    ),
}
"""What somebody sees of linear light [Machado, Oliveira, Fernandes 2009, severity 1.0]."""


def linear(colour: str) -> Rgb:
    """The light of ``#rrggbb`` [IEC 61966-2-1]."""
    parts = (int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5))
    red, green, blue = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts)
    return red, green, blue


def luminance(colour: str) -> float:
    """Relative luminance [WCAG 2.2]."""
    red, green, blue = linear(colour)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: str, other: str) -> float:
    """Contrast ratio, 1 to 21 [WCAG 2.2]."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def seen(colour: str, vision: str) -> Rgb:
    """The colour as somebody sees it, in OKLab [Ottosson 2020]: lightness and two opponents."""
    light = linear(colour)
    r, g, b = (
        min(1.0, max(0.0, sum(m * c for m, c in zip(row, light, strict=True))))
        for row in VISIONS[vision]
    )
    long = (0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b) ** (1 / 3)
    middle = (0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b) ** (1 / 3)
    short = (0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b) ** (1 / 3)
    return (
        0.2104542553 * long + 0.7936177850 * middle - 0.0040720468 * short,
        1.9779984951 * long - 2.4285922050 * middle + 0.4505937099 * short,
        0.0259040371 * long + 0.7827717662 * middle - 0.8086757660 * short,
    )


def apart(one: str, other: str, vision: str) -> float:
    """How different two colours look, as a distance in OKLab; black and white are 1 apart."""
    pairs = zip(seen(one, vision), seen(other, vision), strict=True)
    return sum((a - b) ** 2 for a, b in pairs) ** 0.5


def nearest(colours: Sequence[str], visions: Iterable[str] = VISIONS) -> tuple[float, str]:
    """The distance of the two colours that look most alike to anybody, and which they are."""
    return min(
        (apart(one, other, vision), f"{one} and {other} in {vision}")
        for vision in visions
        for one, other in combinations(colours, 2)
    )
