"""Between which values the normal forces of a clamped chain lie: a linear program over its statics.

The walls hold a clamped chain in more ways than it can move, so that statics alone leave its
normal forces open: how hard it presses depends on how it got there. What statics do bound are all
states in which every virtual motion of the chain does no work, every wheel presses and does not
pull, friction stays within its coefficient, and no motor bears more than it can. The unknowns are
the forces on the wheels; links, hinges and the roll joint bear what they must and drop out with
the virtual motions. Geometry, signs and torques are those of
:mod:`~pirate_sm.core._geometry.chain`.

In space the cone of friction is replaced by a pyramid around it, of as many sides as :data:`SIDES`:
the intervals are never narrower than the true ones, and by at most 1 / cos(pi / 16) - 1 = 2 % of
the friction wider.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import cos, inf, isnan, nan, pi, sin
from typing import NamedTuple

from pirate_sm.core._geometry.space import Vector, between, combined, crossed, dot
from pirate_sm.core.errors import not_installed

SIDES = 16
"""Of the pyramid around the cone of friction."""

_AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_UNBOUNDED, _SOLVED, _IN_TROUBLE = 3, 0, 4
_METHODS = ("highs", "highs-ds", "highs-ipm")
"""HiGHS chooses between its two solvers; rarely the one that it chose ends in numerical trouble."""


class Touch(NamedTuple):
    """A wheel at a wall.

    Attributes:
        wheel: Index of the wheel.
        link: Index of the link that its motor sits on.
        inward: Unit vector from the wall to the middle of the wheel.
        ahead: Unit vector along the wall in which the wheel rolls.
        along_n: Least and greatest force along ``ahead`` that its motor, or its brake, bears.
        friction: Coefficient of friction.
        resists: Force that resists rolling, over the normal force: by up to so much more or less
            than its motor bears may be along the wall.
    """

    wheel: int
    link: int
    inward: Vector
    ahead: Vector
    along_n: tuple[float, float]
    friction: float
    resists: float = 0.0


class Posture(NamedTuple):
    """A chain at rest, in any frame.

    Attributes:
        points: Middle of each wheel, m.
        hinges: Per wheel the unit vector about which its joint turns, towards side A.
        torques_nm: Of joints, by the wheel; joints that are left out bear what they must.
        weights_n: Weight of each wheel with half of its links.
        touches: What touches a wall.
        wheel_radius_m: Radius of the wheels.
        in_space: Whether forces across the plane count; else the plane bears them.
    """

    points: Sequence[Vector]
    hinges: Sequence[Vector]
    torques_nm: Mapping[int, float]
    weights_n: Sequence[Vector]
    touches: Sequence[Touch]
    wheel_radius_m: float
    in_space: bool

    @property
    def is_known(self) -> bool:
        """Whether all that acts on it is known."""
        drives = (sum(touch.along_n) for touch in self.touches)
        places = (sum(map(sum, each)) for each in (self.points, self.hinges, self.weights_n))
        return not isnan(sum((*drives, *places, *self.torques_nm.values())))


class ForceInterval(NamedTuple):
    """The least and the greatest force, N; NaN where no static state is admissible.

    None is for a chain that touches nothing.
    """

    least_n: float
    greatest_n: float


def normal_force_intervals(posture: Posture, wheels: Sequence[int]) -> tuple[ForceInterval, ...]:
    """Return the interval of the normal force of each of these wheels, and last of their sum.

    Args:
        posture: The chain.
        wheels: Indexes of the wheels.

    Raises:
        UsageError: SciPy is not installed.
    """
    try:
        from scipy.optimize import linprog  # noqa: PLC0415 - an extra
    except ModuleNotFoundError:
        raise not_installed("an interval of normal forces", "scipy", "fit") from None
    touches = posture.touches
    if not touches:
        return (ForceInterval(nan, nan),) * (len(wheels) + 1)
    rows, loads = _balances(posture)
    limits = [each for at, it in enumerate(touches) for each in _limits(posture, at, it)]
    upper, most_n = zip(*limits, strict=True) if limits else (None, None)
    bounds = ((0.0, None), (None, None), (None, None))[: _columns(posture)] * len(touches)

    def most(sign: float, chosen: Sequence[int]) -> float:
        costs = [0.0] * len(bounds)
        for at, touch in enumerate(touches):
            costs[at * _columns(posture)] = sign * (touch.wheel in chosen)
        for method in _METHODS:
            found = linprog(costs, upper, most_n, rows, loads, bounds, method)
            if found.status != _IN_TROUBLE:
                break
        if found.status == _UNBOUNDED:
            return -sign * inf
        return sign * float(found.fun) if found.status == _SOLVED else nan

    return tuple(
        ForceInterval(most(1.0, chosen), most(-1.0, chosen))
        for chosen in (*((wheel,) for wheel in wheels), wheels)
    )


def _columns(posture: Posture) -> int:
    """Return how many forces a wall puts on a wheel: normal, along, and in space aside."""
    return 3 if posture.in_space else 2


def _directions(posture: Posture, touch: Touch) -> tuple[Vector, ...]:
    return (touch.inward, touch.ahead, crossed(touch.inward, touch.ahead))[: _columns(posture)]


def _balances(posture: Posture) -> tuple[list[list[float]], list[float]]:
    """Return what each force does in each virtual motion, and what it must add up to.

    A wheel moves with the link of its motor. A joint's motion turns all that is ahead of it, and
    its torque turns that towards side B.
    """
    forces = [
        (combined((1.0, posture.points[it.wheel]), (-posture.wheel_radius_m, it.inward)), it, each)
        for it in posture.touches
        for each in _directions(posture, it)
    ]
    axes = _AXES if posture.in_space else _AXES[2:]
    rows = [[dot(axis, force) for *_, force in forces] for axis in _moves(posture)]
    loads = [-sum(dot(axis, weight) for weight in posture.weights_n) for axis in _moves(posture)]
    turns = [(axis, posture.points[0], len(posture.points), 0.0) for axis in axes]
    turns += [
        (posture.hinges[wheel], posture.points[wheel], wheel, torque)
        for wheel, torque in posture.torques_nm.items()
    ]
    for axis, about, ahead, torque in turns:
        rows.append(
            [
                dot(axis, crossed(between(about, point), force)) if it.link < ahead else 0.0
                for point, it, force in forces
            ]
        )
        moved = zip(posture.points[:ahead], posture.weights_n[:ahead], strict=True)
        loads.append(torque - sum(dot(axis, crossed(between(about, each), n)) for each, n in moved))
    return rows, loads


def _moves(posture: Posture) -> tuple[Vector, ...]:
    return _AXES if posture.in_space else _AXES[:2]


def _limits(posture: Posture, at: int, touch: Touch) -> Iterator[tuple[list[float], float]]:
    """Yield rows, and what each may be at most: the cone of friction, and what the motor bears."""
    columns = _columns(posture)
    angles = [2 * pi * side / SIDES for side in range(SIDES)]
    chosen = angles if posture.in_space else (angles[0], angles[SIDES // 2])
    least_n, greatest_n = touch.along_n
    for share, along, aside, most_n in (
        *((touch.friction, cos(angle), sin(angle), 0.0) for angle in chosen),
        (touch.resists, 1.0, 0.0, greatest_n),
        (touch.resists, -1.0, 0.0, -least_n),
    ):
        row = [0.0] * (columns * len(posture.touches))
        row[columns * at : columns * (at + 1)] = (-share, along, aside)[:columns]
        if most_n < inf:
            yield row, most_n
