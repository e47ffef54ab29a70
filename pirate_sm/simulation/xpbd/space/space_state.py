"""The state of a chain in space as one array for the kernel."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pirate_sm.core.geometry import Vector
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.physics import StartPose
from pirate_sm.simulation.xpbd.space import columns


class SpaceState:
    """Views into the one array with the state of the chain.

    Args:
        nodes: Number of wheels.

    Attributes:
        array: The array for the kernel.
        position: `(wheels, 3)`, m.
        velocity: `(wheels, 3)`, m/s.
        motor: Motor-side angle of the joint at each wheel, rad.
        wheel: Angle of each wheel against its link, rad.
        bend: Angle of the joint at each wheel, rad.
        normals: `(2, 3)`, unit normals of the planes of the parts ahead of and behind the roll
            joint.
        roll: Angle of the roll joint and of its motor, rad.
    """

    def __init__(self, nodes: int) -> None:
        n, last = nodes, columns.S_ROLL * nodes
        self.array: Floats = np.zeros(last + columns.ROLL_ENTRIES)
        self.position = self.array[: 3 * n].reshape(n, 3)
        self.velocity = self.array[columns.S_VELOCITY * n : columns.S_MOTOR * n].reshape(n, 3)
        self.motor = self.array[columns.S_MOTOR * n : columns.S_WHEEL * n]
        self.wheel = self.array[columns.S_WHEEL * n : columns.S_BEND * n]
        self.bend = self.array[columns.S_BEND * n : columns.S_ANCHOR * n]
        self.normals = self.array[last : last + columns.R_RATE].reshape(2, 3)
        self.roll = self.array[last + columns.R_ANGLE :]

    def take(
        self, pose: StartPose, places: Sequence[Vector], normals: tuple[Vector, Vector]
    ) -> None:
        """Put the chain into a pose whose wheels are at these places.

        Args:
            pose: The pose.
            places: Centre of each wheel, m.
            normals: Of the planes of the parts ahead of and behind the roll joint.
        """
        self.position[:] = places
        self.normals[:] = normals
        if pose.rolls_rad:
            self.roll[:] = (pose.rolls_rad[0], pose.roll_motor_rad)
        self.bend[:] = pose.bends_rad
        self.motor[:] = pose.motors_rad
