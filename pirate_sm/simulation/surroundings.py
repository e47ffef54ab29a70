"""The surroundings of a run: a pipe, its friction, obstacles, and the robot's start pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pirate_sm.core.errors import UsageError
from pirate_sm.core.geometry import Piece, Route
from pirate_sm.core.pipe import Pipe
from pirate_sm.core.profile import Profile
from pirate_sm.core.simulation import Friction
from pirate_sm.simulation.mechanics import ChainBody
from pirate_sm.simulation.obstacles import Obstacle
from pirate_sm.simulation.physics import StartPose
from pirate_sm.simulation.start_pose import stand


@dataclass(frozen=True)
class Jitter:
    """How far a run may differ from its files; each value is drawn uniformly within plus and minus.

    Attributes:
        start_m: Position of the robot along the pipe.
        friction: Both friction coefficients, as a share.
        diameter_m: Inner diameter.
    """

    start_m: float = 0.0
    friction: float = 0.0
    diameter_m: float = 0.0


NO_JITTER = Jitter()


def drawn_jitter(jitter: Jitter, rng: np.random.Generator) -> Jitter:
    """Return by how much one run differs from its files; a run's first random numbers draw it."""
    start, friction, diameter = rng.uniform(-1.0, 1.0, 3).tolist()
    return Jitter(start * jitter.start_m, friction * jitter.friction, diameter * jitter.diameter_m)


@dataclass(frozen=True)
class Surroundings:
    """The surroundings and the pose at the start of a run.

    Attributes:
        route: The way through the pipe.
        friction: Friction of the wall.
        friction_scale: What the friction's jitter multiplies every coefficient by.
        pose: How the robot stands.
        obstacles: Obstacles in the pipe.
    """

    route: Route
    friction: Friction
    friction_scale: float
    pose: StartPose
    obstacles: tuple[Obstacle, ...]


def surroundings_of(
    profile: Profile,
    chain: ChainBody,
    pipe: Pipe,
    *,
    duties: Mapping[int, float],
    jitter: Jitter,
    rng: np.random.Generator,
) -> Surroundings:
    """Draw a run's random deviations and return its surroundings.

    Args:
        profile: The robot's profile.
        chain: The robot's moving parts.
        pipe: The pipe.
        duties: Duty of each bend joint that is wound up, by its wheel; empty for a straight,
            unclamped robot.
        jitter: How far the numbers may differ from the files.
        rng: Random numbers.

    Raises:
        UsageError: The robot does not fit into the pipe, or the pipe intersects itself.
    """
    differs = drawn_jitter(jitter, rng)
    route = Route(pipe.network(differs.diameter_m))
    _check(route.pieces)
    coefficients = pipe.friction if pipe.friction is not None else profile.simulation.friction
    scale = 1.0 + differs.friction
    scaled = {"static": coefficients.static * scale, "kinetic": coefficients.kinetic * scale}
    arc_m = pipe.start_of(chain.length_m) + differs.start_m
    roll = (pipe.start.roll if pipe.start else 0.0) - pipe.roll
    return Surroundings(
        route,
        coefficients.model_copy(update=scaled),
        scale,
        stand(chain, route, arc_m, duties, roll),
        tuple(Obstacle(each.at, each.from_s, each.lasting) for each in pipe.blockages),
    )


def _check(pieces: Sequence[Piece]) -> None:
    for number, piece in enumerate(pieces, start=1):
        least_m = sum(piece.taken_m)
        if 0.0 < least_m >= piece.length_m:
            raise UsageError(
                f"straight {number} is {piece.length_m * 1000:.0f} mm long; the walls of its mitres"
                f" meet unless it is longer than {least_m * 1000:.0f} mm"
            )
