"""The input and the result of a layout. Lengths are in pixels, y grows downwards."""

from __future__ import annotations

from dataclasses import dataclass

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Size:
    """The size of a box or label."""

    width: float
    height: float


NOTHING = Size(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class LayoutLink:
    """A link from one box to another.

    Attributes:
        label: The size of its label.
        weight: How much its shortness and straightness count.
    """

    source: int
    target: int
    label: Size = NOTHING
    weight: int = 1


@dataclass(frozen=True, slots=True)
class EdgeRoute:
    """The route of a link.

    Attributes:
        points: From border to border. If two consecutive points have different x, the link curves
            from one vertical to the next; other pieces are straight.
        loop: Whether it leads back to its own box and is drawn beside it.
        label: Upper left corner of the label.
    """

    points: tuple[Point, ...]
    label: Point
    loop: bool = False


@dataclass(frozen=True, slots=True)
class GraphLayout:
    """The positions of all boxes and links; nothing is left of or above (0, 0).

    Attributes:
        corners: Upper left corner of each box.
        routes: One for each link.
    """

    size: Size
    corners: tuple[Point, ...]
    routes: tuple[EdgeRoute, ...]
