"""How far a wheel sinks into the mouth of a tee's branch as it passes."""

from __future__ import annotations

from math import cos, pi, sin, sqrt

_POINTS = 96
_STEP_M = 0.0005


def sink_m(
    run_radius_m: float, branch_radius_m: float, wheel_radius_m: float, aside_rad: float
) -> float:
    """Return how far a wheel leaves the wall of a run where its line passes a mouth, m.

    A wheel is a sphere that is pushed outwards, away from the run's axis, where the axis of the
    branch crosses it. It stops at the edge of the mouth, X + b cos α t + b sin α (t × b) + b √(R² −
    b² sin² α) for a branch of radius b, a run of radius R and the run's direction t, or at the wall
    of the branch. It sinks by its diameter at most.

    Args:
        run_radius_m: Inner radius of the run.
        branch_radius_m: Inner radius of the branch.
        wheel_radius_m: Radius of the wheel.
        aside_rad: Angle about the run's axis from the middle of the mouth to the wheel.
    """
    aside, out = sin(aside_rad), cos(aside_rad)
    if run_radius_m * abs(aside) >= branch_radius_m or out <= 0.0:
        return 0.0  # its line does not cross the mouth
    edge = [
        (branch_radius_m * cos(angle), branch_radius_m * sin(angle))
        for angle in (2 * pi * number / _POINTS for number in range(_POINTS))
    ]
    ring = [(x, y, sqrt(run_radius_m**2 - y**2)) for x, y in edge]
    beyond_m = sqrt(run_radius_m**2 - branch_radius_m**2)
    least_m = (wheel_radius_m - _STEP_M / 100) ** 2

    def free(away_m: float) -> bool:
        across, high = away_m * aside, away_m * out
        if abs(across) > branch_radius_m - wheel_radius_m and high > beyond_m:
            return False
        return all(x**2 + (y - across) ** 2 + (z - high) ** 2 >= least_m for x, y, z in ring)

    start_m, steps = run_radius_m - wheel_radius_m, 0
    while steps * _STEP_M < 2 * wheel_radius_m and free(start_m + (steps + 1) * _STEP_M):
        steps += 1
    return steps * _STEP_M
