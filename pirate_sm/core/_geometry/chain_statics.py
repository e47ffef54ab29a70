"""Chain statics: how hard each wheel presses on its wall, from the torques of joints and wheels.

Links are rigid, half of a link's mass goes to each of its ends, and the robot moves slowly, so
that forces balance at every wheel. A joint's torque is a couple on each of its two links; so is the
reaction of a wheel's motor on the link that it sits on. A couple C on a link of length l is borne
by a pair of forces C / l across its ends. What is unknown are the normal forces, and a force along
each link; an excess of force along the pipe is borne by braked wheels, or by an obstacle at the
leading end.

The frame lies in the plane of the chain: x along the pipe, ahead; y towards side A. Headings count
towards side A, and so do couples.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, isnan, nan, sin
from typing import NamedTuple

LEAST_COSINE = 0.2
"""A link that stands across the pipe more steeply than this (78 deg) bears no force along it."""


class ChainLoads(NamedTuple):
    """What acts on a chain of wheels and links.

    Attributes:
        headings_rad: Of each link against the axis of the pipe.
        couples_nm: On each link, from joints and from the reactions of wheel motors.
        drives_n: Force along the pipe by which each wheel's motor pushes the robot ahead.
        braked: Whether each wheel is braked; it bears what force it must.
        gravity_m_s2: Its components along x and y.
    """

    headings_rad: Sequence[float]
    couples_nm: Sequence[float]
    drives_n: Sequence[float]
    braked: Sequence[bool]
    gravity_m_s2: tuple[float, float]


def couples_nm(
    joint_torques_nm: Sequence[float], wheel_torques_nm: Sequence[float], mounts: Sequence[int]
) -> list[float]:
    """Return the couple on each link.

    Args:
        joint_torques_nm: At each wheel, 0 where there is no joint. A positive one increases the
            joint's angle: it turns the link behind towards side A and the link ahead to side B.
        wheel_torques_nm: By which each motor turns its wheel.
        mounts: Index of the link that each wheel's motor sits on.
    """
    links = len(joint_torques_nm) - 1
    couples = [0.0] * links
    for node in range(1, links):
        couples[node] += joint_torques_nm[node]
        couples[node - 1] -= joint_torques_nm[node]
    for torque, link in zip(wheel_torques_nm, mounts, strict=True):
        couples[link] -= torque
    return couples


def normal_forces_n(
    lengths_m: Sequence[float], masses_kg: Sequence[float], sides: Sequence[int], loads: ChainLoads
) -> list[float]:
    """Return the normal force of each wheel, N; NaN for all where something is unknown.

    Args:
        lengths_m: Of the links, front to rear.
        masses_kg: At each wheel, with half of its links.
        sides: Per wheel the side that it touches: 1 is A, -1 is B.
        loads: What acts on the chain.
    """
    along = _along_n(masses_kg, loads)
    if isnan(sum(along)):
        return [nan] * len(masses_kg)
    ends = _across_links(lengths_m, loads)
    forces, pull = [], (0.0, 0.0)  # of the link ahead, on its rear end
    for node, mass_kg in enumerate(masses_kg):
        x = along[node] + ends[node][0] + pull[0] + mass_kg * loads.gravity_m_s2[0]
        y = ends[node][1] + pull[1] + mass_kg * loads.gravity_m_s2[1]
        if node < len(lengths_m):
            heading = loads.headings_rad[node]
            if not abs(cos(heading)) >= LEAST_COSINE:
                return [nan] * len(masses_kg)
            tension = x / cos(heading)
            pull = tension * cos(heading), tension * sin(heading)
            y -= pull[1]
        forces.append(y * sides[node])
    return [nan] * len(forces) if isnan(sum(forces)) else forces


def _along_n(masses_kg: Sequence[float], loads: ChainLoads) -> list[float]:
    """Return the force along the pipe on each wheel from its wall, or from an obstacle."""
    weight = sum(masses_kg) * loads.gravity_m_s2[0]
    excess = sum(loads.drives_n) + weight
    along = list(loads.drives_n)
    braked = [node for node, each in enumerate(loads.braked) if each]
    if braked:
        for node in braked:
            along[node] -= excess / len(braked)
    else:
        along[0 if excess > 0 else -1] -= excess
    return along


def _across_links(lengths_m: Sequence[float], loads: ChainLoads) -> list[tuple[float, float]]:
    """Return the force on each wheel by which its links bear their couples."""
    found = [(0.0, 0.0)] * (len(lengths_m) + 1)
    for link, (length_m, heading) in enumerate(zip(lengths_m, loads.headings_rad, strict=True)):
        size = loads.couples_nm[link] / length_m
        x, y = -sin(heading) * size, cos(heading) * size
        (ahead_x, ahead_y), (behind_x, behind_y) = found[link], found[link + 1]
        found[link] = (ahead_x + x, ahead_y + y)
        found[link + 1] = (behind_x - x, behind_y - y)
    return found
