"""Whether the kinematic simulator and MuJoCo agree after the same history, and within statics.

    python -m benchmarks.physics_agreement

Both are given the same setpoints from the same state, in the plane and in space. For each history
it prints the sum of the normal forces in both, between which values statics allow it
(:mod:`benchmarks.force_intervals`), by how much of the greatest force a wheel of the one differs
from that of the other, and how far apart are the distance driven and the joints' angles.

Where the robot has rolled since its clamps closed, friction acts against the rolling, and forces
must be equal. Where it has not, friction keeps what closing has locked in, which mechanics do not
determine: each force must lie in its interval, at rest. There MuJoCo runs a second time, with its
solver for friction that does not creep: its two results are as far apart as the simulators. Then,
second by second, how a robot that has clamped on the floor of a round pipe reaches its axis.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.force_intervals import CLAMPED, CYCLE_S, FRICTION, forces, route_of
from pirate_sm.core import library
from pirate_sm.core.geometry import Section
from pirate_sm.core.loading import load_robot
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.kinematic.world import kinematic
from pirate_sm.simulation.mujoco.world import MujocoWorld
from pirate_sm.simulation.physics import ChainBody, MakePhysics, Physics, QuantityLayout, chain_of
from pirate_sm.simulation.start_pose import stand

MOST_FORCE, MOST_WAY, MOST_ANGLE = 0.15, 0.05, 0.05
_OUTSIDE = 0.02
"""By this share a force may lie outside its interval: forces are those of a world that moves."""
WORLDS: tuple[MakePhysics, MakePhysics] = (kinematic, MujocoWorld)
_NOSLIP_ITERATIONS = 3
"""Iterations of MuJoCo's solver without creep; ten give the same forces within 4 %."""
SECTIONS: tuple[Section, ...] = ("bars", "round")
FRONT, REAR = {1: -0.5, 2: 0.5}, {3: -0.5, 4: 0.5}
CLOSING_RAD, SETTLING = 3.0, 5.0
"""A clamp may close for as long as the motor of a joint takes to turn so far at full duty without
load, then for so many time constants with which its torque settles: statics know robots at rest."""


@dataclass(frozen=True)
class Step:
    """What is set, and for how long.

    Attributes:
        seconds: How long.
        joints: Duties of joints, by the wheel.
        drive: Duty of all wheels, ahead.
    """

    seconds: float
    joints: Mapping[int, float]
    drive: float = 0.0


@dataclass(frozen=True)
class History:
    """How a robot came to stand where it stands.

    Attributes:
        name: What is printed.
        begins: Duties of the joints that are wound up at the start.
        steps: What its motors are set to, and for how long.
    """

    name: str
    begins: Mapping[int, float]
    steps: tuple[Step, ...]

    @property
    def rolls(self) -> bool:
        """Whether the robot is driven after its clamps have closed."""
        return any(step.drive for step in self.steps)


def from_loose(chain: ChainBody) -> tuple[Step, ...]:
    """Return how a loose robot clamps, its front first; each has time for the motors' speed."""
    closing_s = closing(chain)
    return Step(closing_s, FRONT), Step(closing_s, CLAMPED)


def closing(chain: ChainBody) -> float:
    """Return for how long a clamp may close, s."""
    driven = [each for each in chain.joints.values() if each.rate_rad_s]
    return max(
        (CLOSING_RAD + SETTLING * each.stall_nm / each.stiffness_nm_rad) / each.rate_rad_s
        for each in driven
    )


def histories(chain: ChainBody) -> tuple[History, ...]:
    """Return what is compared; a leaning robot first drives for as long as its Vs take to open."""
    loose, ahead, held = from_loose(chain), Step(3.0, CLAMPED, 1.0), Step(1.0, CLAMPED)
    centred = (*loose, Step(closing(chain), CLAMPED, 1.0))
    again = (Step(1.0, REAR), Step(closing(chain), CLAMPED))
    return (
        History("started clamped", CLAMPED, (Step(2.0, CLAMPED),)),
        History("driving", CLAMPED, (held, ahead)),
        History("after driving", CLAMPED, (held, ahead, held)),
        History("front clamped again", REAR, again),
        History("clamped from loose", {}, loose),
        History("… and driving", {}, (*centred, ahead)),
        History("… and braked", {}, (*centred, ahead, held)),
    )


@dataclass(frozen=True)
class Ended:
    """What came of a history in one world.

    Attributes:
        press_n: Normal force of each wheel.
        inside: Whether each lies in its interval, and their sum.
        least_n: The least sum that statics allow.
        greatest_n: The greatest.
        way_m: How far the robot went in the last step in which it was driven.
        bends_rad: Angle of each joint.
    """

    press_n: Floats
    inside: bool
    least_n: float
    greatest_n: float
    way_m: float
    bends_rad: Floats


def main() -> int:
    """Print how both agree; return 1 where a bar is missed."""
    chain = chain_of(load_robot(library.robots()[0]).profile)
    good = True
    for section in SECTIONS:
        where = "the plane" if section == "bars" else "space"
        print(f"In {where}: sum of normal forces kinematic, MuJoCo (without creep); apart by")
        for history in histories(chain):
            ends = [end_of(make, chain, section, history) for make in WORLDS]
            force, way, angle = apart(*ends)
            holds = way <= MOST_WAY and angle <= MOST_ANGLE and all(each.inside for each in ends)
            holds &= force <= MOST_FORCE or not history.rolls
            good &= holds
            again = [] if history.rolls else [end_of(without_creep, chain, section, history)]
            other = "".join(f"; MuJoCo again {apart(ends[1], each)[0]:.0%}" for each in again)
            print(
                f"    {history.name:20} {', '.join(map(_in_words, ends + again))};"
                f" force {force:.1%}{other}; way {way:.1%}, angle {angle:.1%}"
                f"{'' if holds else '  (bar missed)'}",
                flush=True,
            )
    print("From the floor of a round pipe: off its axis, then way and slip of the wheel that slips")
    for name, make in zip(("kinematic", "MuJoCo"), WORLDS, strict=True):
        print(f"    {name:12} " + "; ".join(_to_the_axis(make, chain)), flush=True)
    return 0 if good else 1


def _in_words(it: Ended) -> str:
    return f"{it.press_n.sum():5.1f} N ({it.least_n:.0f} to {it.greatest_n:.0f})"


def without_creep(*args: Any) -> MujocoWorld:
    """Return a world of MuJoCo in which wheels that hold do not creep."""
    world = MujocoWorld(*args)
    world.model.opt.noslip_iterations = _NOSLIP_ITERATIONS
    return world


def put(
    make: MakePhysics, chain: ChainBody, section: Section, begins: Mapping[int, float]
) -> Physics:
    """Return a world in which the robot stands in a straight pipe, these joints wound up."""
    route = route_of(section)
    return make(chain, route, FRICTION, stand(chain, route, 1.5, begins), CYCLE_S)


def play(
    world: Physics, chain: ChainBody, step: Step, each: Callable[[], None] = lambda: None
) -> None:
    """Let a step pass."""
    n = chain.nodes
    world.duties[:n] = [step.joints.get(at, 0.0) for at in range(n)]
    world.duties[n:] = [-step.drive if at % 2 else step.drive for at in range(n)]
    for _ in range(round(step.seconds / CYCLE_S)):
        world.advance()
        each()


def end_of(make: MakePhysics, chain: ChainBody, section: Section, history: History) -> Ended:
    """Return what comes of a history in a world."""
    world, layout = put(make, chain, section, history.begins), QuantityLayout(chain.nodes)
    arcs, way_m = world.quantities[layout.block("arc")], 0.0
    for step in history.steps:
        begun = arcs.mean()
        play(world, chain, step)
        way_m = float(arcs.mean() - begun) if step.drive else way_m
    press = world.quantities[layout.block("press")].copy()
    *each, total = forces(world, chain, section)
    found = zip((*press, press.sum()), (*each, total), strict=True)
    slack = _OUTSIDE * press.max()
    inside = all(it.least_n - slack <= one <= it.greatest_n + slack for one, it in found)
    bends = world.quantities[layout.block("bend")].copy()
    return Ended(press, inside, total.least_n, total.greatest_n, way_m, bends)


def apart(one: Ended, other: Ended) -> tuple[float, float, float]:
    """Return by which shares of the greatest force, of the way and of the angles two differ."""
    return (
        _share(one.press_n, other.press_n),
        _share(np.array([one.way_m]), np.array([other.way_m])),
        _share(one.bends_rad, other.bends_rad),
    )


def _share(one: Floats, other: Floats) -> float:
    return float(np.abs(one - other).max() / max(np.abs(other).max(), 1e-9))


def _to_the_axis(make: MakePhysics, chain: ChainBody, seconds: int = 5) -> Sequence[str]:
    """Return how far a robot is off the axis second by second, and how it rolls in between."""
    world, layout = put(make, chain, "round", {}), QuantityLayout(chain.nodes)
    for step in from_loose(chain):
        play(world, chain, step)
    arcs, wheels = (world.quantities[layout.block(each)] for each in ("arc", "wheel"))
    told = []
    for _ in range(seconds):
        places = np.array(world.places())[:, 1:]
        off_m = np.linalg.norm(places[:-1] + places[1:], axis=1).max() / 2
        begun, turned = arcs.mean(), wheels.copy()
        play(world, chain, Step(1.0, CLAMPED, 1.0))
        way_m = float(arcs.mean() - begun)
        slips = np.abs(wheels - turned) * chain.wheel_radius_m / way_m - 1.0
        told.append(f"{1000 * off_m:.1f} mm, {1000 * way_m:.0f} mm, {np.abs(slips).max():.0%}")
    return told


if __name__ == "__main__":
    sys.exit(main())
