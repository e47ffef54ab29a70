"""What is laid out, and what comes of it. Lengths are in pixels, y grows downwards."""

from __future__ import annotations

from dataclasses import dataclass

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Size:
    """How much room something needs."""

    width: float
    height: float


NOTHING = Size(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class LayoutLink:
    """Leads from one box to another.

    Attributes:
        label: The room that its label needs.
        weight: How much it matters that it is short and straight.
    """

    source: int
    target: int
    label: Size = NOTHING
    weight: int = 1


@dataclass(frozen=True, slots=True)
class EdgeRoute:
    """The way of a link.

    Attributes:
        points: From border to border. Where two follow each other with different x, the link
            swings from one vertical to the next; other pieces are straight.
        loop: Whether it leads back to its own box, beside which it then stands.
        label: Left upper corner of the label.
    """

    points: tuple[Point, ...]
    label: Point
    loop: bool = False


@dataclass(frozen=True, slots=True)
class GraphLayout:
    """Where everything stands; nothing lies left of or above (0, 0).

    Attributes:
        corners: Left upper corner of each box.
        routes: One for each link.
    """

    size: Size
    corners: tuple[Point, ...]
    routes: tuple[EdgeRoute, ...]
