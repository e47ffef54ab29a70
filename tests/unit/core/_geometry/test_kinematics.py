from __future__ import annotations

from itertools import pairwise
from math import asin, cos, dist, isnan, nan, pi, remainder, sin, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._geometry.chain import Chain, Pose
from pirate_sm.running.recording.viewers.transforms import link_poses

LENGTHS = (0.11, 0.09, 0.13, 0.09, 0.1)
CHAIN = Chain(LENGTHS, (1, -1, 1, -1, 1, -1))
ANGLES = st.tuples(*[st.floats(-2.0, 2.0)] * 6)
POSES = st.builds(Pose, st.floats(-1, 1), st.floats(-1, 1), st.floats(-pi, pi))
WHEELS = st.integers(0, 5)


@given(ANGLES, WHEELS, POSES)
def test_links_keep_their_lengths(angles: tuple[float, ...], first: int, pose: Pose) -> None:
    places = CHAIN.places(angles, first, pose)

    assert [dist(*pair) for pair in pairwise(places)] == pytest.approx(LENGTHS)


@given(ANGLES, WHEELS, POSES)
def test_the_angles_between_the_links_are_those_of_the_joints(
    angles: tuple[float, ...], first: int, pose: Pose
) -> None:
    poses = link_poses(CHAIN.places(angles, first, pose))

    for joint, (ahead, behind) in enumerate(pairwise(poses), start=1):
        turned = behind.heading_rad - ahead.heading_rad - angles[joint]
        assert remainder(turned, 2 * pi) == pytest.approx(0.0, abs=1e-9)


@given(ANGLES, st.integers(0, 4), POSES)
def test_the_link_behind_a_wheel_has_the_pose_that_it_was_given(
    angles: tuple[float, ...], first: int, pose: Pose
) -> None:
    found = link_poses(CHAIN.places(angles, first, pose))[first]

    assert found[:2] == pytest.approx(pose[:2])
    turned = remainder(found.heading_rad - pose.heading_rad, 2 * pi)
    assert turned == pytest.approx(0.0, abs=1e-9)


@given(ANGLES)
def test_a_chain_from_its_front_is_the_sum_of_its_links(angles: tuple[float, ...]) -> None:
    x = y = heading = 0.0
    expected = [(x, y)]
    for number, length in enumerate(LENGTHS):
        heading += angles[number] if number else 0.0
        x, y = x - length * cos(heading), y - length * sin(heading)
        expected.append((x, y))

    assert CHAIN.places(angles) == expected


def test_a_negative_angle_turns_the_body_ahead_towards_side_a() -> None:
    ahead, behind, *_ = CHAIN.headings((0.0, -pi / 6, 0.0, 0.0, 0.0, 0.0))

    assert ahead - behind == pytest.approx(pi / 6)


def test_places_beyond_an_unknown_angle_are_unknown() -> None:
    places = CHAIN.places((0.0, 0.1, 0.2, nan, 0.1, 0.0), first=1)

    assert [isnan(x) for x, _ in places] == [False, False, False, False, True, True]


@given(st.floats(-1.0, 1.0), st.floats(0.0, 0.04))
def test_a_part_that_lies_along_the_pipe_has_each_wheel_at_its_wall(
    apex: float, aside: float
) -> None:
    places = CHAIN.places((0.0, apex, 0.0, 0.0, 0.0, 0.0))
    turn = CHAIN.lean(places, (0, 1), aside)

    leaning = CHAIN.places((0.0, apex, 0.0, 0.0, 0.0, 0.0), 0, Pose(0.0, 0.0, turn))

    assert leaning[0][1] - leaning[1][1] == pytest.approx(2 * aside)


def test_a_v_whose_ends_touch_one_wall_lies_level() -> None:
    angles = (0.0, -2 * asin(0.5), 0.0, 0.0, 0.0, 0.0)
    even = Chain((0.1, 0.1), (1, -1, 1))

    turn = even.lean(even.places(angles), (0, 1, 2), 0.025)
    places = even.places(angles, 0, Pose(0.0, 0.0, turn))

    assert places[2] == pytest.approx((-0.1 * sqrt(3), 0.0))
    assert places[1] == pytest.approx((-0.05 * sqrt(3), -0.05))


def test_it_is_unknown_how_a_part_leans_whose_place_is_unknown() -> None:
    assert isnan(CHAIN.lean([(0.0, 0.0), (nan, nan)], (0, 1), 0.03))
