"""Compare what is declared of the robot with its sensors before it moves.

A robot that starts with sensors has every state and every held part marked as declared. For a
bounded time the marks are compared with what the sensors show, by the profile's ``seen``. What
they confirm loses its mark. What they contradict refuses the start. What they leave open, because
a signal is unknown or lies between the limits, stays unconfirmed until a command has confirmed it.
"""

from __future__ import annotations

from math import degrees, inf, isnan, nan
from typing import NamedTuple

from pirate_sm.engine.deadlines import has_come
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
from pirate_sm.engine.robot.robot_state import (
    DECLARED,
    STOPPED,
    Mark,
    Numbers,
    RobotState,
    at_rest_in,
    states_of,
)
from pirate_sm.model.fault_codes import BuiltInFault

CODE = BuiltInFault.START_CONTRADICTED.code

LOOKING = "the sensors are still being compared with the states that were declared"


_NEVER_SHOWN = (AcceptedSpec, type(None))


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


class Watched(NamedTuple):
    """A mark, since when the sensors agree with it and since when they contradict it, else NaN."""

    mark: Mark
    agrees_s: float = nan
    against_s: float = nan
    told: str = ""
    for_s: float = 0.0


class Look(NamedTuple):
    """The sensors are being compared with what is declared.

    Attributes:
        until_s: When that ends at the latest.
        setpoints: Those of the declared configuration.
        marks: What is not decided yet.
    """

    until_s: float
    setpoints: Numbers
    marks: tuple[Watched, ...]

    @property
    def due_s(self) -> float:
        """Return when time alone decides something."""
        lasting = [each.agrees_s + each.for_s for each in self.marks if not isnan(each.agrees_s)]
        return min((self.until_s, *lasting))


class LookResult(NamedTuple):
    """What has come of a look: where it stands, what is confirmed, and why the start is refused.

    Attributes:
        look: None once it is over.
        turning: Whether wheels turn that were declared to stand or to turn the other way.
    """

    look: Look | None
    confirmed: frozenset[Mark]
    contradictions: tuple[str, ...] = ()
    turning: bool = False


def declared_in(robot: RobotSpec, configuration: int) -> RobotState:
    """Return a robot that is said to be in a configuration, of which nothing is confirmed.

    Its wheels are not taken to be driven, whatever is said: only a command drives them.
    """
    rest = at_rest_in(robot, configuration)
    values = list(rest.values)
    for slot in robot.safe_zero:
        values[slot] = 0.0
    marks = {Mark("part", part, DECLARED) for part in robot.held[configuration]}
    marks |= {Mark("region", region, DECLARED) for region in range(len(robot.regions))}
    marks |= {Mark("region", region, STOPPED) for region in robot.driven[configuration]}
    return rest._replace(values=tuple(values), marks=frozenset(marks))


def begin(robot: RobotSpec, body: RobotState, now: float) -> Look | None:
    """Begin to look at what is declared; None where nothing of it could be seen."""
    names = states_of(robot, body)
    marks = tuple(
        Watched(mark)
        for mark in sorted(body.marks)
        if mark.command == DECLARED and not isinstance(_spec(robot, names, mark), _NEVER_SHOWN)
    )
    if not marks:
        return None
    setpoints = at_rest_in(robot, body.configuration).values
    return Look(now + robot.sight.within_s, setpoints, marks)


def awaiting(robot: RobotSpec, body: RobotState) -> frozenset[Mark]:
    """Return the declared states that only the next accepted setpoints can confirm."""
    names = states_of(robot, body)
    return frozenset(
        mark
        for mark in body.marks
        if mark.command == DECLARED and isinstance(_spec(robot, names, mark), AcceptedSpec)
    )


def accepted(robot: RobotSpec, body: RobotState) -> RobotState:
    """Confirm the declared states that the setpoints in force make, where nothing shows more."""
    names = states_of(robot, body)
    held = {
        mark
        for mark in awaiting(robot, body)
        if all(
            write.how != "set" or body.values[write.slot] == write.value
            for write in robot.actuation[mark.which][names[mark.which]][-1]
        )
    }
    return body._replace(marks=body.marks - held) if held else body


def look(
    robot: RobotSpec,
    before: Look,
    body: RobotState,
    numbers: Numbers,
    diameter_m: float | None,
    now: float,
) -> LookResult:
    """Compare what is declared with the sensors at this moment.

    Args:
        robot: The robot.
        before: What was known so far.
        body: What the robot is declared to be.
        numbers: Signals in SI.
        diameter_m: Of the pipe; None where it is not known.
        now: Time in seconds.
    """
    open_: list[Watched] = []
    confirmed: set[Mark] = set()
    for each in before.marks:
        if each.mark not in body.marks:
            continue
        verdict = _verdict(robot, before, body, each.mark, numbers, diameter_m)
        agrees_s = _since(each.agrees_s, verdict.agrees, now)
        against_s = _since(each.against_s, bool(verdict.against), now)
        if verdict.agrees and has_come(now, agrees_s + verdict.for_s):
            confirmed.add(each.mark)
        else:
            open_.append(Watched(each.mark, agrees_s, against_s, verdict.against, verdict.for_s))
    if open_ and not has_come(now, before.until_s):
        return LookResult(before._replace(marks=tuple(open_)), frozenset(confirmed))
    wrong = [each for each in open_ if has_come(now, each.against_s + each.for_s)]
    turning = any(
        isinstance(_spec(robot, states_of(robot, body), each.mark), StandingSpec | DrivenSpec)
        for each in wrong
    )
    told = tuple(f"{_declared(robot, body, each.mark)}, but {each.told}" for each in wrong)
    return LookResult(None, frozenset(confirmed), told, turning)


def parts_left_open(robot: RobotSpec, body: RobotState) -> tuple[str, ...]:
    """Return the parts that are declared to hold and that the sensors have not confirmed."""
    open_ = sorted(m.which for m in body.marks if m.kind == "part" and m.command == DECLARED)
    return tuple(robot.parts[part] for part in open_)


# --- inside ---------------------------------------------------------------------------------


def _since(since_s: float, holds: bool, now: float) -> float:
    if not holds:
        return nan
    return now if isnan(since_s) else since_s


def _spec(robot: RobotSpec, names: tuple[str, ...], mark: Mark) -> SeenSpec | HeldSpec | None:
    sight = robot.sight
    if mark.kind == "part":
        return sight.parts[mark.which] if sight.parts else None
    return sight.states[mark.which].get(names[mark.which]) if sight.states else None


def _declared(robot: RobotSpec, body: RobotState, mark: Mark) -> str:
    names = states_of(robot, body)
    if mark.kind == "region":
        return f"{robot.regions[mark.which]} is declared {names[mark.which]}"
    states = ", ".join(
        f"{robot.regions[each]} {names[each]}" for each in sorted(robot.part_regions[mark.which])
    )
    return f"the {robot.parts[mark.which]} part is declared to hold ({states})"


def _verdict(
    robot: RobotSpec,
    look: Look,
    body: RobotState,
    mark: Mark,
    numbers: Numbers,
    diameter_m: float | None,
) -> SensorVerdict:
    gripping = _gripping(robot, body, mark, numbers, diameter_m)
    if gripping is not None:
        return gripping
    spec = _spec(robot, states_of(robot, body), mark)
    match spec:
        case HeldSpec():
            return _held(robot, look.setpoints, body, spec, numbers, diameter_m)
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
