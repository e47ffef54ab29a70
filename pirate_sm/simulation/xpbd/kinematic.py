"""Picks the kinematic physics that fits the section of a pipe: bars in a plane, or round."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pirate_sm.core.geometry import Route, Section
from pirate_sm.core.options import USUAL, Fidelity
from pirate_sm.core.simulation import Friction
from pirate_sm.simulation import digitizing
from pirate_sm.simulation.machine_code import is_kept
from pirate_sm.simulation.mechanics import ChainBody
from pirate_sm.simulation.physics import Physics, StartPose
from pirate_sm.simulation.xpbd import glide, kernel
from pirate_sm.simulation.xpbd.world import World


def kinematic(
    chain: ChainBody,
    route: Route,
    friction: Friction,
    pose: StartPose,
    cycle_s: float,
    fidelity: Fidelity = USUAL,
) -> Physics:
    """Return the physics in a plane for bars, and in space for a round pipe."""
    if route.pieces[0].section == "bars":
        return World(chain, route, friction, pose, cycle_s, fidelity)
    from pirate_sm.simulation.xpbd.space.space_world import SpaceWorld

    return SpaceWorld(chain, route, friction, pose, cycle_s, fidelity)


def is_compiled(section: Section) -> bool:
    """Return whether a simulation can start at once; if not, its first call takes seconds."""
    functions: list[Callable[..., Any]] = [kernel.advance, glide.glide, digitizing.digitize]
    if section == "round":
        from pirate_sm.simulation.xpbd.space import glide as glide_in_space
        from pirate_sm.simulation.xpbd.space import kernel as kernel_in_space

        functions[:2] = kernel_in_space.advance, glide_in_space.glide
    return all(map(is_kept, functions))
