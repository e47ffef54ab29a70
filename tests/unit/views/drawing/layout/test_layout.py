from __future__ import annotations

from itertools import combinations, pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pirate_sm.views.drawing.svg.layered import Segment, Vertex, abscissae, layered
from pirate_sm.views.drawing.svg.ranks import (
    NOTHING,
    GraphLayout,
    LayoutLink,
    Size,
    ordered,
    ranks,
    turned,
)

from ..geometry import along, inside, overlap, rectangle

BOX = Size(60, 30)
LABEL = Size(40, 14)

sizes = st.builds(Size, st.integers(20, 300), st.integers(14, 200))
labels = st.just(NOTHING) | st.builds(Size, st.integers(5, 200), st.integers(14, 60))


@st.composite
def graphs(draw: st.DrawFn) -> tuple[list[Size], list[LayoutLink]]:
    boxes = draw(st.lists(sizes, min_size=1, max_size=9))
    number = st.integers(0, len(boxes) - 1)
    links = st.builds(LayoutLink, number, number, labels, st.sampled_from([1, 8]))
    return boxes, draw(st.lists(links, max_size=18))


@pytest.mark.thorough
@given(graphs())
@settings(max_examples=150, deadline=None)
def test_nothing_lies_on_anything_else(graph: tuple[list[Size], list[LayoutLink]]) -> None:
    boxes, links = graph
    layout = layered(boxes, links)

    places = [rectangle(*each) for each in zip(layout.corners, boxes, strict=True)]
    loops = {link.source for link in links if link.source == link.target}
    assert not any(overlap(*pair) for pair in combinations(places, 2))
    texts = {
        number: rectangle(route.label, link.label)
        for number, (link, route) in enumerate(zip(links, layout.routes, strict=True))
        if link.label != NOTHING and not (route.loop and link.source in loops)
    }
    assert not any(overlap(text, box) for text in texts.values() for box in places)
    assert not any(overlap(*pair) for pair in combinations(texts.values(), 2))
    for number, (link, route) in enumerate(zip(links, layout.routes, strict=True)):
        for point in along(route):
            foreign = (b for n, b in enumerate(places) if n not in {link.source, link.target})
            assert not any(inside(point, box) for box in foreign)
            assert not any(inside(point, text) for n, text in texts.items() if n != number)
    whole = rectangle((0, 0), layout.size)
    for left, top, right, bottom in [*places, *texts.values()]:
        assert left >= -0.01
        assert top >= -0.01
        assert right <= whole[2] + 0.01
        assert bottom <= whole[3] + 0.01


def chain(*links: LayoutLink, count: int = 3) -> GraphLayout:
    return layered([BOX] * count, links)


def test_links_lead_downwards_and_those_that_close_a_circle_upwards() -> None:
    layout = chain(LayoutLink(0, 1), LayoutLink(1, 2), LayoutLink(2, 0))

    assert [y for _, y in layout.corners] == sorted(y for _, y in layout.corners)
    downwards = [route.points[0][1] < route.points[-1][1] for route in layout.routes]
    assert downwards == [True, True, False]


def test_what_only_goes_on_stands_on_one_vertical() -> None:
    layout = chain(LayoutLink(0, 1, LABEL, 8), LayoutLink(1, 2, NOTHING, 8))

    assert len({round(x, 3) for x, _ in layout.corners}) == 1
    assert all(len({x for x, _ in route.points}) == 1 for route in layout.routes)


def test_a_long_link_is_straight_between_its_swings() -> None:
    layout = chain(
        *(LayoutLink(n, n + 1, LABEL, 8) for n in range(4)), LayoutLink(0, 4, LABEL), count=5
    )

    xs = [x for x, _ in layout.routes[-1].points][2:-2]
    assert max(xs) - min(xs) < 1


def test_labels_stand_beside_their_own_link_next_to_its_source() -> None:
    layout = chain(
        LayoutLink(0, 1, LABEL),
        LayoutLink(1, 0, LABEL),
        LayoutLink(0, 2, LABEL),
        LayoutLink(1, 2, LABEL),
    )

    down, up, *_ = layout.routes
    for route in (down, up):
        x, y = route.label
        assert any(x - 10 < at < x for at, _ in route.points)
        assert down.points[0][1] < y < down.points[-1][1]


def test_a_link_to_its_own_box_stands_beside_it() -> None:
    layout = chain(LayoutLink(0, 0, LABEL), LayoutLink(0, 1), count=2)

    loop = layout.routes[0]
    assert loop.loop
    assert all(x >= layout.corners[0][0] + BOX.width for x, _ in loop.points)
    assert loop.label[0] + LABEL.width <= layout.size.width


def test_nothing_gives_an_empty_layout() -> None:
    assert layered([], []) == GraphLayout(Size(0.0, 0.0), (), ())


def test_a_rank_without_anything_stays_empty() -> None:
    boxes = [Vertex(10, 10), Vertex(10, 10)]

    assert abscissae([[0], [], [1]], boxes, [], [], 20) == [0.0, 0.0]


def test_the_same_graph_gives_the_same_layout() -> None:
    links = [
        LayoutLink(0, 1, LABEL),
        LayoutLink(0, 2),
        LayoutLink(1, 3),
        LayoutLink(2, 3, LABEL),
        LayoutLink(3, 0),
    ]

    assert layered([BOX] * 4, links) == layered([BOX] * 4, links)


def test_only_links_that_close_a_circle_are_turned() -> None:
    assert turned(3, [LayoutLink(0, 2), LayoutLink(2, 1), LayoutLink(1, 1)]) == (
        False,
        False,
        False,
    )
    assert turned(3, [LayoutLink(0, 1), LayoutLink(1, 2), LayoutLink(2, 0)]) == (False, False, True)


def test_what_nothing_leads_to_stands_just_above_what_it_leads_to() -> None:
    assert ranks(5, [(0, 1, 1, 1), (1, 2, 1, 1), (2, 3, 1, 1), (4, 3, 1, 1)]) == [0, 1, 2, 3, 2]


def test_crossings_that_need_not_be_are_undone() -> None:
    layers = ordered([[0, 1], [2, 3]], [(0, 3), (1, 2)])

    assert sorted(zip(*layers, strict=True)) == [(0, 3), (1, 2)]


def test_neighbours_keep_their_distance() -> None:
    vertices = [Vertex(10, 10), Vertex(30, 50), Vertex(5, 5), Vertex(5, 5)]
    segments = [Segment(3, each, 0.0, 0.0, 1.0) for each in range(3)]

    x = abscissae([[3], [0, 1, 2]], vertices, segments, [], 20)

    room = [vertices[a].right + 20 + vertices[b].left for a, b in pairwise(range(3))]
    assert all(x[n + 1] - x[n] >= needed - 0.001 for n, needed in enumerate(room))
