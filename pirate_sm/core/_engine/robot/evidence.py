"""What shows a state or a clamp: the verdict of sensors at one moment, and evidence that is kept.

Evidence is the source, the time and the connection. That of a signal of a board is the board's last
report; nothing is stored for it. Only what outlives a report has evidence of its own. The age is
computed when it is asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import copysign, degrees, inf, isnan, nan
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.criteria import HeldSpec, SeenSpec
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import DECLARED, Mark, RobotState, states_of

# --- the verdict of sensors at one moment -----------------------------------------------------


_WRITTEN: Mapping[str, Callable[[float], str]] = {
    "deg": lambda value: f"{degrees(value):z.0f} deg",
    "rad/s": lambda value: f"{value:.2f} rad/s",
    "mNm": lambda value: f"{value * 1000:.0f} mNm",
    "mm": lambda value: f"{value * 1000:.0f} mm",
}
"""How values are shown, by their units there."""


class SensorVerdict(NamedTuple):
    """What the sensors show about a mark at one moment.

    Attributes:
        agrees: Whether they confirm it.
        against: What they show instead, with the limit; empty unless they contradict it.
        for_s: How long the agreement or contradiction must last.
    """

    agrees: bool
    against: str
    for_s: float = 0.0


class Shown(NamedTuple):
    """A signal that decides about a state: what was recorded, what it shows now, and the limit.

    All with units, for people.
    """

    signal: str
    recorded: str
    seen: str
    limit: str


def spec_of(robot: RobotSpec, names: tuple[str, ...], mark: Mark) -> SeenSpec | HeldSpec | None:
    """Return the criterion of a declared state or clamp; None where no sensor can show it."""
    sight = robot.sight
    if mark.kind == "part":
        return sight.parts[mark.which] if sight.parts else None
    return sight.states[mark.which].get(names[mark.which]) if sight.states else None


def kind_of(robot: RobotSpec, names: tuple[str, ...], mark: Mark) -> str:
    """Return the profile's word for how a declared state shows itself; ``held`` for a clamp.

    It is empty where no sensor can show it.
    """
    spec = spec_of(robot, names, mark)
    return "" if spec is None else "held" if isinstance(spec, HeldSpec) else spec.kind


def verdict(
    robot: RobotSpec,
    setpoints: Numbers,
    body: RobotState,
    mark: Mark,
    numbers: Numbers,
    diameter_m: float | None,
) -> SensorVerdict:
    """Return whether the sensors confirm or contradict a mark.

    Args:
        robot: The robot.
        setpoints: Setpoints of the declared configuration.
        body: The declared state of the robot.
        mark: The unconfirmed state or clamp.
        numbers: Signals in SI.
        diameter_m: Inner diameter of the pipe; None where it is unknown.
    """
    gripping = _gripping(robot, body, mark, numbers, diameter_m)
    if gripping is not None:
        return gripping
    spec = spec_of(robot, states_of(robot, body), mark)
    if isinstance(spec, HeldSpec):
        return _held(robot, setpoints, body, spec, numbers, diameter_m)
    if spec is None:
        return SensorVerdict(False, "")
    agrees = spec.needs is not None and all(need.holds(numbers) for need in spec.needs)
    against = [
        f"{robot.vocabulary.numbers[sign.bound.signal]} shows "
        f"{_WRITTEN[sign.unit](numbers[sign.bound.signal])}, {sign.otherwise}"
        for sign in spec.signs
        if sign.contradicts(numbers)
    ]
    return SensorVerdict(agrees, "; ".join(against), spec.for_s)


def shown_by(
    robot: RobotSpec,
    spec: SeenSpec | HeldSpec | None,
    before: Numbers,
    numbers: Numbers,
    diameter_m: float | None,
) -> tuple[Shown, ...]:
    """Return the signals that decide about a state, with the values before and now.

    Args:
        robot: The robot.
        spec: The criterion of the state.
        before: Signals as recorded, SI.
        numbers: Signals now, SI.
        diameter_m: Inner diameter of the pipe; None where it is unknown.
    """
    rows: list[tuple[int, str, str]] = []
    if isinstance(spec, HeldSpec):
        slack = f"slack below {spec.slack * 1000:.0f} mNm"
        rows = [
            (it.torque, "mNm", f"{it.needed_nm * 1000:.0f} mNm or more, {slack}")
            for it in spec.joints
        ]
        pipe = "the other parts" if diameter_m is None else f"{diameter_m * 1000:.0f} mm"
        limit = f"{pipe} within {spec.span:.0%}, off beyond {spec.span_off:.0%}"
        rows.append((spec.diameter, "mm", limit))
    elif spec is not None:
        rows = [(sign.bound.signal, sign.unit, sign.limit) for sign in spec.signs]
    names = robot.vocabulary.numbers
    return tuple(
        Shown(names[index], _cell(before[index], unit), _cell(numbers[index], unit), limit)
        for index, unit, limit in rows
    )


def _cell(value: float, unit: str) -> str:
    """Return a value in a table."""
    if isnan(value):
        return "unknown"
    return f"{degrees(value):.1f} deg" if unit == "deg" else _WRITTEN[unit](value)


def _gripping(
    robot: RobotSpec, body: RobotState, mark: Mark, numbers: Numbers, diameter_m: float | None
) -> SensorVerdict | None:
    """Return the contradiction if a part seems to hold although none is declared to; else None.

    A relaxed part may show the same torque, because a self-locking worm keeps its spring wound.
    The check therefore applies only where no part is declared to hold.
    """
    if mark.kind != "region" or robot.held[body.configuration]:
        return None
    declared = spec_of(robot, states_of(robot, body), mark)
    for part, spec in enumerate(robot.sight.parts):
        if spec is None or mark.which not in robot.part_regions[part]:
            continue
        if any(not abs(numbers[joint.rate]) < spec.still for joint in spec.joints):
            continue
        off = _span(robot, body, spec, numbers, diameter_m)
        unlike = _like_a_clamp(spec, numbers, off)
        if not unlike and diameter_m is not None and not _as_declared(declared, spec, numbers):
            unlike = _like_a_grip(robot, spec, numbers, off)
        if unlike:
            return SensorVerdict(False, f"the {robot.parts[part]} part {unlike}", spec.for_s)
    return None


def _like_a_clamp(spec: HeldSpec, numbers: Numbers, off: float) -> str:
    """Return what a part shows whose loaded joints all bear the torque of a clamp; else empty."""
    torques = [(abs(numbers[joint.torque]), joint.needed_nm) for joint in spec.joints]
    if off > spec.span_off or not all(torque >= needed for torque, needed in torques):
        return ""
    shown = ", ".join(str(round(torque * 1000)) for torque, _ in torques)
    limits = ", ".join(dict.fromkeys(f"{needed * 1000:.0f}" for _, needed in torques))
    return f"bears {shown} mNm like one that holds, limit {limits} mNm"


def _as_declared(declared: SeenSpec | HeldSpec | None, spec: HeldSpec, numbers: Numbers) -> bool:
    """Return whether the apex of the part has the angle of a state that holds nothing."""
    needs = declared.needs if isinstance(declared, SeenSpec) else None
    bounds = (bound for need in needs or () for bound in need.lacking)
    return any(bound.signal == spec.apex and bound.holds(numbers) for bound in bounds)


def _like_a_grip(robot: RobotSpec, spec: HeldSpec, numbers: Numbers, off: float) -> str:
    """Return what a part shows that spans the pipe and presses by its apex alone; else empty.

    Controls may hold with that torque. Only from the apex does a force reach the outer wheel. The
    other joint says nothing: it may bear the weight of a whole loose part.

    Args:
        robot: The robot.
        spec: The criterion of the part. Below its ``slack`` the part does not hold.
        numbers: Signals in SI.
        off: Relative error of the part's diameter; NaN where it is unknown.
    """
    if not off <= spec.span_off:
        return ""
    for joint in spec.joints:
        if robot.slots[joint.slot].angle != spec.apex:
            continue
        pressed = copysign(1.0, numbers[spec.apex]) * numbers[joint.torque]
        if pressed >= spec.slack:
            return (
                f"bears {pressed * 1000:.0f} mNm at {robot.vocabulary.numbers[spec.apex]}, "
                f"with which it may hold, limit {spec.slack * 1000:.0f} mNm"
            )
    return ""


def _held(
    robot: RobotSpec,
    setpoints: Numbers,
    body: RobotState,
    spec: HeldSpec,
    numbers: Numbers,
    diameter_m: float | None,
) -> SensorVerdict:
    borne = [_borne(setpoints[j.slot], numbers[j.torque]) for j in spec.joints]
    pairs = list(zip(borne, spec.joints, strict=True))
    firmly = all(torque >= joint.needed_nm for torque, joint in pairs)
    loaded = firmly or (spec.settled_s < inf and all(t >= it.least_nm for t, it in pairs))
    standing = all(abs(numbers[joint.rate]) < spec.still for joint in spec.joints)
    off = _span(robot, body, spec, numbers, diameter_m)
    against = []
    if off > spec.span_off:
        against.append(_span_against(robot, body, spec, numbers, diameter_m))
    if all(torque < spec.slack for torque in borne):
        names = ", ".join(robot.vocabulary.numbers[joint.torque] for joint in spec.joints)
        shown = ", ".join(str(round(torque * 1000)) for torque in borne)
        against.append(f"{names} show {shown} mNm, less than {spec.slack * 1000:.0f} mNm")
    agrees = loaded and standing and off <= spec.span
    # What contradicts need not last as long as a weak grip.
    for_s = spec.for_s if firmly or not agrees else spec.settled_s
    return SensorVerdict(agrees, "; ".join(against), for_s)


def _borne(setpoint: float, torque: float) -> float:
    """Return the torque in the direction of the state's setpoint."""
    return torque if setpoint > 0 else -torque if setpoint < 0 else abs(torque)


def _span(
    robot: RobotSpec, body: RobotState, spec: HeldSpec, numbers: Numbers, diameter_m: float | None
) -> float:
    """Return the relative error of the part's diameter.

    It is infinite if the part touches no wall, and NaN if a diameter is unknown.
    """
    shown = numbers[spec.diameter]
    if abs(numbers[spec.apex]) >= spec.open_rad:
        return inf
    if diameter_m is not None:
        return abs(shown - diameter_m) / diameter_m
    known = [numbers[other] for other in others_that_hold(robot, body.configuration, spec)]
    if isnan(shown) or any(map(isnan, known)):
        return nan
    return max([abs(shown - each) / each for each in known], default=0.0)


def _span_against(
    robot: RobotSpec, body: RobotState, spec: HeldSpec, numbers: Numbers, diameter_m: float | None
) -> str:
    """Return a sentence that explains why the diameter of a part contradicts that it holds."""
    names, shown = robot.vocabulary.numbers, numbers[spec.diameter]
    shows = f"{names[spec.diameter]} shows {shown * 1000:.0f} mm"
    limit = f"limit {spec.span_off:.0%} off"
    if abs(numbers[spec.apex]) >= spec.open_rad:
        return f"{shows}, it has opened to its end stop"
    if diameter_m is not None:
        return f"{shows}, the pipe has {diameter_m * 1000:.0f} mm, {limit}"
    others = others_that_hold(robot, body.configuration, spec)
    worst = max(others, key=lambda other: abs(shown - numbers[other]) / numbers[other])
    return f"{shows}, {names[worst]} {numbers[worst] * 1000:.0f} mm, {limit}"


def others_that_hold(robot: RobotSpec, configuration: int, spec: HeldSpec) -> list[int]:
    """Return the number indexes of the diameters of the other parts that hold."""
    sights = [robot.sight.parts[part] for part in robot.held[configuration]]
    return [each.diameter for each in sights if each is not None and each is not spec]


# --- evidence that is kept --------------------------------------------------------------------


Source: TypeAlias = Literal["sensor", "echo", "person", "assumption", "nothing"]
"""What has shown something. An echo shows that an array has arrived, never what it has moved."""


SHOWN: Mapping[Source, str] = {
    "sensor": "shown by sensors",
    "echo": "setpoints confirmed",
    "person": "declared",
    "assumption": "assumed",
    "nothing": "shown by nothing",
}
"""How each source has shown something, for people."""


class Evidence(NamedTuple):
    """The evidence of one state, signal or place.

    Attributes:
        at_s: When it was shown, by the engine's clock; NaN if nothing has shown it.
        connection: In which connection, see :attr:`.Sensing.connection`.
    """

    source: Source
    at_s: float
    connection: int

    def age_s(self, now_s: float) -> float:
        """Return how old it is, s; NaN if nothing has shown it."""
        return now_s - self.at_s

    def in_words(self, now_s: float) -> str:
        """Return it for people, with its age."""
        ago = "" if isnan(self.at_s) else f" {self.age_s(now_s):.1f} s ago"
        return f"{SHOWN[self.source]}{ago}"


NOTHING = Evidence("nothing", nan, 0)
"""Nothing has shown it."""


Proofs = tuple[Evidence, ...]
"""The evidence of each region's state, then of each part's clamp."""


def proofs_at_start(robot: RobotSpec, body: RobotState, now: Evidence) -> Proofs:
    """Return the evidence at the start of a run: what a person has declared, or is assumed."""
    said = now._replace(source="person"), now._replace(source="assumption")
    return tuple(
        (said[doubt is None] if state else NOTHING) for _, state, doubt in _believed(robot, body)
    )


def proofs_after(
    robot: RobotSpec, before: RobotState, after: RobotState, proofs: Proofs, now: Evidence
) -> Proofs:
    """Return the evidence after a step.

    Args:
        robot: The robot.
        before: The robot's state before the step.
        after: Its state after the step.
        proofs: The evidence before the step.
        now: The evidence of what sensors have shown in this step.
    """
    found = list(proofs)
    both = zip(_believed(robot, before), _believed(robot, after), strict=True)
    for at, ((_, earlier, doubted), (declared, state, doubt)) in enumerate(both):
        if (earlier, doubted) == (state, doubt):
            continue
        if not state or (doubt is not None and doubt.command < DECLARED):
            found[at] = NOTHING
        elif doubt is None:
            motion = before.motion
            given = declared._replace(command=motion.command) if motion else declared
            echoed = _proof(robot, after, doubted or given) == "echo"
            found[at] = now._replace(source="echo") if echoed else now
        elif doubt.command >= 0:
            found[at] = now._replace(source="echo")
        # What is declared, or stopped, was known before: by older evidence.
    return tuple(found)


def _proof(robot: RobotSpec, body: RobotState, cause: Mark) -> str:
    """Return what confirms a state: by its command's criterion, or by that for what is declared."""
    if cause.command >= 0:
        return robot.commands[cause.command].proof
    kind = kind_of(robot, states_of(robot, body), cause)
    return "echo" if kind == "accepted" else "sensor"


def _believed(robot: RobotSpec, body: RobotState) -> Iterator[tuple[Mark, str, Mark | None]]:
    """Yield each region and part as one declared, with its state, and its mark if it has one."""
    marks = {(mark.kind, mark.which): mark for mark in sorted(body.marks)}
    held = robot.held[body.configuration]
    for region, name in enumerate(states_of(robot, body)):
        yield Mark("region", region, DECLARED), name, marks.get(("region", region))
    for part in range(len(robot.parts)):
        holds = "holds" if part in held else ""
        yield Mark("part", part, DECLARED), holds, marks.get(("part", part))
