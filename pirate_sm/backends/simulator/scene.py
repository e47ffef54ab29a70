"""A pipe file and a robot's profile become what the simulator starts with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pirate_sm.backends.simulator.chain import Friction
from pirate_sm.backends.simulator.machine import Machine
from pirate_sm.backends.simulator.obstacles import Obstacle
from pirate_sm.backends.simulator.world import StartPose
from pirate_sm.geometry.network import Network
from pirate_sm.model.pipe import Pipe
from pirate_sm.model.profile import Profile


@dataclass(frozen=True)
class Jitter:
    """How far a run may differ from its files; each is drawn evenly between minus and plus.

    Attributes:
        start_m: Place of the robot along the pipe.
        friction: Share of both friction coefficients.
        diameter_m: Inner diameter.
    """

    start_m: float = 0.0
    friction: float = 0.0
    diameter_m: float = 0.0


@dataclass(frozen=True)
class Scene:
    """What a run starts with."""

    network: Network
    friction: Friction
    pose: StartPose
    obstacles: tuple[Obstacle, ...]


def scene_of(
    profile: Profile,
    machine: Machine,
    pipe: Pipe,
    *,
    start_values: Sequence[float] | None,
    jitter: Jitter,
    rng: np.random.Generator,
) -> Scene:
    """The run's own numbers are drawn.

    Args:
        profile: Of the robot.
        machine: The same, as simulated.
        pipe: Where it starts.
        start_values: Setpoints of the configuration it starts in, one per slot: joints that
            have a duty are wound up in a clamp. None: straight and unclamped.
        jitter: How far the numbers may differ.
        rng: Source of chance.
    """
    start, friction, diameter = rng.uniform(-1.0, 1.0, 3).tolist()
    coefficients = pipe.friction if pipe.friction is not None else profile.simulation.friction
    scale = 1.0 + friction * jitter.friction
    length = sum(link.length_m for link in machine.chain.links)
    pose = StartPose(
        pipe.start_of(length) + start * jitter.start_m, _wound(machine, start_values), -pipe.roll
    )
    return Scene(
        pipe.network(pipe.diameter + diameter * jitter.diameter_m),
        Friction(coefficients.static * scale, coefficients.kinetic * scale),
        pose,
        tuple(Obstacle(each.at, each.from_s, each.lasting) for each in pipe.blockages),
    )


def _wound(machine: Machine, values: Sequence[float] | None) -> dict[int, float]:
    if values is None:
        return {}
    n = machine.chain.nodes
    return {
        route.command: value
        for route, value in zip(machine.routes, values, strict=True)
        if 0 <= route.command < n and value != 0.0
    }
