"""Clamps that settle before a run begins."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

from pirate_sm.simulation.arrays import Floats

# The forces of a clamp of the shipped robot do not change any more after half of it [by trial].
SETTLING_S = 0.4


def settle(
    advance: Callable[[], None],
    cycles: int,
    columns: ModuleType,
    state: Floats,
    body: Floats,
    gravity: Floats,
) -> None:
    """Let the clamps press without weight and with wheels that roll freely, then stand still.

    Wheels that hold from the first step on would lock in the least forces with which a clamp can
    hold: a quarter of those after driving.

    Args:
        advance: Simulates one cycle.
        cycles: For how many.
        columns: The module of the columns.
        state: The state of the chain; changed.
        body: The moving parts.
        gravity: What pulls at them.
    """
    n = len(body)
    motor = state[columns.S_MOTOR * n : columns.S_WHEEL * n]
    bend = state[columns.S_BEND * n : columns.S_ANCHOR * n]
    wound = motor - bend
    held, pull = body[:, columns.WHEEL_HOLD].copy(), gravity.copy()
    body[:, columns.WHEEL_HOLD] = gravity[...] = 0.0
    for _ in range(cycles):
        advance()
        motor[:] = bend + wound
    body[:, columns.WHEEL_HOLD], gravity[...] = held, pull
    state[columns.S_VELOCITY * n : columns.S_MOTOR * n] = 0.0
    state[columns.S_WHEEL * n : columns.S_BEND * n] = 0.0
    state[columns.S_ANCHOR * n : columns.S_ROLL * n] = 0.0
