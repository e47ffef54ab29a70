"""A shipped robot, pipes to put it in, and worlds that can be driven without an engine."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.backends.simulator.chain import Friction
from pirate_sm.backends.simulator.geometry import Pipe
from pirate_sm.backends.simulator.machine import Machine, machine_of
from pirate_sm.backends.simulator.world import StartPose, World
from pirate_sm.geometry.network import Mitre, Network, Straight, planar
from pirate_sm.loading.source import read_document
from pirate_sm.loading.validate import validate
from pirate_sm.model.profile import Profile

ROOT = Path(__file__).resolve().parents[4]
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
def machine(profile: Profile) -> Machine:
    return machine_of(profile)


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
    """Moves a world by naming duties; every joint sign is that of a clamp."""

    def __init__(self, world: World) -> None:
        self.world = world

    def clamp(self, *wheels: int, duty: float = 0.5) -> None:
        for wheel in wheels:
            self.world.command[wheel] = -duty if wheel % 2 else duty

    def drive(self, duty: float) -> None:
        n = self.world.nodes
        for wheel in range(n):
            self.world.command[n + wheel] = -duty if wheel % 2 else duty

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / CYCLE_S)):
            self.world.advance(0, 0)

    @property
    def middle(self) -> float:
        arcs = self.world.arcs()
        return sum(arcs) / len(arcs)


@pytest.fixture
def place(machine: Machine) -> Callable[..., Driver]:
    """Puts the robot into a pipe, by default clamped with half the stall torque."""

    def put(
        network: Network,
        *,
        at: float = 1.0,
        clamped: float = 0.5,
        friction: tuple[float, float] = (0.7, 0.5),
        roll_rad: float = 0.0,
        seed: int = 1,
        robot: Machine = machine,
    ) -> Driver:
        joints = robot.chain.joints if clamped else ()
        duties = {wheel: -clamped if wheel % 2 else clamped for wheel in joints}
        world = World(
            robot,
            Pipe(network),
            Friction(*friction),
            StartPose(at, duties, roll_rad),
            cycle_s=CYCLE_S,
            seed=seed,
        )
        return Driver(world)

    return put
