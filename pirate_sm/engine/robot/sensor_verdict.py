"""Tell whether the sensors show a declared state or clamp, or something else."""

from __future__ import annotations

from math import degrees, inf, isnan, nan
from typing import NamedTuple

from pirate_sm.engine.robot.confirmation_spec import (
    AnglesSpec,
    DrivenSpec,
    HeldSpec,
    ImpliedSpec,
    SeenSpec,
    StandingSpec,
)
from pirate_sm.engine.robot.criteria import AcceptedSpec
from pirate_sm.engine.robot.done import still
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.robot.robot_state import Mark, Numbers, RobotState, states_of


class SensorVerdict(NamedTuple):
    """What the sensors say of a mark at one moment.

    Attributes:
        agrees: Whether they show it.
        against: What they show instead, and the limit; empty unless they contradict it.
        for_s: How long either must last.
    """

    agrees: bool
    against: str
    for_s: float = 0.0


def spec_of(robot: RobotSpec, names: tuple[str, ...], mark: Mark) -> SeenSpec | HeldSpec | None:
    """Return how a state or the clamp of a part shows itself; None where it does not."""
    sight = robot.sight
    if mark.kind == "part":
        return sight.parts[mark.which] if sight.parts else None
    return sight.states[mark.which].get(names[mark.which]) if sight.states else None


def verdict(
    robot: RobotSpec,
    setpoints: Numbers,
    body: RobotState,
    mark: Mark,
    numbers: Numbers,
    diameter_m: float | None,
) -> SensorVerdict:
    """Return what the sensors say of a mark.

    Args:
        robot: The robot.
        setpoints: Those of the declared configuration.
        body: What the robot is declared to be.
        mark: What is not confirmed.
        numbers: Signals in SI.
        diameter_m: Of the pipe; None where it is not known.
    """
    gripping = _gripping(robot, body, mark, numbers, diameter_m)
    if gripping is not None:
        return gripping
    spec = spec_of(robot, states_of(robot, body), mark)
    match spec:
        case HeldSpec():
            return _held(robot, setpoints, body, spec, numbers, diameter_m)
        case AnglesSpec():
            return _angles(robot, spec, numbers)
        case StandingSpec():
            return _standing(robot, spec, numbers)
        case DrivenSpec():
            return _driven(robot, spec, numbers)
        case ImpliedSpec():
            return SensorVerdict(True, "")
        case AcceptedSpec() | None:
            return SensorVerdict(False, "")


def _gripping(
    robot: RobotSpec, body: RobotState, mark: Mark, numbers: Numbers, diameter_m: float | None
) -> SensorVerdict | None:
    """Return what contradicts that no part holds, where one shows that it does; else None.

    A part that was only relaxed may show the same, since a self-locked worm keeps its spring wound.
    So this is asked only where nothing at all is declared to hold.
    """
    if mark.kind != "region" or robot.held[body.configuration]:
        return None
    for part, spec in enumerate(robot.sight.parts):
        if spec is None or mark.which not in robot.part_regions[part]:
            continue
        torques = [abs(numbers[joint.torque]) for joint in spec.joints]
        standing = all(abs(numbers[joint.rate]) < spec.still for joint in spec.joints)
        off, _ = _span(robot, body, spec, numbers, diameter_m)
        bears = all(torque >= spec.torque for torque in torques)
        if bears and standing and not off > spec.span_off:
            shown = ", ".join(str(round(torque * 1000)) for torque in torques)
            told = (
                f"the {robot.parts[part]} part bears {shown} mNm like one that holds, "
                f"limit {spec.torque * 1000:.0f} mNm"
            )
            return SensorVerdict(False, told, spec.for_s)
    return None


def _angles(robot: RobotSpec, spec: AnglesSpec, numbers: Numbers) -> SensorVerdict:
    names = robot.vocabulary.numbers
    agrees = all(abs(numbers[angle] - target) <= spec.within for angle, target in spec.targets)
    against = [
        f"{names[angle]} shows {degrees(numbers[angle]):.0f} deg, not {degrees(target):.0f} deg, "
        f"limit {degrees(spec.beyond):.0f} deg off"
        for angle, target in spec.targets
        if abs(numbers[angle] - target) > spec.beyond
    ]
    return SensorVerdict(agrees, "; ".join(against), spec.for_s)


def _standing(robot: RobotSpec, spec: StandingSpec, numbers: Numbers) -> SensorVerdict:
    against = [
        f"{robot.vocabulary.numbers[speed]} shows {numbers[speed]:.2f} rad/s, "
        f"limit {spec.below:g} rad/s"
        for speed in spec.speeds
        if abs(numbers[speed]) >= spec.below
    ]
    agrees = still(spec.speeds, numbers, spec.below)
    return SensorVerdict(agrees, "; ".join(against), spec.for_s)


def _driven(robot: RobotSpec, spec: DrivenSpec, numbers: Numbers) -> SensorVerdict:
    against = [
        f"{robot.vocabulary.numbers[speed]} shows {numbers[speed]:.2f} rad/s, the other way"
        for speed, way in spec.wheels
        if numbers[speed] * way < -spec.above
    ]
    return SensorVerdict(False, "; ".join(against), spec.for_s)


def _held(
    robot: RobotSpec,
    setpoints: Numbers,
    body: RobotState,
    spec: HeldSpec,
    numbers: Numbers,
    diameter_m: float | None,
) -> SensorVerdict:
    borne = [_borne(setpoints[j.slot], numbers[j.torque]) for j in spec.joints]
    loaded = all(torque >= spec.torque for torque in borne)
    standing = all(abs(numbers[joint.rate]) < spec.still for joint in spec.joints)
    off, told = _span(robot, body, spec, numbers, diameter_m)
    against = [told] if off > spec.span_off else []
    if all(torque < spec.slack for torque in borne):
        names = ", ".join(robot.vocabulary.numbers[joint.torque] for joint in spec.joints)
        shown = ", ".join(str(round(torque * 1000)) for torque in borne)
        against.append(f"{names} show {shown} mNm, less than {spec.slack * 1000:.0f} mNm")
    return SensorVerdict(loaded and standing and off <= spec.span, "; ".join(against), spec.for_s)


def _borne(setpoint: float, torque: float) -> float:
    """Return the torque in the direction in which the state turns the joint."""
    return torque if setpoint > 0 else -torque if setpoint < 0 else abs(torque)


def _span(
    robot: RobotSpec, body: RobotState, spec: HeldSpec, numbers: Numbers, diameter_m: float | None
) -> tuple[float, str]:
    """Return how far the part's diameter is off, as a share, and the sentence that says so.

    Infinite where the part touches no wall; NaN where a diameter is not known.
    """
    shown, name = numbers[spec.diameter], robot.vocabulary.numbers[spec.diameter]
    told = f"{name} shows {shown * 1000:.0f} mm"
    if abs(numbers[spec.apex]) >= spec.open_rad:
        return inf, f"{told}, it has opened to its end stop"
    if diameter_m is not None:
        limit = f"limit {spec.span_off:.0%} off"
        off = abs(shown - diameter_m) / diameter_m
        return off, f"{told}, the pipe has {diameter_m * 1000:.0f} mm, {limit}"
    sights = [robot.sight.parts[part] for part in robot.held[body.configuration]]
    others = [each.diameter for each in sights if each is not None and each is not spec]
    off, told_off = 0.0, ""
    for other in others:
        difference = abs(shown - numbers[other]) / numbers[other]
        if isnan(difference):
            return nan, ""
        if difference > off:
            shown_there = f"{robot.vocabulary.numbers[other]} {numbers[other] * 1000:.0f} mm"
            off, told_off = difference, f"{told}, {shown_there}, limit {spec.span_off:.0%} off"
    return (nan, "") if isnan(shown) else (off, told_off)
