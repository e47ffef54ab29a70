"""The routes of setpoints from the slots to the motors."""

from __future__ import annotations

from typing import NamedTuple

from pirate_sm.core.profile import Profile, Slot
from pirate_sm.simulation.mechanics import ChainBody

NOWHERE, ROLL = -2, -1


class SlotRoute(NamedTuple):
    """The motor that a setpoint drives, and its limits.

    Attributes:
        motor: Index in the physics' duties, ``ROLL`` for the roll joint, ``NOWHERE`` if nothing
            moves.
        low: Smallest accepted value, duty or rad.
        high: Largest accepted value.
        step: Resolution of the wire.
        least: Duty cycle below which the motor stands still.
    """

    motor: int
    low: float
    high: float
    step: float
    least: float = 0.0

    def moves(self, duty: float) -> bool:
        """Whether a duty cycle moves the motor."""
        return abs(duty) > self.least - 0.5 * self.step


def routes_of(profile: Profile, chain: ChainBody) -> tuple[SlotRoute, ...]:
    """Return the route of each slot, in the order of the wire."""
    return tuple(_route(profile, slot, chain) for slot in profile.slots)


def _route(profile: Profile, slot: Slot, chain: ChainBody) -> SlotRoute:
    link = profile.link
    if slot.unit == "angle":
        limit = slot.limit if slot.limit is not None else 7.0
        to = ROLL if slot.roll is not None else NOWHERE
        return SlotRoute(to, -limit, limit, link.angle_resolution)
    to, least = NOWHERE, 0.0
    if slot.wheel is not None:
        to = chain.nodes + chain.wheel_index[slot.wheel]
    elif slot.joint is not None:
        to, least = chain.joint_index[slot.joint], profile.motors[slot.motor].least_duty
    return SlotRoute(to, -1.0, 1.0, link.duty_resolution, least)
