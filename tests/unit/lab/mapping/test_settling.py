"""What follows for bends from the legs on either side."""

from __future__ import annotations

from math import degrees, inf, pi, radians

import pytest

from pirate_sm.lab.mapping.legs import Bore, Leg, Map, MappedBend, feel_angles, round_elbows


def bent(bend: MappedBend, pitches_deg: tuple[float, float], roll_deg: float = 0.0) -> Map:
    """Two legs of these pitches, and the bend between them as the joints showed it."""
    first, second = (
        Leg(-inf, 0.8, pitches_rad=[radians(pitches_deg[0])]),
        Leg(0.0, inf, pitches_rad=[radians(pitches_deg[1])], bores=[Bore(0.1, 0.2, 0.11)]),
    )
    return Map([first, second], [bend], (0, 0.1), radians(pitches_deg[0]), radians(roll_deg))


@pytest.mark.parametrize("pitches", [(90, 0), (90, 30), (80, -10), (20, -60)])
def test_pitch_gives_the_angle_of_a_bend_that_stands_upright(pitches: tuple[float, float]) -> None:
    made = bent(
        MappedBend(radians(75), -pi / 2), pitches
    )  # side A is on the right; this leads down
    feel_angles(made)
    (bend,) = made.bends
    assert degrees(bend.angle_rad) == pytest.approx(pitches[0] - pitches[1], abs=0.1)
    assert bend.felt


def test_upwards_it_is_the_same() -> None:
    made = bent(MappedBend(radians(63), pi / 2), (0, 88))
    feel_angles(made)
    assert degrees(made.bends[0].angle_rad) == pytest.approx(88, abs=0.1)


def test_backward_it_is_the_same() -> None:
    made = bent(MappedBend(radians(63), pi / 2), (0, 88))
    made.start, made.pitch_rad = (1, 0.1), radians(88)
    made.roll_rad = pi / 2  # what was on the side of the leg behind is above here
    made.bends[0].roll_rad = 0.0
    feel_angles(made)
    assert degrees(made.bends[0].angle_rad) == pytest.approx(88, abs=0.1)


def test_pitch_says_nothing_of_a_bend_that_lies_flat() -> None:
    made = bent(MappedBend(radians(75), 0.0), (0, 3))
    feel_angles(made)
    (bend,) = made.bends
    assert degrees(bend.angle_rad) == pytest.approx(75)
    assert not bend.felt


def test_an_elbow_is_as_long_as_from_its_first_word_to_its_last() -> None:
    # 90 deg with a radius of 165 mm is 259 mm long, of which words leave out half the diameter at
    # each end.
    made = bent(MappedBend(pi / 2, 0.0, extent_m=0.149), (0, 0))
    round_elbows(made)
    assert made.bends[0].radius_m == pytest.approx(0.165, abs=0.001)
    assert made.legs[0].ends_m == pytest.approx(0.8 - 0.055)
    assert made.legs[1].begins_m == pytest.approx(0.055)


def test_a_corner_stays_a_corner() -> None:
    made = bent(MappedBend(pi / 2, 0.0, extent_m=0.012), (0, 0))
    round_elbows(made)
    assert made.bends[0].radius_m == 0.0
    assert made.legs[0].ends_m == 0.8
