"""The robot's chain of wheels and links, with the indexes of its signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isnan
from typing import NamedTuple

from pirate_sm.core._engine.sensing import surveyor
from pirate_sm.core._geometry.chain import Chain
from pirate_sm.core._geometry.space import Place

WHOLE = -1
"""In place of a part's index: the whole chain."""


class Vee(NamedTuple):
    """A part that clamps as a V.

    Attributes:
        wheels: Its wheels, front to rear.
        angle: Number index of the angle at its apex.
        diameter: Number index of the inner diameter derived from this angle; -1 without one.
        end_stop_rad: Largest angle of the apex in either direction.
    """

    wheels: tuple[int, ...]
    angle: int
    diameter: int
    end_stop_rad: float


class BodyRows(NamedTuple):
    """The body as plain numbers, see :mod:`surveyor`.

    Attributes:
        chain: A row per wheel.
        parts: A row per part.
        imu: The accelerometer.
    """

    chain: tuple[tuple[float, ...], ...]
    parts: tuple[tuple[float, ...], ...]
    imu: tuple[int, ...]


class Imu(NamedTuple):
    """The accelerometer, on the half of its link ahead of a roll joint.

    Attributes:
        link: Index of its link.
        axes: Number indexes of the acceleration along the link ahead, towards side B and up.
        roll: Number index of its half's roll angle against the rear half; -1 without one.
    """

    link: int
    axes: tuple[int, int, int]
    roll: int


@dataclass(frozen=True)
class BodySpec(Chain):
    """The robot's chain with the indexes of its signals.

    Attributes:
        joints: Per wheel the number index of its joint's angle; -1 without a joint.
        parts: The clamping parts, in the order of the robot's parts.
        wheel_radius_m: Radius of the wheels.
        roll_link: Index of the link with a roll joint; -1 without one.
        imu: The accelerometer; None without one.
        roll: Number index of the roll joint's angle; -1 without one.
        weight_n: Weight of the whole robot.
        edge_lacks: Share of its radius that a wheel on the edge of its tyre lacks.
    """

    joints: tuple[int, ...]
    parts: tuple[Vee, ...]
    wheel_radius_m: float
    roll_link: int = -1
    imu: Imu | None = None
    roll: int = -1
    weight_n: float = 0.0
    edge_lacks: float = 1.0

    def wheels_of(self, part: int) -> tuple[int, ...]:
        """Return the wheels of a part, or of the ``WHOLE`` chain, front to rear."""
        return tuple(range(len(self.joints))) if part == WHOLE else self.parts[part].wheels

    def angles(self, numbers: Sequence[float]) -> tuple[float, ...]:
        """Return the angle at each wheel, rad: 0 without a joint, NaN where it is unknown."""
        return tuple([numbers[joint] if joint >= 0 else 0.0 for joint in self.joints])

    def heading_in_pipe(self, numbers: Sequence[float], part: int, link: int) -> float:
        """Return a link's heading relative to the pipe axis at a clamped part, rad.

        Args:
            numbers: The engine's signals; NaN is unknown.
            part: Index of the part.
            link: Index of the link.

        Returns:
            The heading, positive towards side A; NaN if an angle in between is unknown.
        """
        return surveyor.heading_in_pipe(part, link, numbers, self.rows.chain, self.rows.parts)

    @cached_property
    def rows(self) -> BodyRows:
        """Return it as plain numbers."""
        parts = [
            (vee.angle, vee.diameter, vee.end_stop_rad, vee.wheels[0], vee.wheels[-1])
            for vee in self.parts
        ]
        imu = self.imu
        return BodyRows(
            tuple(zip(self.joints, self.sides, (*self.lengths_m, 0.0), strict=True)),
            tuple((*part, self.wheel_radius_m) for part in parts),
            (-1, 0, 0, 0, -1) if imu is None else (imu.link, *imu.axes, imu.roll),
        )


def known(points: Sequence[Place], wheels: Sequence[int]) -> bool:
    """Return whether the positions of all these wheels are known."""
    return not any(isnan(points[wheel][0]) for wheel in wheels)
