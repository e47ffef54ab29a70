"""What holds for both kernels in any configuration: symmetry, steps, energy, statics, motors.

Each test draws its configurations from a seed: a pipe's diameter, its tilt and the robot's roll,
friction, torques of the joints, duties of the wheels. The thorough stage draws more.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray
from representative import thorough_but

from benchmarks.force_intervals import forces, press_n
from pirate_sm.core._geometry.network import Mitre, Network, Straight, planar
from pirate_sm.core.geometry import GRAVITY_M_S2, Route, Section
from pirate_sm.core.models import Friction
from pirate_sm.simulation.kinematic import world as kinematic_world
from pirate_sm.simulation.kinematic.space import columns as space
from pirate_sm.simulation.kinematic.space.space_world import SpaceWorld
from pirate_sm.simulation.kinematic.world import World
from pirate_sm.simulation.physics import ChainBody, QuantityLayout
from pirate_sm.simulation.start_pose import stand

from ..conftest import CYCLE_S, straight

Floats: TypeAlias = NDArray[np.float64]

KINDS: dict[Section, Any] = {"bars": World, "round": SpaceWorld}
AT_M, LENGTH_M = 2.5, 5.0
AHEAD = np.array([1.0, -1.0] * 3)
"""By this sign of its duty each wheel drives ahead."""
SETTLED = 10.0
"""After so many of the slowest time constants 5e-5 is left of what a motion has begun with."""

both = pytest.mark.parametrize("section", thorough_but(["round"], KINDS))
between_bars = pytest.mark.parametrize(
    "section", ["bars", pytest.param("round", marks=pytest.mark.thorough)]
)
seeds = pytest.mark.parametrize(
    "seed", [1, *(pytest.param(more, marks=pytest.mark.thorough) for more in range(2, 10))]
)


class Case(NamedTuple):
    """A robot in a straight pipe."""

    section: Section
    diameter_m: float
    up: Floats
    joints: Mapping[int, float]
    wheels: Floats
    friction: float
    roll_rad: float
    at_m: float = AT_M

    def route(self) -> Route:
        network = straight(LENGTH_M, self.diameter_m, section=self.section)
        return standing(network, self.up)


def standing(network: Network, up: Floats) -> Route:
    x, y, z = up.tolist()
    return Route(Network(network.runs, network.routes, (x, y, z)))


def drawn(section: Section, seed: int, count: int) -> Iterator[Case]:
    """Cases at random; every other robot drives."""
    rng = np.random.default_rng(seed)
    for number in range(count):
        up = rng.normal(size=3)
        duties = clamped(rng.uniform(0.3, 0.7, 4))
        driven = rng.uniform(-1.0, 1.0) * AHEAD * rng.uniform(0.5, 1.0, 6) * (number % 2)
        yield Case(
            section,
            rng.uniform(0.105, 0.125),
            up / np.linalg.norm(up),
            duties,
            driven,
            rng.uniform(0.1, 1.0),
            rng.uniform(-3.0, 3.0) if section == "round" else 0.0,
        )


def clamped(duties: Floats) -> dict[int, float]:
    """Duties of the joints at wheels 1 to 4 with the signs of a clamp."""
    signed = np.array([-1.0, 1.0, -1.0, 1.0]) * duties
    return dict(zip((1, 2, 3, 4), signed.tolist(), strict=True))


def put(chain: ChainBody, case: Case, route: Route | None = None, *, loose: bool = False) -> Any:
    """Return the world of a case; the joints of a loose robot are not wound up."""
    route = route or case.route()
    held = {} if loose else case.joints
    friction = Friction(static=case.friction, kinetic=0.7 * case.friction)
    pose = stand(chain, route, case.at_m, held, case.roll_rad)
    world = KINDS[case.section](chain, route, friction, pose, CYCLE_S)
    for wheel, duty in held.items():
        world.duties[wheel] = duty
    world.duties[chain.nodes :] = case.wheels
    return world


def run(world: Any, seconds: float) -> Any:
    for _ in range(round(seconds / CYCLE_S)):
        world.advance()
    return world


def places(world: Any) -> Floats:
    return np.array(world.places())


def slowest_s(chain: ChainBody) -> float:
    """Return the time constant by which motors of joints wind their springs up, the slowest one.

    A motor turns at ``rate * (duty - torque / stall)``, and its turning adds ``stiffness`` to the
    torque.
    """
    driven = (joint for joint in chain.joints.values() if joint.rate_rad_s)
    return max(each.stall_nm / (each.rate_rad_s * each.stiffness_nm_rad) for each in driven)


def quantity(world: Any, name: str) -> Floats:
    found: Floats = world.quantities[QuantityLayout(6).block(name)]
    return found


# --- symmetry ------------------------------------------------------------------------------------


@both
@seeds
def test_a_mirrored_robot_goes_the_mirrored_way_to_the_bit(
    chain: ChainBody, section: Section, seed: int
) -> None:
    for case in drawn(section, seed, 80):
        mirrored = case._replace(
            up=case.up * [1, -1, 1],
            joints={wheel: -duty for wheel, duty in case.joints.items()},
            wheels=-case.wheels,
            roll_rad=-case.roll_rad,
        )
        one, other = (run(put(chain, each), 1.0) for each in (case, mirrored))
        assert (places(one) == places(other) * [1, -1, 1]).all()
        assert (quantity(one, "press") == quantity(other, "press")).all()


@both
@seeds
def test_a_pipe_that_is_laid_or_rolled_otherwise_is_the_same(
    chain: ChainBody, section: Section, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    for case in drawn(section, seed, 60):
        angle = rng.uniform(-1.2, 1.2)
        c, s = math.cos(angle), math.sin(angle)
        if section == "bars":  # in the second leg of a bend
            turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
            legs = (Straight(1.0), Mitre(angle), Straight(LENGTH_M))
            route = standing(planar(case.diameter_m, legs), turn @ case.up)
            second = route.pieces[1]
            other, origin = case._replace(at_m=second.arc_m + AT_M), second.frame.origin
        else:
            turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
            other = case._replace(up=turn @ case.up, roll_rad=case.roll_rad - angle)
            route, origin = other.route(), (0.0, 0.0, 0.0)
        usual, turned = run(put(chain, case), 1.0), run(put(chain, other, route), 1.0)
        assert (places(turned) - origin) @ turn == pytest.approx(places(usual), abs=1e-9)


@both
@seeds
def test_a_robot_that_is_turned_round_goes_the_same_way_back(
    chain: ChainBody, section: Section, seed: int
) -> None:
    # Its body is the same from both ends; but links are solved from the front on.
    for case in drawn(section, seed, 50):
        usual = put(chain, case)
        along_m = [x for x, *_ in stand(chain, case.route(), case.at_m, case.joints).places]
        turned = case._replace(
            up=case.up * [-1, 1, 1],
            joints={5 - wheel: duty for wheel, duty in case.joints.items()},
            wheels=-case.wheels[::-1],
            at_m=LENGTH_M - along_m[-1],
        )
        back = places(run(put(chain, turned), 1.0))[::-1] * [-1, 1, 1] + [LENGTH_M, 0, 0]
        assert back == pytest.approx(places(run(usual, 1.0)), abs=1e-3)


# --- steps and energy ----------------------------------------------------------------------------


@between_bars
@seeds
def test_steps_of_2_of_1_and_of_half_a_millisecond_lead_to_the_same(
    chain: ChainBody, section: Section, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    apart = []
    for case in drawn(section, seed, 30):
        ends = []
        for step_s in (0.002, 0.001, 0.0005):
            monkeypatch.setattr(kinematic_world, "STEP_S", step_s)
            world = put(chain, case._replace(friction=max(case.friction, 0.15)))
            start = places(world)
            run(world, 2.0)
            ends.append((places(world) - start, quantity(world, "bend").copy()))
        for way, bends in ends[1:]:
            apart.append(float(np.abs(way - ends[0][0]).max()))
            assert way == pytest.approx(ends[0][0], abs=8e-3)
            assert bends == pytest.approx(ends[0][1], abs=0.02)
    assert np.median(apart) < 6e-4


@both
@seeds
def test_without_motors_energy_never_grows(chain: ChainBody, section: Section, seed: int) -> None:
    rng = np.random.default_rng(seed)
    stiffness = [getattr(chain.joints.get(wheel), "stiffness_nm_rad", 0.0) for wheel in range(6)]
    for number, each in enumerate(drawn(section, seed, 60)):
        up = each.up * [1, 1, section == "round"]  # bars bear what pulls across their plane
        case = each._replace(up=up / np.linalg.norm(up), friction=0.2 * each.friction)
        world = put(chain, case, loose=number % 4 == 1)
        world.duties[:] = 0.0
        world.state.velocity[:, 0] += rng.normal() * (number % 3)
        found = [energy_j(world, case, np.array(stiffness))]
        for _ in range(40):
            world.advance()
            found.append(energy_j(world, case, np.array(stiffness)))
        # A pressed wall gives some hundredths of a joule back, which are not counted.
        assert max(found) < found[0] + 0.05
        assert (np.array(found) - np.minimum.accumulate(found)).max() < 0.1


def spun_j(chain: ChainBody, case: Case, rate_rad_s: float) -> np.ndarray:
    """The energy of a clamped robot in each cycle after it was turned about its pipe's axis."""
    stiffness = [getattr(chain.joints.get(wheel), "stiffness_nm_rad", 0.0) for wheel in range(6)]
    world = put(chain, case)
    world.duties[:] = 0.0
    _, y, z = places(world).T
    world.state.velocity[:, 1:] += rate_rad_s * np.array([-z, y]).T
    world.state.array[space.S_ROLL * 6 + space.R_RATE :][:2] -= rate_rad_s
    found = [energy_j(world, case, np.array(stiffness))]
    for _ in range(40):
        world.advance()
        found.append(energy_j(world, case, np.array(stiffness)))
    return np.array(found)


@seeds
def test_a_clamped_robot_that_is_spun_only_loses_energy_where_friction_brakes_it(
    chain: ChainBody, seed: int
) -> None:
    for each in drawn("round", seed, 40):
        rate_rad_s = min(75.0, 0.7 * each.friction / kinematic_world.STEP_S)
        found = spun_j(chain, each._replace(wheels=np.zeros(6)), rate_rad_s)
        assert (found - np.minimum.accumulate(found)).max() < 0.01


@seeds
def test_a_clamped_robot_that_is_spun_gains_no_energy_whatever_the_friction(
    chain: ChainBody, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    for number, each in enumerate(drawn("round", seed, 40)):
        friction = max(each.friction * (number % 4) / 3, 1e-9)
        case = each._replace(wheels=np.zeros(6), friction=friction)
        found = spun_j(chain, case, rng.uniform(20.0, 75.0))
        # Walls that bear a spun robot besides its clamps store and give back up to twice as much.
        assert found.max() < found[0] + 0.05
        assert (found - np.minimum.accumulate(found)).max() < 0.2


def energy_j(world: Any, case: Case, stiffness: Floats) -> float:
    """Of motion, of weight and of springs, without what pressed walls have stored."""
    mass_kg, state = 1.0 / world.body[:, space.MASS_INV], world.state
    found = 0.5 * (mass_kg * (state.velocity**2).sum(axis=1)).sum()
    found += GRAVITY_M_S2 * (mass_kg * (places(world) @ case.up)).sum()
    found += 0.5 * (stiffness * (state.bend - state.motor) ** 2).sum()
    if case.section == "round":
        rolls = state.array[space.S_ROLL * 6 + space.R_RATE :][:2]
        inertia = world._world[[space.INERTIA_FRONT, space.INERTIA_REAR]]
        angle, motor = state.roll
        found += 0.5 * (inertia * rolls**2).sum()
        found += 0.5 * space.TWIST_NM_RAD * (angle - motor) ** 2
    return float(found)


@both
def test_a_robot_outside_of_every_pipe_falls_freely(chain: ChainBody, section: Section) -> None:
    up = np.array([0.6, 0.8, 0.0])
    case = Case(section, 0.12, up, {}, np.zeros(6), 0.5, 0.0)
    world = put(chain, case)
    world.state.position[:, 0] -= 10.0  # behind its end
    run(world, 0.16)
    mass_kg = 1.0 / world.body[:, space.MASS_INV]
    before = mass_kg @ world.state.velocity
    run(world, 0.8)
    fallen = (before - mass_kg @ world.state.velocity)[:2] / mass_kg.sum() / 0.8
    assert fallen == pytest.approx(up[:2] * GRAVITY_M_S2, abs=1e-6)


# --- statics and motors --------------------------------------------------------------------------


@between_bars
@seeds
def test_normal_forces_lie_between_what_statics_admit(
    chain: ChainBody, section: Section, seed: int
) -> None:
    for each in drawn(section, seed, 12):
        case = each._replace(friction=max(each.friction, 0.2))
        world = run(put(chain, case), 1.0)
        pressed = press_n(world, chain)
        found = forces(world, chain, section, route=case.route(), friction=case.friction)
        for between, force_n in zip(found, [*pressed, sum(pressed)], strict=True):
            assert between.least_n - 0.1 <= force_n <= between.greatest_n + 0.1


@both
@seeds
def test_a_climbing_robot_bears_its_weight_at_the_speed_of_its_motors(
    chain: ChainBody, section: Section, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    for case in drawn(section, seed, 6):
        tilt, duty = rng.uniform(0.1, math.pi / 2), rng.uniform(0.5, 1.0)
        up = np.array([math.sin(tilt), math.cos(tilt), 0.0])
        joints = clamped(rng.uniform(0.45, 0.7, 4))
        world = put(chain, Case(section, case.diameter_m, up, joints, np.zeros(6), 0.7, 0.0, 0.6))
        run(world, 0.5)
        world.duties[6:] = duty * AHEAD
        run(world, SETTLED * slowest_s(chain))
        weight_n = GRAVITY_M_S2 * float((1.0 / world.body[:, 0]).sum())
        along_n = weight_n * math.sin(tilt)
        assert (quantity(world, "grip") * AHEAD).sum() == pytest.approx(along_n, rel=1e-9)
        turned = world.state.wheel.copy()
        world.advance()
        speed = ((world.state.wheel - turned) * AHEAD).mean() / CYCLE_S
        motor = chain.wheels[0]
        left = duty - quantity(world, "drive").mean() / motor.stall_nm
        assert speed == pytest.approx(motor.rate_rad_s * left, rel=1e-6)


@both
@pytest.mark.parametrize("share", [0.6, 0.8, 1.0, 1.4])
def test_an_upright_robot_falls_below_the_friction_that_bears_its_weight(
    chain: ChainBody, section: Section, share: float
) -> None:
    # By hand 0.0543 with 0.505 Nm: its weight over what all wheels press with, without friction.
    up, joints = np.array([1.0, 0.0, 0.0]), clamped(0.5 * share * np.ones(4))
    case = Case(section, 0.12, up, joints, np.zeros(6), 1.0, 0.0)
    pressed_n = forces(put(chain, case._replace(up=np.array([0.0, 0.0, -1.0]))), chain, "bars",
                       brake_nm=0.0)[-1].least_n  # fmt: skip
    weight_n = GRAVITY_M_S2 * sum(each.mass_kg for each in (*chain.wheels, *chain.links))
    by_hand = weight_n / pressed_n
    assert by_hand == pytest.approx(0.0543 / share, rel=0.03)  # walls give way a little
    ways = []
    for coefficient in (0.05 / share, 0.06 / share):
        friction = Friction(static=coefficient, kinetic=coefficient)
        route = case.route()
        world = KINDS[section](chain, route, friction, stand(chain, route, AT_M, joints), CYCLE_S)
        for wheel, duty in joints.items():
            world.duties[wheel] = duty
        run(world, 1.0)
        before = places(world)[:, 0].mean()
        run(world, 0.3)
        ways.append(before - places(world)[:, 0].mean())
    assert ways[0] > 0.2
    assert abs(ways[1]) < 2e-3
