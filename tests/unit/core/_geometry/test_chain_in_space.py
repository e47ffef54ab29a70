"""A chain in space keeps its links and its joints, whatever its roll joint does."""

from __future__ import annotations

from itertools import pairwise
from math import acos, atan2, isnan, nan, pi
from random import Random

import pytest

from pirate_sm.core._geometry.chain import Chain, ChainInSpace, in_space
from pirate_sm.core._geometry.space import DRAWING, Frame, Vector, between, dot

LENGTHS = (0.09, 0.098, 0.102, 0.098, 0.09)
CHAIN = Chain(LENGTHS, (1, -1, 1, -1, 1, -1))
LINK = 2


def some_frame(chance: Random) -> Frame:
    frame = DRAWING
    for _ in range(3):
        frame = frame.rolled(chance.uniform(-pi, pi)).turned(chance.uniform(-pi, pi))
    return frame._replace(origin=(chance.random(), chance.random(), chance.random()))


def laid(seed: int, wheel: int) -> tuple[tuple[float, ...], float, Frame, ChainInSpace]:
    chance = Random(seed)
    angles = tuple(chance.uniform(-1.5, 1.5) for _ in range(6))
    roll_rad, frame = chance.uniform(-pi, pi), some_frame(chance)
    places = CHAIN.places(angles, wheel)
    return (
        angles,
        roll_rad,
        frame,
        in_space(places, frame, wheel=wheel, link=LINK, roll_rad=roll_rad),
    )


def angle_between(one: Vector, other: Vector) -> float:
    product = dot(one, other) / (dot(one, one) * dot(other, other)) ** 0.5
    return acos(max(-1.0, min(1.0, product)))


@pytest.mark.parametrize("wheel", [0, 3])
@pytest.mark.parametrize("seed", range(20))
def test_links_and_joints_are_kept(seed: int, wheel: int) -> None:
    angles, _, _, chain = laid(seed, wheel)
    links = [between(behind, ahead) for ahead, behind in pairwise(chain.points)]
    assert [dot(link, link) ** 0.5 for link in links] == pytest.approx(LENGTHS)
    bends = [angle_between(one, other) for one, other in pairwise(links)]
    assert bends == pytest.approx([abs(angle) for angle in angles[1:5]], abs=1e-6)


@pytest.mark.parametrize("wheel", [0, 3])
@pytest.mark.parametrize("seed", range(20))
def test_each_part_lies_in_its_plane_and_the_front_is_rolled_against_the_rear(
    seed: int, wheel: int
) -> None:
    _, roll_rad, frame, chain = laid(seed, wheel)
    assert (chain.front if wheel == 0 else chain.rear) == frame
    for each, point in enumerate(chain.points):
        plane = chain.front if each <= LINK else chain.rear
        away = between(chain.points[LINK], point)
        assert dot(away, plane.normal) == pytest.approx(0.0, abs=1e-9)
    along = between(chain.points[LINK + 1], chain.points[LINK])
    heading = atan2(dot(along, chain.rear.side), dot(along, chain.rear.ahead))
    rolled = chain.rear.turned(heading).rolled(roll_rad)
    assert chain.front.normal == pytest.approx(rolled.normal)


def test_without_a_roll_joint_the_chain_is_flat() -> None:
    places = CHAIN.places((0.0, 0.5, -0.4, 0.3, 0.2, 0.0))
    chain = in_space(places, DRAWING, wheel=0, link=-1, roll_rad=nan)
    assert chain.points == tuple((x, y, 0.0) for x, y in places)


@pytest.mark.parametrize(("wheel", "unknown"), [(0, {4, 5}), (3, {0, 1})])
def test_an_unknown_roll_leaves_the_own_part_and_the_link_between(wheel, unknown) -> None:
    places = CHAIN.places((0.0, 0.5, -0.4, 0.3, 0.2, 0.0), wheel)
    chain = in_space(places, DRAWING, wheel=wheel, link=LINK, roll_rad=nan)
    assert {n for n, point in enumerate(chain.points) if isnan(point[1])} == unknown
