"""Know the joint around the robot: a detector's word announces it, or two parts show a reducer.

A reducer is seen where two clamped parts show different diameters although both lie along one axis.
A part across a mitre or an elbow shows another diameter too, but its axis is turned.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan, nan, radians
from typing import NamedTuple, get_args

from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.body_spec import BodySpec
from pirate_sm.core._geometry.joints import JointOrEnd

JOINTS: tuple[str, ...] = get_args(JointOrEnd)
"""The kinds of joints, and the end of the pipe."""

_REDUCER = "reducer"

_ALONG_RAD = radians(2)
"""Parts whose axes differ by less lie along one axis [decided]."""

STEP = 0.03
"""Smallest relative difference of two diameters that is a reducer, more than noise [decided]."""

_LOOKS = 3
"""A reducer counts after it was seen in this number of consecutive surveys [decided]."""


class Around(NamedTuple):
    """What is remembered of the joint around the robot.

    Attributes:
        announced: The kind that a word has announced; empty without one.
        stepped: In how many surveys, one after the other, two parts have shown a reducer.
    """

    announced: str = ""
    stepped: int = 0


def joint_around(
    robot: RobotSpec, before: Around, word: str | None, in_bend: bool, ahead_m: float
) -> tuple[Around, str]:
    """Return what to remember, and the kind of the joint around the robot; empty is unknown.

    Args:
        robot: The robot.
        before: What was remembered.
        word: The detector's valid word, if any.
        in_bend: Whether a word has announced a joint that is not passed yet.
        ahead_m: The inner diameter behind a reducer that two parts show; NaN if they show none.
    """
    announced = before.announced if in_bend else ""
    if word is not None and in_bend:
        announced = robot.words_joint.get(word, announced)
    stepped = 0 if isnan(ahead_m) else min(before.stepped + 1, _LOOKS)
    seen = _REDUCER if stepped == _LOOKS else ""
    return Around(announced, stepped), announced or seen


def step_ahead_m(body: BodySpec, parts: Sequence[int], numbers: Sequence[float]) -> float:
    """Return the diameter at the first part if two parts along one axis differ in it, m; else NaN.

    Args:
        body: The robot's chain.
        parts: The clamped parts that have a wall.
        numbers: Every signal in SI; NaN is unknown.
    """
    vees = [body.parts[part] for part in parts]
    shown = [numbers[vee.diameter] if vee.diameter >= 0 else nan for vee in vees]
    if len(shown) < 2 or not max(shown) - min(shown) > STEP * max(shown):
        return nan
    headings = [body.heading_in_pipe(numbers, part, 0) for part in parts]
    if not max(headings) - min(headings) <= _ALONG_RAD or any(map(isnan, (*shown, *headings))):
        return nan
    foremost = min(range(len(vees)), key=lambda each: vees[each].wheels[0])
    return shown[foremost]
