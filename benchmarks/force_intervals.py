"""Between which values the normal forces of a clamped robot lie, next to what simulators give.

    python -m benchmarks.force_intervals

Prints, for a robot whose four joints bear 0.505 Nm in a pipe of 120 mm with a friction of 0.7, the
sum of the normal forces: by statics without friction, then the least and the greatest that a linear
program over all static states finds for several brakes of the wheels, in the plane and in space;
then what the kinematic simulator gives in each, by how the robot came to stand there.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from math import sqrt
from typing import Any

from pirate_sm.core import library
from pirate_sm.core._geometry.force_intervals import (
    ForceInterval,
    Posture,
    Touch,
    normal_force_intervals,
)
from pirate_sm.core._geometry.network import Straight, planar
from pirate_sm.core.geometry import (
    GRAVITY_M_S2,
    Route,
    Section,
    Vector,
    combined,
    crossed,
    dot,
    scaled,
)
from pirate_sm.core.loading import load_robot
from pirate_sm.core.models import Friction
from pirate_sm.running.recording.viewers.pipe_walls import part_normals
from pirate_sm.simulation.kinematic.world import kinematic
from pirate_sm.simulation.physics import ChainBody, Physics, QuantityLayout, chain_of
from pirate_sm.simulation.start_pose import stand

CYCLE_S = 0.016
FRICTION = Friction(static=0.7, kinetic=0.5)
CLAMPED = {1: -0.5, 2: 0.5, 3: -0.5, 4: 0.5}
BRAKES_NM = (0.3, 0.04, 0.0)
NEAR_M = 0.001
"""A wheel that is farther from its wall than this does not touch it."""

DRIVE_ERROR_NM = 0.015
"""By how much the torque of a driven wheel may differ from that of the force along the wall, which
the physics shows: it accelerates. It is 0.05 of the stall torque, as it is for signals."""


def main() -> int:
    """Print the intervals, and the forces of the kinematic simulator."""
    chain = chain_of(load_robot(library.robots()[0]).profile)
    print("Sum of the normal forces, joints with 0.505 Nm, 120 mm, friction 0.7:")
    print("    brake of a wheel         plane                 space")
    sections: tuple[Section, ...] = ("bars", "round")
    for brake_nm in BRAKES_NM:
        found = [
            forces(_between_rigid_walls(chain, section), chain, section, brake_nm=brake_nm)[-1]
            for section in sections
        ]
        cells = "     ".join(f"{each.least_n:5.1f} to {each.greatest_n:5.1f} N" for each in found)
        print(f"    {1000 * brake_nm:5.0f} mNm           {cells}")
    print("The kinematic simulator:")
    for name, history in HISTORIES.items():
        sums = [sum(_pressed(chain, section, history)) for section in sections]
        print(f"    {name:24} {sums[0]:5.1f} N              {sums[1]:5.1f} N")
    return 0


def _between_rigid_walls(chain: ChainBody, section: Section) -> Any:
    """Return a world whose wheels just touch the walls, with the torques of the joints."""
    world: Any = put(chain, section)
    places = stand(chain, route_of(section), 1.5, CLAMPED).places
    world.state.position[:] = [place[: world.state.position.shape[1]] for place in places]
    for wheel, duty in CLAMPED.items():
        torque = QuantityLayout(chain.nodes).at("bend_torque", wheel)
        world.quantities[torque] = duty * chain.joints[wheel].stall_nm
    return world


def _pressed(
    chain: ChainBody, section: Section, history: Callable[[Physics, ChainBody], None]
) -> list[float]:
    world = put(chain, section)
    history(world, chain)
    return press_n(world, chain)


def _stand(world: Physics, chain: ChainBody) -> None:
    _pass(world, 1.0)


def _drive(world: Physics, chain: ChainBody) -> None:
    _pass(world, 1.0)
    world.duties[chain.nodes :] = [1.0 if wheel % 2 == 0 else -1.0 for wheel in range(chain.nodes)]
    _pass(world, 2.0)


def _drive_and_brake(world: Physics, chain: ChainBody) -> None:
    _drive(world, chain)
    world.duties[chain.nodes :] = 0.0
    _pass(world, 1.0)


HISTORIES = {
    "started clamped": _stand,
    "driving": _drive,
    "after driving": _drive_and_brake,
}


def put(chain: ChainBody, section: Section, up: Vector | None = None) -> Physics:
    """Return a kinematic world in which the robot is clamped in a straight pipe."""
    route = route_of(section)
    world = kinematic(chain, route, FRICTION, stand(chain, route, 1.5, CLAMPED), CYCLE_S)
    for wheel, duty in CLAMPED.items():
        world.duties[wheel] = duty
    return world


def route_of(section: Section) -> Route:
    """Return a straight pipe of 120 mm."""
    return Route(planar(0.12, (Straight(5.0),), section=section))


def _pass(world: Physics, seconds: float) -> None:
    for _ in range(round(seconds / CYCLE_S)):
        world.advance()


def press_n(world: Physics, chain: ChainBody) -> list[float]:
    """Return the normal force of each wheel."""
    found: list[float] = world.quantities[QuantityLayout(chain.nodes).block("press")].tolist()
    return found


def forces(
    world: Physics,
    chain: ChainBody,
    section: Section,
    *,
    route: Route | None = None,
    friction: float = FRICTION.static,
    brake_nm: float | None = None,
    up: Vector | None = None,
) -> tuple[ForceInterval, ...]:
    """Return the interval of the normal force of each wheel in a world, and last of their sum.

    Args:
        world: Any physics; its true places and torques count.
        chain: Its chain.
        section: Of its pipe.
        route: Its pipe; else that of :func:`route_of`.
        friction: Static friction coefficient.
        brake_nm: What a wheel bears at duty 0; else what its motor does.
        up: Unit vector against gravity; else that of the pipe.
    """
    route = route or route_of(section)
    n, layout, up = chain.nodes, QuantityLayout(chain.nodes), up or route.up
    points, radius_m = [*world.places()], chain.wheel_radius_m
    rear = chain.roll_link + 1 if chain.roll_link >= 0 else n - 1
    hinges = (
        part_normals(route, points, rear, world.rolls()[1:])
        if section == "round"
        else ((0.0, 0.0, 1.0),) * 2
    )
    arcs, grips, bends = (
        world.quantities[layout.block(each)].tolist() for each in ("arc", "grip", "bend_torque")
    )
    touches, masses_kg = [], [wheel.mass_kg for wheel in chain.wheels]
    for at, link in enumerate(chain.links):
        masses_kg[at] += link.mass_kg / 2
        masses_kg[at + 1] += link.mass_kg / 2
    for at, wheel in enumerate(chain.wheels):
        frame, hinge = route.frame_at(arcs[at]), hinges[at >= rear]
        off = combined((1.0, points[at]), (-1.0, frame.origin))
        across = combined((1.0, off), (-dot(off, frame.ahead), frame.ahead))
        if sqrt(dot(across, across)) < route.piece_at(arcs[at]).diameter_m / 2 - radius_m - NEAR_M:
            continue
        inward = _unit(scaled(-1.0, across))
        side = dot(inward, crossed(hinge, frame.ahead))
        rolls = scaled(-1.0 if side > 0 else 1.0, _unit(crossed(hinge, inward)))
        # A wheel on side A drives ahead as it turns towards side A.
        drive_n = grips[at] * (-1.0 if side > 0 else 1.0)
        braked = world.duties[n + at] == 0.0
        hold_nm = wheel.hold_nm if brake_nm is None else brake_nm
        doubt_n = (hold_nm if braked else DRIVE_ERROR_NM) / radius_m
        drive_n = 0.0 if braked else drive_n
        along_n = (drive_n - doubt_n, drive_n + doubt_n)
        touches.append(Touch(at, wheel.motor_link, inward, rolls, along_n, friction))
    posture = Posture(
        points,
        [hinges[at >= rear] for at in range(n)],
        {at: bends[at] for at in chain.joints},
        [scaled(-GRAVITY_M_S2 * mass_kg, up) for mass_kg in masses_kg],
        touches,
        radius_m,
        section == "round",
    )
    return normal_force_intervals(posture, range(n))


def _unit(vector: Vector) -> Vector:
    return scaled(1.0 / sqrt(dot(vector, vector)), vector)


if __name__ == "__main__":
    sys.exit(main())
