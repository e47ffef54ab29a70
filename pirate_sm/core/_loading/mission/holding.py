"""Ask of clamps what holds the robot where a mission takes it, whatever its motors give."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import inf

from pirate_sm.core._engine.robot.criteria import CriterionSpec, HeldSpec, LoadSpec, StalledSpec
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._geometry.chain import holding_nm
from pirate_sm.core._geometry.network import tilted_up
from pirate_sm.core._geometry.space import GRAVITY_M_S2, dot
from pirate_sm.core._model.pipe import Pipe
from pirate_sm.core._model.profile import Profile


def holding_in(robot: RobotSpec, profile: Profile, pipe: Pipe | None) -> RobotSpec:
    """Return the robot whose parts count as clamped only with a torque that holds it in a pipe.

    Each part must be able to hold the robot alone at the steepest place of the route, with the
    friction of the pipe. An unknown pipe is as steep, and as narrow, as can be.
    """
    numbers, body = robot.vocabulary.numbers, profile.body
    weight_n = body.mass_kg * GRAVITY_M_S2
    friction = ((pipe and pipe.friction) or profile.simulation.friction).static
    least_nm: dict[int, float] = {}
    for part in body.parts:
        apex, leg_m = body.apex_of(part), min(body.legs_m(part), default=0.0)
        if apex is not None and apex.torque in numbers:
            least_nm[numbers.index(apex.torque)] = max(
                holding_nm(weight_n * slope, friction, leg_m, bore_m - 2 * body.wheel_radius)
                for slope, bore_m in _places(pipe, 2 * body.wheel_radius)
            )
    commands = tuple(
        replace(
            command,
            done=_asked(command.done, least_nm),
            postures=tuple(
                each and replace(each, done=_asked(each.done, least_nm))
                for each in command.postures
            ),
        )
        for command in robot.commands
    )
    parts = tuple(each and _seen(each, least_nm) for each in robot.sight.parts)
    return replace(robot, commands=commands, sight=replace(robot.sight, parts=parts))


def _places(pipe: Pipe | None, narrowest_m: float) -> Iterator[tuple[float, float]]:
    """Yield the slope, as a sine, and the inner diameter of each piece of a route."""
    if pipe is None:
        yield 1.0, narrowest_m
        return
    route, turns = pipe.route(), pipe.turns
    ups = [route.up] if turns is None else [route.up, tilted_up(turns.tilt, pipe.uphill)]
    for piece in route.pieces:
        yield max(abs(dot(up, piece.frame.ahead)) for up in ups), piece.diameter_m


def _asked(criterion: CriterionSpec, least_nm: Mapping[int, float]) -> CriterionSpec:
    """Return the criterion with these torques as the smallest, by their number indexes.

    A criterion that names a torque instead of a share means just that torque.
    """
    if not (isinstance(criterion, StalledSpec) and any(it.full_nm for it in criterion.loads)):
        return criterion
    settled = criterion.settled
    if settled is not None:
        settled = settled._replace(loads=_raised(settled.loads, least_nm))
    return criterion._replace(loads=_raised(criterion.loads, least_nm), settled=settled)


def _raised(loads: tuple[LoadSpec, ...], least_nm: Mapping[int, float]) -> tuple[LoadSpec, ...]:
    return tuple(
        each._replace(least_nm=max(each.least_nm, least_nm.get(each.torque, 0.0))) for each in loads
    )


def _seen(held: HeldSpec, least_nm: Mapping[int, float]) -> HeldSpec:
    joints = []
    for joint in held.joints if held.settled_s < inf else ():
        least = least_nm.get(joint.torque, 0.0)
        needed_nm, least = max(joint.needed_nm, least), max(joint.least_nm, least)
        joints.append(joint._replace(needed_nm=needed_nm, least_nm=least))
    return held._replace(joints=tuple(joints) or held.joints)
