"""Properties that any true physics has, of MuJoCo's world in random configurations.

    python -m benchmarks.physics_properties [--share 1.0] [--seed 0]

Each configuration has its own diameter, friction, rolling resistance, gravity, clamps and duties.
Prints for each property how many there were, the most by which one missed it, and the bar.

- mirror: with sides, joints and wheels exchanged, what happens is mirrored.
- reversal: with front and rear exchanged, it goes the other way round.
- rotation: in space, robot and gravity turned about the axis of the pipe change nothing but that.
- step: with steps of 1 ms in place of 2, and cycles of the same, a robot goes as far.
- energy: without motors, energy of motion, height and springs does not increase.
- statics: each normal force of a robot at rest lies where statics allow it.
- fall: what touches no wall falls freely.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import cos, inf, isnan, pi, sin
from random import Random

import mujoco
import numpy as np

from benchmarks.force_intervals import CYCLE_S, forces
from pirate_sm.core import library
from pirate_sm.core._geometry.network import Straight, planar
from pirate_sm.core.geometry import GRAVITY_M_S2, Route, Section, Vector
from pirate_sm.core.loading import load_robot
from pirate_sm.core.models import Friction
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.mujoco.model_text import PLATES
from pirate_sm.simulation.mujoco.world import MujocoWorld
from pirate_sm.simulation.physics import ChainBody, QuantityLayout, chain_of
from pirate_sm.simulation.start_pose import stand

LENGTH_M, SECONDS = 6.0, 0.4
_FINE_S = 0.001


@dataclass(frozen=True)
class Case:
    """A configuration.

    Attributes:
        chain: The robot.
        section: Of its pipe.
        diameter_m: Of its pipe.
        friction: Between wheels and walls.
        up: Unit vector against gravity, in the axes of the pipe's drawing.
        at_m: Where its first wheel is.
        joints: Duty of the joint at each wheel; it begins with the springs wound up so far.
        wheels: Duty of each wheel.
        roll_rad: Its roll.
    """

    chain: ChainBody
    section: Section
    diameter_m: float
    friction: Friction
    up: Vector
    at_m: float
    joints: tuple[float, ...]
    wheels: tuple[float, ...]
    roll_rad: float = 0.0

    @property
    def route(self) -> Route:
        """Its pipe."""
        return Route(planar(self.diameter_m, (Straight(LENGTH_M),), section=self.section))

    def world(self, cycle_s: float = CYCLE_S) -> MujocoWorld:
        """Return a world in which it begins."""
        duties = dict(enumerate(self.joints))
        pose = stand(self.chain, self.route, self.at_m, duties, self.roll_rad)
        made = MujocoWorld(self.chain, self.route, self.friction, pose, cycle_s)
        made.turn_gravity(self.up)
        made.duties[:] = (*self.joints, *self.wheels)
        return made


def case_of(chain: ChainBody, section: Section, random: Random) -> Case:
    """Return a random configuration of a robot of which both parts are clamped."""
    n, static = chain.nodes, random.uniform(0.15, 0.9)
    side, drive = random.choice((-1, 1)), random.uniform(-1.0, 1.0)
    clamps = [side * random.uniform(0.2, 0.7) for _ in range(2)]
    joints = [
        (-1.0 if at % 2 else 1.0) * clamps[at > chain.roll_link] if at in chain.joints else 0.0
        for at in range(n)
    ]
    wheels = [(-side if at % 2 else side) * drive * random.uniform(0.9, 1.0) for at in range(n)]
    tilt, way = random.uniform(0.0, pi / 2), random.uniform(0.0, 2 * pi)
    return Case(
        replace(chain, rolling_resistance=random.uniform(0.0, 0.03)),
        section,
        random.uniform(0.108, 0.122),
        Friction(static=static, kinetic=static * random.uniform(0.6, 1.0)),
        (sin(tilt) * cos(way), sin(tilt) * sin(way), -cos(tilt)),
        LENGTH_M / 2,
        tuple(joints),
        tuple(wheels),
    )


def run(world: MujocoWorld, seconds: float = SECONDS, cycle_s: float = CYCLE_S) -> Floats:
    """Return where the wheels are after a time."""
    for _ in range(round(seconds / cycle_s)):
        world.advance()
    return np.array(world.places())


# --- properties: each returns by how much a configuration misses it ------------------------------


def mirror(case: Case, _: Random) -> float:
    """Return how far apart a run and its mirrored mirror image end, m."""
    x, y, z = case.up
    other = replace(
        case,
        up=(x, -y, z),
        joints=tuple(-each for each in case.joints),
        wheels=tuple(-each for each in case.wheels),
    )
    return _apart(run(case.world()), run(other.world()) * [1.0, -1.0, 1.0])


def reversal(case: Case, _: Random) -> float:
    """Return how far apart a run and that of the robot put in the other way round end, m."""
    x, y, z = case.up
    world = case.world()
    links = [
        replace(wheel, motor_link=case.chain.nodes - 2 - wheel.motor_link)
        for wheel in reversed(case.chain.wheels)
    ]
    other = replace(
        case,
        chain=replace(case.chain, wheels=tuple(links)),
        up=(-x, y, z),
        at_m=LENGTH_M - world.places()[-1][0],
        joints=case.joints[::-1],
        wheels=tuple(-each for each in case.wheels[::-1]),
    )
    back = run(other.world())[::-1]
    return _apart(run(world), back * [-1.0, 1.0, 1.0] + [LENGTH_M, 0.0, 0.0])


def rotation(case: Case, random: Random) -> float:
    """Return how far apart a run and that of a robot which is turned with gravity end, m."""
    turn = 2 * pi * random.randrange(1, PLATES) / PLATES
    about = np.array([[1, 0, 0], [0, cos(turn), -sin(turn)], [0, sin(turn), cos(turn)]])
    x, y, z = (about @ case.up).tolist()
    other = replace(case, up=(x, y, z), roll_rad=-turn)
    return _apart(run(case.world()) @ about.T, run(other.world()))


def step(case: Case, _: Random) -> float:
    """Return by how much the ways differ that are reckoned in steps of 2 and of 1 ms, m."""
    begun = np.array(case.world().places())
    ways = [(run(case.world(s), cycle_s=s) - begun)[:, 0].mean() for s in (CYCLE_S, _FINE_S)]
    return float(abs(ways[0] - ways[1]))


def energy(case: Case, _: Random) -> float:
    """Return the most that a robot's energy increases in a cycle while no motor works, J."""
    world = case.world()
    world.duties[:] = 0.0
    found = []
    for _cycle in range(round(SECONDS / CYCLE_S)):
        world.advance()
        found.append(_energy(world, case.chain))
    return float(np.diff(found).max())


def statics(case: Case, _: Random) -> float:
    """Return by which share of the greatest force one lies outside of its interval."""
    world = replace(case, friction=Friction(static=0.9, kinetic=0.8)).world()
    run(world, 1.0)
    world.duties[case.chain.nodes :] = 0.0
    run(world, 1.0)
    press = world.quantities[QuantityLayout(case.chain.nodes).block("press")]
    *each, _total = forces(
        world, case.chain, case.section, route=case.route, friction=0.9, up=case.up
    )
    off = [
        max(0.0, it.least_n - n, n - it.greatest_n) + 0.0 * it.least_n
        for n, it in zip(press, each, strict=True)
    ]
    return max(inf if isnan(one) else one for one in off) / float(press.max())


def fall(case: Case, _: Random) -> float:
    """Return by which share the fall of a loose robot in a wide upright pipe is not free."""
    wide = replace(case, diameter_m=2.0, joints=(0.0,) * case.chain.nodes, up=(1.0, 0.0, 0.0))
    world = wide.world()
    # What is left of three places of constant acceleration, whatever the speed is.
    begun, halfway, ended = np.array(world.places()), run(world), run(world)
    fallen = -(begun - 2.0 * halfway + ended)[:, 0].mean()
    seconds = round(SECONDS / CYCLE_S) * CYCLE_S
    return float(abs(fallen / (GRAVITY_M_S2 * seconds**2) - 1.0))


def _apart(one: Floats, other: Floats) -> float:
    return float(np.linalg.norm(one - other, axis=1).max())


def _energy(world: MujocoWorld, chain: ChainBody) -> float:
    """Return the energy of motion, height and springs, J."""
    model, data = world.model, world.data
    mujoco.mj_energyPos(model, data)
    mujoco.mj_energyVel(model, data)
    wound = [
        each.stiffness_nm_rad
        * float(data.joint(f"bend_{at}").qpos[0] - data.act[model.actuator(f"bend_{at}").actadr[0]])
        ** 2
        for at, each in chain.joints.items()
    ]
    return float(data.energy.sum()) + 0.5 * sum(wound)


@dataclass(frozen=True)
class Property:
    """A property, where and how often it is tried, and its bar.

    Attributes:
        miss: Returns by how much a configuration misses it.
        sections: Of the pipes.
        count: How many configurations in each.
        most: How much may be missed.
        unit: Of what is missed.
    """

    miss: Callable[[Case, Random], float]
    sections: tuple[Section, ...]
    count: int
    most: float
    unit: str


_GROWN_M = 5e-4
"""What rounding errors may grow to where a wheel is at the limit of its friction."""
_BOTH: tuple[Section, Section] = ("bars", "round")
PROPERTIES = (
    Property(mirror, _BOTH, 60, 1e-9, "m"),
    Property(reversal, _BOTH, 60, _GROWN_M, "m"),
    Property(rotation, ("round",), 80, _GROWN_M, "m"),
    Property(step, _BOTH, 30, 1e-3, "m"),
    Property(energy, _BOTH, 50, 1e-3, "J"),
    Property(statics, _BOTH, 30, 0.02, "of the greatest force"),
    Property(fall, _BOTH, 10, 1e-3, "of the way"),
)


def misses(it: Property, chain: ChainBody, share: float = 1.0, seed: int = 0) -> dict[str, float]:
    """Return by how much each configuration of a property misses it, by section and number."""
    return {
        f"{section} {number}": it.miss(case_of(chain, section, random), random)
        for section in it.sections
        for number in range(max(1, round(share * it.count)))
        for random in [Random(f"{it.miss.__name__} {section} {seed} {number}")]
    }


def main() -> int:
    """Print how well each property holds; return 1 where a bar is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--share", type=float, default=1.0, help="of all configurations")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    chain, total, good = chain_of(load_robot(library.robots()[0]).profile), 0, True
    for it in PROPERTIES:
        found = misses(it, chain, args.share, args.seed)
        worst = max(found, key=lambda each: found[each])
        total += len(found)
        beyond = sum(each > it.most for each in found.values())
        good &= not beyond
        print(
            f"    {it.miss.__name__:10} {len(found):4} configurations, at most {found[worst]:.2g}"
            f" {it.unit} ({worst}), bar {it.most:g}, beyond it {beyond}",
            flush=True,
        )
    print(f"{total} configurations")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
