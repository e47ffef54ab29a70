"""Derive the pipe around the robot from its signals and the detector's words (thesis alg. 5).

- *Diameter*: mean of the parts whose clamp is confirmed, h + 2r (eq. 3-2). In a bend a part counts
  only if it shows the diameter of the straight before: a part that stands across the bend shows
  another diameter, and its axis differs from the pipe's.
- *Pitch and roll*: from the accelerometer, rotated into the axis of the pipe. A clamped part lies
  along the pipe; the joint angles in between give the heading of the accelerometer's link.
- *Segment*: ``Joint`` from the first word of a bend until the one that says that the whole robot
  is beyond it, and wherever two clamped parts lie along different axes; ``Out`` where every
  clamped part has opened to its end stop, so that there is no wall; ``Straight`` where a part has
  a wall and no bend has been announced.
- *Joint*: a detector's word announces it, or two clamped parts show a reducer: different diameters
  although both lie along one axis. A part across a mitre or an elbow shows another diameter too,
  but its axis is turned.

An unknown value is NaN, an unknown word is empty. A report from outside replaces the derived
values that it knows for as long as it is valid.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, hypot, inf, isnan, nan, pi, radians, remainder
from statistics import median
from typing import NamedTuple, get_args

from pirate_sm.core._engine.records import often_replaced
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import RobotState, confirmed_parts
from pirate_sm.core._engine.sensing.body_spec import BodySpec
from pirate_sm.core._geometry.plane import turned
from pirate_sm.core._geometry.route import JointOrEnd
from pirate_sm.core._geometry.space import GRAVITY_M_S2, Vector
from pirate_sm.core._model.effects import Environment

# --- reports: whether two differ by more than noise, and how two become one -------------------


NOTHING_AROUND = Environment("", nan, nan, nan)

NOISE_RAD, NOISE_M, _NOISE_WAY_M = radians(1), 1e-3, 0.1
"""Smaller changes are not reported."""


def merged(derived: Environment, outside: Environment) -> Environment:
    """Return the report from outside, with what it does not know as it was derived."""
    known = {
        name: value
        for name, value in outside._asdict().items()
        if (not isnan(value) if isinstance(value, float) else value)
    }
    return derived._replace(**known)


def differs(old: Environment, new: Environment) -> bool:
    """Return whether two reports differ by more than noise."""
    return (
        (old.segment, old.joint, old.junction, old.run)
        != (new.segment, new.joint, new.junction, new.run)
        or _has_moved(old.roll_rad, new.roll_rad, NOISE_RAD, turn=2 * pi)
        or _has_moved(old.pitch_rad, new.pitch_rad, NOISE_RAD)
        or _has_moved(old.opening_roll_rad, new.opening_roll_rad, NOISE_RAD, turn=2 * pi)
        or _has_moved(old.diameter_m, new.diameter_m, NOISE_M)
        or _has_moved(old.diameter_ahead_m, new.diameter_ahead_m, NOISE_M)
        or _has_moved(old.distance_m, new.distance_m, _NOISE_WAY_M)
        or _has_moved(old.arc_m, new.arc_m, _NOISE_WAY_M)
    )


def _has_moved(old: float, new: float, noise: float, turn: float = inf) -> bool:
    """Return whether a value has changed by more than noise, or became known or unknown."""
    if isnan(old) or isnan(new):
        return isnan(old) != isnan(new)
    return abs(remainder(new - old, turn)) > noise


# --- the joint around the robot ---------------------------------------------------------------


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


def _step_ahead_m(body: BodySpec, parts: Sequence[int], numbers: Sequence[float]) -> float:
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


# --- the survey -------------------------------------------------------------------------------


OUT, STRAIGHT, JOINT = SEGMENTS = ("Out", "Straight", "Joint")
"""The names of segments (thesis section 4-3-2)."""

SURVEY_EVERY_S = 0.2
"""Frequent enough at 0.1 m/s, and rare compared with the cost of one evaluation [decided]."""

SAMPLES = 9
"""Length of the median filter of accelerations; it removes the jolts of motors [decided]."""

AT_REST = 0.1
"""Largest relative deviation from gravity of an acceleration that counts as its direction."""

UPRIGHT = 0.2
"""With a smaller share of gravity across the pipe (78 deg), the roll is undefined."""

TURNED_RAD = radians(20)
"""Two clamped parts whose axes differ by more are in different legs of the pipe [decided]."""

COPLANAR_RAD = radians(10)
"""Headings of parts are compared only up to this roll between them."""

LEAST_SAMPLES = 5
"""Roll and pitch are unknown with fewer accelerations."""

AGREEING = 0.03
"""Largest relative difference of the diameters of parts in one straight [decided]."""

OPEN_RAD = radians(2)
"""A clamped V nearer to its end stop touches no wall [decided]."""

_NO_FORCE: Vector = (nan, nan, nan)


@often_replaced
class Surveyed(NamedTuple):
    """The memory of the survey.

    Attributes:
        reported: The last report, for comparison with the next one.
        forces: The last specific forces along the pipe, towards side B and up, m/s^2.
        felt_s: When the last force was measured.
        part: The clamped part that gives the pipe's axis; -1 without one.
        in_bend: Whether a word has announced a bend that is not passed yet.
        due_s: When the survey is due again.
        outside_until_s: End of the validity of a report from outside.
        straight_m: Diameter of the last straight; NaN before the first.
        joint: What is remembered of the joint around the robot.
        outside: The last report from outside.
    """

    reported: Environment = NOTHING_AROUND
    forces: tuple[Vector, ...] = ()
    felt_s: float = -inf
    part: int = -1
    in_bend: bool = False
    due_s: float = -inf
    outside_until_s: float = -inf
    straight_m: float = nan
    joint: Around = Around()
    outside: Environment = NOTHING_AROUND


def nothing_surveyed(*, nominal: bool) -> Surveyed:
    """Return the initial memory; without sensors (``nominal``) the survey is never due."""
    return Surveyed(due_s=inf) if nominal else Surveyed()


def survey(
    robot: RobotSpec,
    before: Surveyed,
    state: RobotState,
    numbers: Sequence[float],
    word: str | None,
    raised: frozenset[int],
    now_s: float,
) -> tuple[Surveyed, Environment]:
    """Return the updated memory, and the surroundings derived from signals and words.

    Args:
        robot: The robot.
        before: The memory so far.
        state: The commanded state of the robot.
        numbers: Every signal in SI; NaN is unknown.
        word: The detector's valid word, if any.
        raised: Indexes of the raised fault rules.
        now_s: The time.
    """
    body = robot.body
    in_bend = announced(robot, before, word)
    held = held_parts(robot, state, raised)
    walled = [part for part in held if not _is_open(body, part, numbers)]
    segment = ""
    if word is not None and in_bend:
        segment = JOINT
    elif held and not walled:
        segment = OUT
    elif walled:
        segment = _segment(body, walled, numbers, in_bend)
    ahead_m = _step_ahead_m(body, walled, numbers) if segment == STRAIGHT else nan
    around, joint = joint_around(robot, before.joint, word, in_bend, ahead_m)
    along = _along(body, walled, numbers, before.straight_m)
    if segment == STRAIGHT:
        along = along or walled
    else:
        walled = along
    part = before.part if before.part in along else along[0] if along else -1
    forces, felt_s = _felt(robot, before, part, numbers, now_s)
    diameter_m = _diameter(body, walled, numbers)
    known = segment == STRAIGHT and not isnan(diameter_m)
    straight_m = diameter_m if known else before.straight_m
    after = Surveyed(
        before.reported,
        forces,
        felt_s,
        part,
        in_bend,
        now_s + SURVEY_EVERY_S,
        before.outside_until_s,
        straight_m,
        around,
        before.outside,
    )
    found = Environment(segment, *_attitude(forces), diameter_m, joint)
    return after, found._replace(diameter_ahead_m=ahead_m) if joint == "reducer" else found


def announced(robot: RobotSpec, before: Surveyed, word: str | None) -> bool:
    """Return whether a word has announced a bend that is not passed yet."""
    return before.in_bend if word is None else word not in robot.words_behind


def held_parts(robot: RobotSpec, state: RobotState, raised: frozenset[int]) -> list[int]:
    """Return the parts whose clamp is confirmed, and those that faults show to be open."""
    opened = robot.held[state.configuration] & robot.denied_by(raised).keys()
    return sorted(confirmed_parts(robot, state) | opened)


def _along(
    body: BodySpec, parts: list[int], numbers: Sequence[float], straight_m: float
) -> list[int]:
    """Return the parts that lie along the pipe, because they show the last straight's diameter.

    While that diameter is unknown, two parts are compared with each other, and a single part does
    not count.
    """
    if isnan(straight_m):
        return parts if len(parts) > 1 else []
    shown = [(part, body.parts[part].diameter) for part in parts]
    return [
        part
        for part, diameter in shown
        if diameter >= 0 and abs(numbers[diameter] - straight_m) <= AGREEING * straight_m
    ]


def _segment(body: BodySpec, walled: Sequence[int], numbers: Sequence[float], in_bend: bool) -> str:
    """Return the segment around a clamped robot while no word announces a bend."""
    if len(walled) > 1 and _turn(body, walled, numbers) > TURNED_RAD:
        return JOINT
    return "" if in_bend else STRAIGHT


def _turn(body: BodySpec, parts: Sequence[int], numbers: Sequence[float]) -> float:
    """Return the largest angle between the axes of the parts, rad; 0 if it is unknown."""
    roll = body.imu.roll if body.imu else -1
    if roll >= 0 and not abs(numbers[roll]) <= COPLANAR_RAD:
        return 0.0
    headings = [body.heading_in_pipe(numbers, part, 0) for part in parts]
    known = [heading for heading in headings if not isnan(heading)]
    return max(known, default=0.0) - min(known, default=0.0)


def _is_open(body: BodySpec, part: int, numbers: Sequence[float]) -> bool:
    vee = body.parts[part]
    return vee.angle >= 0 and abs(numbers[vee.angle]) > vee.end_stop_rad - OPEN_RAD


def _diameter(body: BodySpec, parts: Sequence[int], numbers: Sequence[float]) -> float:
    """Return the mean inner diameter that the parts show, m; NaN if it is unknown or they differ.

    A part that stands across a bend shows a diameter that is not the pipe's.
    """
    shown = [numbers[body.parts[part].diameter] for part in parts if body.parts[part].diameter >= 0]
    known = [diameter for diameter in shown if not isnan(diameter)]
    if not known or max(known) - min(known) > AGREEING * max(known):
        return nan
    return sum(known) / len(known)


def _felt(
    robot: RobotSpec, before: Surveyed, part: int, numbers: Sequence[float], now_s: float
) -> tuple[tuple[Vector, ...], float]:
    """Return the last specific forces in the axes of the pipe, and the time of the last."""
    forces = before.forces if part == before.part else ()
    force = in_pipe(robot.body, part, numbers) if part >= 0 else _NO_FORCE
    if is_gravity(force):
        return (*forces, force)[-SAMPLES:], now_s
    lasting = now_s - before.felt_s < robot.link.stale_after_s
    return (forces if lasting else ()), before.felt_s


def is_gravity(force: Vector) -> bool:
    """Return whether a specific force is that of a robot at rest; False where it is unknown."""
    return abs(hypot(*force) - GRAVITY_M_S2) <= AT_REST * GRAVITY_M_S2


def in_pipe(body: BodySpec, part: int, numbers: Sequence[float]) -> Vector:
    """Return the specific force along the axis of a clamped part, towards its side B, and up.

    A clamped part holds the accelerometer's link obliquely: that angle is taken off.
    """
    imu = body.imu
    if imu is None:
        return _NO_FORCE
    ahead, side_b, up = (numbers[axis] for axis in imu.axes)
    if imu.roll >= 0 and body.parts[part].wheels[0] > imu.link:
        # The part is behind the roll joint, the accelerometer ahead of it.
        side_b, up = turned((side_b, up), -numbers[imu.roll])
    return *turned((ahead, side_b), -body.heading_in_pipe(numbers, part, imu.link)), up


def _attitude(forces: Sequence[Vector]) -> tuple[float, float]:
    """Return roll and pitch (B-13 and B-14), rad; NaN where they are unknown."""
    if len(forces) < LEAST_SAMPLES:
        return nan, nan
    along, side_b, up = (median(values) for values in zip(*forces, strict=True))
    across = hypot(side_b, up)
    roll = atan2(-side_b, up) if across > UPRIGHT * GRAVITY_M_S2 else nan
    return roll, atan2(along, across)
