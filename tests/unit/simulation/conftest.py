"""A shipped robot, pipes to put it in, and a physics with boards, driven without an engine."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.core._geometry.network import Mitre, Straight, planar
from pirate_sm.core.documents import read_document
from pirate_sm.core.geometry import Network, Route, dot
from pirate_sm.core.loading import validate
from pirate_sm.core.models import Friction, Profile
from pirate_sm.simulation.electronics import Electronics, routes_of, sensors_of
from pirate_sm.simulation.kinematic.world import World
from pirate_sm.simulation.physics import ChainBody, MakePhysics, Physics, QuantityLayout, chain_of
from pirate_sm.simulation.start_pose import stand

ROOT = Path(__file__).resolve().parents[3]
CYCLE_S = 0.016
DIAMETER_M = 0.12
SIX_WHEELED = ROOT / "hardware_profiles" / "pirate_ii" / "profile.yaml"
FOUR_WHEELED = ROOT / "tests" / "robots" / "newt" / "profile.yaml"


def read_profile(path: Path) -> Profile:
    return validate(read_document(path), Profile)


@pytest.fixture(scope="session")
def profile() -> Profile:
    return read_profile(SIX_WHEELED)


@pytest.fixture(scope="session")
def small_profile() -> Profile:
    return read_profile(FOUR_WHEELED)


@pytest.fixture(scope="session")
def chain(profile: Profile) -> ChainBody:
    return chain_of(profile)


def straight(length_m: float = 5.0, diameter_m: float = DIAMETER_M, **more: Any) -> Network:
    return planar(diameter_m, (Straight(length_m),), **more)


def bend(angle_deg: float = 90.0, **more: Any) -> Network:
    return planar(
        DIAMETER_M, (Straight(1.0), Mitre(math.radians(angle_deg)), Straight(1.0)), **more
    )


def vertical(length_m: float = 5.0) -> Network:
    """A pipe that goes straight up."""
    return straight(length_m, tilt_rad=math.pi / 2, uphill_rad=0.0)


class Driver:
    """Moves a chain by naming duties; every joint sign is that of a clamp."""

    def __init__(self, profile: Profile, chain: ChainBody, route: Route, world: Physics, seed: int):
        self.chain, self.route, self.physics = chain, route, world
        self.electronics = Electronics(
            chain, routes_of(profile, chain), sensors_of(profile, chain), world, seed
        )
        self.now_s = 0.0
        self._layout = QuantityLayout(chain.nodes)

    def clamp(self, *wheels: int, duty: float = 0.5) -> None:
        for wheel in wheels:
            self.physics.duties[wheel] = -duty if wheel % 2 else duty

    def drive(self, duty: float) -> None:
        n = self.chain.nodes
        for wheel in range(n):
            self.physics.duties[n + wheel] = -duty if wheel % 2 else duty

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / CYCLE_S)):
            self.physics.advance()

    def read(self) -> list[float]:
        """The counts of every channel after one more cycle."""
        self.physics.advance()
        self.electronics.read(0, len(self.electronics.counts))
        counts: list[float] = self.electronics.counts.tolist()
        return counts

    def values(self, quantity: str) -> list[float]:
        """A quantity of every wheel, SI."""
        found: list[float] = self.physics.quantities[self._layout.block(quantity)].tolist()
        return found

    def value(self, quantity: str) -> float:
        """A quantity that the robot has one of."""
        return float(self.physics.quantities[self._layout.at(quantity)])

    def sides(self) -> list[float]:
        """How far each wheel is from the centre line, towards side A."""
        return [
            dot(place, (frame := self.route.frame_at(arc)).side) - dot(frame.origin, frame.side)
            for place, arc in zip(self.physics.places(), self.arcs, strict=True)
        ]

    @property
    def arcs(self) -> list[float]:
        return self.values("arc")

    @property
    def middle(self) -> float:
        return sum(self.arcs) / len(self.arcs)


@pytest.fixture
def place(profile: Profile) -> Callable[..., Driver]:
    """Puts the robot into a pipe, by default clamped with half the stall torque."""

    def put(
        network: Network,
        *,
        at: float = 1.0,
        clamped: float = 0.5,
        duties: dict[int, float] | None = None,
        friction: tuple[float, float] = (0.7, 0.5),
        roll_rad: float = 0.0,
        seed: int = 1,
        robot: Profile = profile,
        physics: MakePhysics = World,
    ) -> Driver:
        chain, route = chain_of(robot), Route(network)
        if duties is None:
            joints = chain.joints if clamped else ()
            duties = {wheel: -clamped if wheel % 2 else clamped for wheel in joints}
        pose = stand(chain, route, at, duties, roll_rad)
        static, kinetic = friction
        world = physics(chain, route, Friction(static=static, kinetic=kinetic), pose, CYCLE_S)
        return Driver(robot, chain, route, world, seed)

    return put
