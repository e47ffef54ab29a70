"""What someone outside would report of the surroundings of the simulated robot."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pirate_sm.backends.simulator.geometry import GRAVITY_M_S2, Pipe
from pirate_sm.backends.simulator.world import World
from pirate_sm.model.events import EnvironmentReport

# A wheel this near to a crossing makes the segment a joint.
_JOINT_REACH_M = 0.06
_PRESSED_N = 0.5


@dataclass(frozen=True)
class Vee:
    """A part whose V shows the pipe's diameter.

    Attributes:
        apex: Wheel that its apex joint sits at.
        length_m: Length of its legs.
        wheels: Wheels of the part.
    """

    apex: int
    length_m: float
    wheels: tuple[int, ...]


class Surroundings:
    """Reports the pipe around the robot when it changes.

    Args:
        parts: Parts that can clamp.
        wheel_radius_m: Of the wheels.
    """

    def __init__(self, parts: Mapping[str, Vee], wheel_radius_m: float) -> None:
        self._parts = tuple(parts.values())
        self._radius = wheel_radius_m
        self._key: tuple[object, ...] = ()

    def look(self, world: World, arcs: Sequence[float]) -> EnvironmentReport | None:
        """The report to make now; None when nothing has changed by 1 mm or 1 deg."""
        diameter = self._diameter(world)
        leg = world.pipe.leg_at(sum(arcs) / len(arcs))
        pitch = math.asin(min(1.0, max(-1.0, -leg.gravity[0] / GRAVITY_M_S2)))
        roll = -float(world.state.roll[1])
        segment = segment_of(world.pipe, arcs)
        known = None if math.isnan(diameter) else round(diameter * 1000)
        key = (segment, round(math.degrees(roll)), round(math.degrees(pitch)), known)
        if key == self._key:
            return None
        self._key = key
        return EnvironmentReport(segment, roll, pitch, diameter)

    def _diameter(self, world: World) -> float:
        """Mean of h + 2r over the parts that press with all their wheels (thesis eq. 3-2)."""
        press = world.values("press")
        found = [
            abs(vee.length_m * math.sin(world.state.bend[vee.apex] / 2.0)) + 2.0 * self._radius
            for vee in self._parts
            if min(press[wheel] for wheel in vee.wheels) > _PRESSED_N
        ]
        return float(sum(found) / len(found)) if found else math.nan


def segment_of(pipe: Pipe, arcs: Sequence[float]) -> str:
    """`Out` with most wheels outside, `Joint` with a wheel at a crossing, else `Straight`."""
    outside = sum(1 for arc in arcs if not 0.0 <= arc <= pipe.length_m)
    if 2 * outside > len(arcs):
        return "Out"
    low, high = min(arcs) - _JOINT_REACH_M, max(arcs) + _JOINT_REACH_M
    if any(low <= crossing <= high for crossing in pipe.crossings_m):
        return "Joint"
    return "Straight"
