"""Normal forces of clamped chains, against closed forms and against all equations at once."""

from __future__ import annotations

from math import asin, cos, isnan, nan, pi, radians, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._geometry.chain import ChainLoads, couples_nm, normal_forces_n

LEG_M, MIDDLE_M = 0.090, 0.098
SPAN_M = 0.120 - 0.048
"""Between the axles of wheels on both walls of a pipe of 12 cm."""

LEAN, OBLIQUE = asin(SPAN_M / LEG_M), asin(SPAN_M / MIDDLE_M)
REACH_M, MIDDLE_REACH_M = LEG_M * cos(LEAN), MIDDLE_M * cos(OBLIQUE)

LENGTHS = (LEG_M, LEG_M, MIDDLE_M, LEG_M, LEG_M)
SIDES = (1, -1, 1, -1, 1, -1)
HEADINGS = (LEAN, -LEAN, OBLIQUE, -LEAN, LEAN)
"""The first wheel touches side A: the first link points to side A."""

MASSES = (0.085, 0.150, 0.160, 0.160, 0.150, 0.085)
NO_WHEELS = (0.0,) * 6
LEVEL = (0.0, 0.0)


def forces(
    joints_nm=NO_WHEELS,
    *,
    lengths=LENGTHS,
    headings=HEADINGS,
    drives=NO_WHEELS,
    braked=(False,) * 6,
    gravity=LEVEL,
    sides=SIDES,
    masses=MASSES,
):
    """The normal forces of a chain whose wheel motors give no couple."""
    couples = couples_nm(joints_nm, (0.0,) * len(joints_nm), (0,) * len(joints_nm))
    loads = ChainLoads(headings, couples, drives, braked, gravity)
    return normal_forces_n(lengths, masses, sides, loads)


@pytest.mark.parametrize("torque_nm", [0.1, 0.35, 0.7])
def test_a_v_presses_by_its_torque_over_the_reach_of_a_leg_and_its_apex_twice_so(torque_nm):
    found = forces(
        (0.0, -torque_nm, 0.0),
        lengths=(LEG_M, LEG_M),
        headings=(LEAN, -LEAN),
        drives=(0.0,) * 3,
        braked=(False,) * 3,
        sides=SIDES[:3],
        masses=MASSES[:3],
    )

    outer_n = torque_nm / REACH_M
    assert found == pytest.approx([outer_n, 2 * outer_n, outer_n])


def test_every_joint_presses_its_three_wheels_by_the_reaches_of_its_two_links():
    # Torques of all four joints as the usual clamp has them, each winds its own V.
    torques = (0.0, -0.7, 0.7 * 0.6, -0.7 * 0.6, 0.7, 0.0)
    a, b = REACH_M, MIDDLE_REACH_M
    rows = [
        (0.7, (1 / a, 2 / a, 1 / a, 0, 0, 0)),
        (0.42, (0, 1 / a, 1 / a + 1 / b, 1 / b, 0, 0)),
        (0.42, (0, 0, 1 / b, 1 / a + 1 / b, 1 / a, 0)),
        (0.7, (0, 0, 0, 1 / a, 2 / a, 1 / a)),
    ]
    expected = [sum(torque * row[wheel] for torque, row in rows) for wheel in range(6)]

    assert forces(torques) == pytest.approx(expected)


def test_the_whole_chain_of_the_design_presses_as_its_document_says():
    # The apexes bear 0.72 Nm; what the inner joints bear follows from wheels 2 and 5.
    inner = (40.0 - 2 * 13.35) * REACH_M
    torques = (0.0, -13.35 * REACH_M, inner, -inner, 13.35 * REACH_M, 0.0)

    assert forces(torques) == pytest.approx([13.4, 40.0, 48.0, 48.0, 40.0, 13.3], rel=0.05)
    assert pytest.approx(0.72, abs=0.01) == 13.35 * REACH_M


def test_mirrored_chains_press_alike():
    torques = (0.0, -0.7, 0.2, -0.3, 0.6, 0.0)
    right = forces(torques, drives=(1.0, 0.5, 2.0, -1.0, 0.0, 3.0), gravity=(-4.0, 2.0))
    left = forces(
        tuple(-t for t in torques),
        headings=tuple(-h for h in HEADINGS),
        sides=tuple(-s for s in SIDES),
        drives=(1.0, 0.5, 2.0, -1.0, 0.0, 3.0),
        gravity=(-4.0, -2.0),
    )

    assert left == pytest.approx(right)


def test_weight_across_the_pipe_is_borne_by_the_walls_in_sum():
    found = forces((0.0, -0.7, 0.2, -0.2, 0.7, 0.0), gravity=(0.0, -9.81))

    assert sum(n * side for n, side in zip(found, SIDES, strict=True)) == pytest.approx(
        -9.81 * sum(MASSES)
    )


def test_weight_along_the_pipe_is_borne_by_the_wheels_that_are_braked():
    torques = (0.0, -0.7, 0.0, 0.0, 0.7, 0.0)
    share_n = 9.81 * sum(MASSES) / 6
    held = forces(torques, braked=(True,) * 6, gravity=(-9.81, 0.0))
    driven = forces(torques, drives=(share_n,) * 6, gravity=(-9.81, 0.0))

    assert held == pytest.approx(driven)
    assert held != pytest.approx(forces(torques), abs=0.1)


@pytest.mark.parametrize(("way", "pressed"), [(1, 0), (-1, 5)])
def test_an_obstacle_at_the_leading_end_bears_what_drives_too_much(way, pressed):
    calm = forces((0.0, -0.7, 0.0, 0.0, 0.7, 0.0))
    pushed = forces((0.0, -0.7, 0.0, 0.0, 0.7, 0.0), drives=(4.0 * way,) * 6)

    # Compressed links push the next wheels apart, most where all six push the last link.
    change = [new - old for new, old in zip(pushed, calm, strict=True)]
    assert sum(c * side for c, side in zip(change, SIDES, strict=True)) == pytest.approx(0)
    assert abs(change[pressed]) == pytest.approx(20 * SPAN_M / REACH_M)


def test_the_reaction_of_a_motor_is_a_couple_on_the_link_that_it_sits_on():
    assert couples_nm((0.0, 0.3, 0.0), (0.1, 0.2, 0.0), (0, 1, 1)) == pytest.approx([-0.4, 0.1])


@pytest.mark.parametrize("where", ["couple", "heading", "drive", "gravity"])
def test_all_forces_are_unknown_where_anything_is(where):
    loads = ChainLoads(
        (nan, *HEADINGS[1:]) if where == "heading" else HEADINGS,
        (0.0, nan, 0.0, 0.0, 0.0) if where == "couple" else (0.0,) * 5,
        (0.0,) * 5 + (nan,) if where == "drive" else NO_WHEELS,
        (False,) * 6,
        (nan, 0.0) if where == "gravity" else LEVEL,
    )

    assert all(map(isnan, normal_forces_n(LENGTHS, MASSES, SIDES, loads)))


@pytest.mark.parametrize(("heading_deg", "known"), [(78, True), (79, False), (90, False)])
def test_a_link_across_the_pipe_shows_no_forces(heading_deg, known):
    found = forces(
        (0.0, -0.1, 0.0, 0.0, 0.1, 0.0), headings=(LEAN, -radians(heading_deg), *HEADINGS[2:])
    )

    assert isnan(found[0]) is not known


TORQUES = st.floats(-2.0, 2.0)
FORCES = st.floats(-15.0, 15.0)


@given(
    joints=st.tuples(*[TORQUES] * 4),
    wheels=st.tuples(*[TORQUES] * 6),
    mounts=st.tuples(*[st.integers(0, 4)] * 6),
    drives=st.tuples(*[FORCES] * 6),
    headings=st.tuples(*[st.floats(-1.3, 1.3)] * 5),
    braked=st.tuples(*[st.booleans()] * 6),
    tilt=st.floats(-pi, pi),
    sides=st.tuples(*[st.sampled_from([1, -1])] * 6),
)
def test_the_forces_solve_the_balance_of_all_six_wheels_at_once(
    joints, wheels, mounts, drives, headings, braked, tilt, sides
):
    gravity = (-9.81 * sin(tilt), -9.81 * cos(tilt))
    couples = couples_nm((0.0, *joints, 0.0), wheels, mounts)
    loads = ChainLoads(headings, couples, drives, braked, gravity)

    found = normal_forces_n(LENGTHS, MASSES, sides, loads)

    assert found == pytest.approx(_solved(sides, loads), abs=1e-6, rel=1e-6)


def _solved(sides, loads):
    """Six normal forces out of twelve equations.

    The other unknowns are the forces of five links, and one force against all motion along the
    pipe: of every braked wheel alike, or of an obstacle at the leading end.
    """
    matrix, right = np.zeros((12, 12)), np.zeros(12)
    gx, gy = loads.gravity_m_s2
    ahead = sum(loads.drives_n) + sum(MASSES) * gx > 0
    stops = [i for i in range(6) if loads.braked[i]] or [0 if ahead else 5]
    for wheel, mass in enumerate(MASSES):
        x, y = 2 * wheel, 2 * wheel + 1
        right[x], right[y] = -loads.drives_n[wheel] - mass * gx, -mass * gy
        matrix[y, wheel] = -sides[wheel]
        matrix[x, 11] = -1.0 if wheel in stops else 0.0
    for link, heading in enumerate(loads.headings_rad):
        along, across = (cos(heading), sin(heading)), (-sin(heading), cos(heading))
        for wheel, sign in ((link, 1.0), (link + 1, -1.0)):
            for axis in (0, 1):
                matrix[2 * wheel + axis, 6 + link] = sign * along[axis]
                size = loads.couples_nm[link] / LENGTHS[link]
                right[2 * wheel + axis] -= sign * size * across[axis]
    return list(np.linalg.solve(matrix, right)[:6])


def test_the_reach_of_a_leg_is_that_of_the_design():
    assert pytest.approx(sqrt(LEG_M**2 - SPAN_M**2)) == REACH_M
    assert pytest.approx(0.054) == REACH_M
