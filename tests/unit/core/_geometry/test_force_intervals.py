"""The interval of normal forces: the issue's numbers, the statics of the chain, and its signs."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from itertools import pairwise
from math import atan2, cos, inf, isnan, nan, sin, sqrt
from typing import Any

import pytest

from pirate_sm.core._geometry.chain import ChainLoads, couples_nm, normal_forces_n
from pirate_sm.core._geometry.force_intervals import (
    ForceInterval,
    Posture,
    Touch,
    normal_force_intervals,
)
from pirate_sm.core._geometry.space import Vector, scaled
from pirate_sm.core.errors import UsageError

LENGTHS_M = (0.09, 0.09, 0.098, 0.09, 0.09)
HEIGHT_M = 0.072
SIDES = (1, -1, 1, -1, 1, -1)
MASSES_KG = (0.085, 0.15, 0.16, 0.16, 0.15, 0.085)
TORQUES_NM = {1: -0.505, 2: 0.505, 3: -0.505, 4: 0.505}
MOUNTS = (0, 1, 2, 2, 3, 4)
RADIUS_M = 0.024
NONE: Vector = (0.0, 0.0, 0.0)


def clamped(
    brake_nm: float,
    *,
    in_space: bool = False,
    drives_n: Mapping[int, float] | None = None,
    gravity_m_s2: Vector = NONE,
    roll_rad: float = 0.0,
    **changes: Any,
) -> Posture:
    """The robot across a pipe of 120 mm, rolled as a whole."""
    side = (0.0, cos(roll_rad), sin(roll_rad))
    at, points = 0.0, []
    for wheel, sign in enumerate(SIDES):
        points.append((at, *(sign * HEIGHT_M / 2 * each for each in side[1:])))
        if wheel < len(LENGTHS_M):
            at -= sqrt(LENGTHS_M[wheel] ** 2 - HEIGHT_M**2)
    most_n = brake_nm / RADIUS_M
    touches = []
    for wheel, sign in enumerate(SIDES):
        drive_n = (drives_n or {}).get(wheel)
        along_n = (-most_n, most_n) if drive_n is None else (drive_n, drive_n)
        inward = scaled(-sign, side)
        touches.append(Touch(wheel, MOUNTS[wheel], inward, (1.0, 0.0, 0.0), along_n, 0.7))
    normal = (0.0, -side[2], side[1])
    weights = [scaled(mass_kg, gravity_m_s2) for mass_kg in MASSES_KG]
    posture = Posture(
        points, [normal] * 6, TORQUES_NM, weights, touches, RADIUS_M, in_space=in_space
    )
    return posture._replace(**changes)


def total(posture: Posture) -> ForceInterval:
    return normal_force_intervals(posture, range(6))[-1]


def by_the_chain(drives_n: Mapping[int, float], gravity_m_s2: tuple[float, float]) -> list[float]:
    """The statics of the chain with these forces along the pipe."""
    points = clamped(0.0).points
    headings = [atan2(a[1] - b[1], a[0] - b[0]) for a, b in pairwise(points)]
    drives = [drives_n.get(wheel, 0.0) for wheel in range(6)]
    wheels_nm = [drive * RADIUS_M * side for drive, side in zip(drives, SIDES, strict=True)]
    joints = [TORQUES_NM.get(wheel, 0.0) for wheel in range(6)]
    couples = couples_nm(joints, wheels_nm, MOUNTS)
    loads = ChainLoads(headings, couples, drives, [False] * 6, gravity_m_s2)
    return normal_forces_n(LENGTHS_M, MASSES_KG, SIDES, loads)


@pytest.mark.parametrize("in_space", [False, True])
@pytest.mark.parametrize(
    ("brake_nm", "least_n", "greatest_n"),
    [(0.3, 34.0, 486.0), (0.04, 97.0, 188.0), (0.0, 142.6, 142.6)],
)
def test_brakes_leave_the_sum_of_normal_forces_open(
    brake_nm: float, least_n: float, greatest_n: float, *, in_space: bool
) -> None:
    found = total(clamped(brake_nm, in_space=in_space))
    assert found.least_n == pytest.approx(least_n, abs=0.5)
    assert found.greatest_n == pytest.approx(greatest_n, abs=0.5)


@pytest.mark.parametrize("in_space", [False, True])
def test_known_drives_leave_what_the_statics_of_the_chain_give(*, in_space: bool) -> None:
    drives_n = {0: 2.0, 1: -1.0, 2: 3.0, 3: 0.5, 4: -2.0, 5: 1.0}
    weight_m_s2 = -sum(drives_n.values()) / sum(MASSES_KG)
    posture = clamped(
        0.0, in_space=in_space, drives_n=drives_n, gravity_m_s2=(weight_m_s2, 2.0, 0.0)
    )
    found = normal_force_intervals(posture, range(6))
    exact = by_the_chain(drives_n, (weight_m_s2, 2.0))
    for between, force_n in zip(found, [*exact, sum(exact)], strict=True):
        assert between.least_n == pytest.approx(force_n, abs=1e-6)
        assert between.greatest_n == pytest.approx(force_n, abs=1e-6)


@pytest.mark.parametrize("in_space", [False, True])
def test_motors_that_drive_on_the_level_bear_what_resists_their_rolling(*, in_space: bool) -> None:
    resists, drive_n = 0.02, 0.45
    known = clamped(0.0, in_space=in_space, drives_n=dict.fromkeys(range(6), drive_n))
    rolls = [touch._replace(resists=resists) for touch in known.touches]

    assert isnan(total(known).least_n)  # something would have to hold the robot
    found = total(known._replace(touches=rolls))
    assert 6 * drive_n / resists <= found.least_n + 1e-6
    # Forces along the wall are what is left of the motors' torques: at most what resists them.
    most_n = resists * found.greatest_n
    exact = [sum(by_the_chain({0: way * most_n, 5: -way * most_n}, (0.0, 0.0))) for way in (1, -1)]
    assert min(exact) - 1e-6 <= found.least_n <= found.greatest_n <= max(exact) + 1e-6


def test_every_wheel_lies_between_its_own_bounds_and_adds_to_the_sum() -> None:
    *each, whole = normal_force_intervals(clamped(0.3), range(6))
    assert all(0.0 <= one.least_n < one.greatest_n for one in each)
    assert sum(one.least_n for one in each) <= whole.least_n + 1e-6
    assert sum(one.greatest_n for one in each) >= whole.greatest_n - 1e-6


def test_a_robot_that_touches_no_wall_has_no_static_state() -> None:
    found = normal_force_intervals(clamped(0.3, touches=[]), range(6))
    assert len(found) == 7
    assert all(isnan(bound) for between in found for bound in between)


def test_in_a_round_pipe_the_roll_of_the_robot_does_not_matter_without_gravity() -> None:
    found = [total(clamped(0.1, in_space=True, roll_rad=roll)) for roll in (0.0, 0.4, 2.0)]
    assert found[1] == pytest.approx(found[0], rel=1e-6)
    assert found[2] == pytest.approx(found[0], rel=1e-6)


def test_more_friction_and_stronger_brakes_only_widen_it() -> None:
    tight, loose = total(clamped(0.05)), total(clamped(0.1))
    touches = [each._replace(friction=0.2) for each in clamped(0.1).touches]
    slippery = total(clamped(0.1, touches=touches))
    for narrow in (tight, slippery):
        assert loose.least_n <= narrow.least_n + 1e-6
        assert loose.greatest_n >= narrow.greatest_n - 1e-6


def test_no_static_state_and_no_bound_are_told_apart() -> None:
    # Nothing bears the weight along the pipe; then friction above tan bears any pressure by itself.
    assert isnan(total(clamped(0.0, gravity_m_s2=(9.81, 0.0, 0.0))).least_n)
    jammed = clamped(1e4, in_space=False)
    touches = [each._replace(friction=3.0) for each in jammed.touches]
    assert total(jammed._replace(touches=touches)).greatest_n > 1e4
    free = [each._replace(along_n=(-inf, inf), friction=3.0) for each in jammed.touches]
    assert total(jammed._replace(touches=free)).greatest_n == inf


def test_what_is_unknown_is_said() -> None:
    assert clamped(0.3).is_known
    assert not clamped(0.3, torques_nm={1: nan}).is_known
    assert not clamped(0.3, points=[(nan, 0.0, 0.0)] * 6).is_known


def test_without_scipy_it_says_what_brings_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    with pytest.raises(UsageError, match=r"needs scipy, .* pip install 'pirate-sm\[fit\]'"):
        total(clamped(0.3))
