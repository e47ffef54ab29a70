"""MuJoCo's world beside the kinematic simulator's: do they agree, and how fast are they.

    python -m benchmarks.physics [--repeats 3]

Prints how far the two are apart after three seconds of ClampFront from the same state and with the
same setpoints, and how many times real time each world is by itself and with engine and boards in
the loop. `benchmarks.physics_agreement` compares forces, `campaigns/bend_physics.yaml` missions.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees
from time import process_time

import numpy as np

from benchmarks.campaign import run
from pirate_sm.core import library
from pirate_sm.core._geometry.network import Straight, planar
from pirate_sm.core.geometry import Route, Section
from pirate_sm.core.loading import load_robot
from pirate_sm.core.models import Friction
from pirate_sm.lab.campaign.watched_run import WATCHED_AFTER_S
from pirate_sm.running.wiring import Order
from pirate_sm.simulation.kinematic.space.space_world import SpaceWorld
from pirate_sm.simulation.kinematic.world import World as KinematicWorld
from pirate_sm.simulation.mujoco.world import MujocoWorld
from pirate_sm.simulation.physics import ChainBody, MakePhysics, Physics, QuantityLayout, chain_of
from pirate_sm.simulation.start_pose import stand

CYCLE_S = 0.016
CLAMP_FRONT = {1: -0.7, 2: 0.7}
CLAMP_REAR = {3: -0.7, 4: 0.7}
MOST_TORQUE_NM, MOST_PLACE_M = 0.05, 0.003
LEAST_SPEED = {"bars": 50.0, "round": 20.0}
_SPEED_CYCLES = 208
_REPEATS = 3


@dataclass(frozen=True)
class Beginning:
    """A state from which the front is clamped.

    Attributes:
        name: What is printed.
        duties: Of the joints at these wheels, before and meanwhile; none: the robot is loose.
        bar: Whether the two must agree; a loose part may swing differently.
    """

    name: str
    duties: Mapping[int, float]
    bar: bool = True


BEGINNINGS = (
    Beginning("rear clamped", CLAMP_REAR),
    Beginning("both clamped with less", {1: -0.5, 2: 0.5, 3: -0.5, 4: 0.5}),
    Beginning("loose, straight", {}, bar=False),
)


def main() -> int:
    """Print agreement and speed; return 1 where a bar is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=_REPEATS)
    repeats = parser.parse_args().repeats
    chain = chain_of(load_robot(library.robots()[0]).profile)
    good = True
    print("ClampFront for 3 s, kinematic and MuJoCo, most of all joints and wheels:")
    for beginning in BEGINNINGS:
        torque_nm, place_m, angle_deg = apart(chain, beginning)
        fits = torque_nm <= MOST_TORQUE_NM and place_m <= MOST_PLACE_M
        good &= fits or not beginning.bar
        print(
            f"    {beginning.name:24} {1000 * torque_nm:5.1f} mNm, {1000 * place_m:5.2f} mm,"
            f" {angle_deg:4.2f} deg{'' if beginning.bar else '  (no bar)'}"
        )
    print("Times real time, clamped and driving, one processor (by its own time, the best counts):")
    worlds: tuple[tuple[str, MakePhysics, Section], ...] = (
        ("kinematic, plane", KinematicWorld, "bars"),
        ("kinematic, space", SpaceWorld, "round"),
        ("MuJoCo, plane", MujocoWorld, "bars"),
        ("MuJoCo, space", MujocoWorld, "round"),
    )
    for name, physics, section in worlds:
        print(f"    {name:24} {speed(chain, physics, section, repeats):6.0f} ×", flush=True)
    print("Times real time of a mission, with engine, boards and noise:")
    for name, backend, pipe in (
        ("kinematic, plane", "sim", "straight_113"),
        ("kinematic, space", "sim", "straight_113_round"),
        ("MuJoCo, plane", "physics", "straight_113"),
        ("MuJoCo, space", "physics", "straight_113_round"),
    ):
        times = mission_speed(Order("exp_1_round", backend, pipe=pipe), repeats)
        section = "round" if name.endswith("space") else "bars"
        good &= times >= LEAST_SPEED[section]
        print(f"    {name:24} {times:6.0f} × (bar {LEAST_SPEED[section]:.0f} ×)", flush=True)
    return 0 if good else 1


def mission_speed(order: Order, repeats: int) -> float:
    """Return how many times faster than real time a mission runs, by the processor's time."""
    best = 0.0
    for _ in range(repeats):  # the first one also loads and compiles
        began = process_time()
        outcome = run(order)
        best = max(best, (outcome.time_s + WATCHED_AFTER_S) / (process_time() - began))
    return best


def put(
    chain: ChainBody, physics: MakePhysics, duties: Mapping[int, float], section: Section = "bars"
) -> Physics:
    """Return a world in which the robot stands in a straight pipe, these joints wound up."""
    route = Route(planar(0.12, (Straight(5.0),), section=section))
    world = physics(
        chain, route, Friction(static=0.7, kinetic=0.5), stand(chain, route, 1.5, duties), CYCLE_S
    )
    for wheel, duty in duties.items():
        world.duties[wheel] = duty
    return world


def apart(chain: ChainBody, beginning: Beginning) -> tuple[float, float, float]:
    """Return how far joint torques (Nm), places (m) and angles (deg) of the two are apart."""
    layout = QuantityLayout(chain.nodes)
    ends = []
    for physics in (KinematicWorld, MujocoWorld):
        world = put(chain, physics, beginning.duties)
        for cycle in range(250):
            if cycle == 62:
                for wheel, duty in CLAMP_FRONT.items():
                    world.duties[wheel] = duty
            world.advance()
        torques, angles = (
            world.quantities[layout.block(each)].copy() for each in ("bend_torque", "bend")
        )
        ends.append((torques, np.array(world.places()), angles))
    (torque, place, angle), other = ends
    away = np.linalg.norm(place - other[1], axis=1)
    return (
        float(np.abs(torque - other[0]).max()),
        float(away.max()),
        degrees(np.abs(angle - other[2]).max()),
    )


def speed(chain: ChainBody, physics: MakePhysics, section: Section, repeats: int) -> float:
    """Return how many times faster than real time a clamped robot drives."""
    world = put(chain, physics, {**CLAMP_FRONT, **CLAMP_REAR}, section)
    n = chain.nodes
    best = 0.0
    for _ in range(repeats):
        world.duties[n:] = [1.0 if i % 2 == 0 else -1.0 for i in range(n)]
        world.advance()
        began = process_time()
        for _ in range(_SPEED_CYCLES):
            world.advance()
        best = max(best, _SPEED_CYCLES * CYCLE_S / (process_time() - began))
    return best


if __name__ == "__main__":
    sys.exit(main())
