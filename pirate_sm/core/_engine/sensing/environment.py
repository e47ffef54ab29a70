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

from collections.abc import Collection, Sequence
from itertools import chain
from math import inf, isnan, nan, pi
from typing import NamedTuple, get_args

from pirate_sm.core._engine.records import Numbers, often_replaced
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import RobotState, confirmed_parts
from pirate_sm.core._engine.sensing import surveyor
from pirate_sm.core._engine.sensing.surveyor import NOISE_M, NOISE_RAD, has_moved
from pirate_sm.core._geometry.route import JointOrEnd
from pirate_sm.core.effects import Environment

# --- reports: whether two differ by more than noise, and how two become one -------------------


NOTHING_AROUND = Environment("", nan, nan, nan)

_NOISE_WAY_M = 0.1
"""Smaller changes of a distance are not reported."""


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
        or has_moved(old.roll_rad, new.roll_rad, NOISE_RAD, 2 * pi)
        or has_moved(old.pitch_rad, new.pitch_rad, NOISE_RAD, 0.0)
        or has_moved(old.opening_roll_rad, new.opening_roll_rad, NOISE_RAD, 2 * pi)
        or has_moved(old.diameter_m, new.diameter_m, NOISE_M, 0.0)
        or has_moved(old.diameter_ahead_m, new.diameter_ahead_m, NOISE_M, 0.0)
        or has_moved(old.distance_m, new.distance_m, _NOISE_WAY_M, 0.0)
        or has_moved(old.arc_m, new.arc_m, _NOISE_WAY_M, 0.0)
    )


# --- the joint around the robot ---------------------------------------------------------------


JOINTS: tuple[str, ...] = get_args(JointOrEnd)
"""The kinds of joints, and the end of the pipe."""

_REDUCER = "reducer"

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


# --- the survey -------------------------------------------------------------------------------


OUT, STRAIGHT, JOINT = SEGMENTS = ("Out", "Straight", "Joint")
"""The names of segments (thesis section 4-3-2)."""

_SEGMENTS = ("", *SEGMENTS)
"""The same by the numbers of :mod:`surveyor`."""


@often_replaced
class Surveyed(NamedTuple):
    """The memory of the survey.

    Attributes:
        reported: The last report, for comparison with the next one.
        forces: The last specific forces, each along the pipe, towards side B and up, m/s^2.
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
    forces: Numbers = ()
    felt_s: float = -inf
    part: int = -1
    in_bend: bool = False
    due_s: float = -inf
    outside_until_s: float = -inf
    straight_m: float = nan
    joint: Around = Around()
    outside: Environment = NOTHING_AROUND

    @property
    def merged_until_s(self) -> float:
        """Until when a report from outside counts that the last survey has met; else infinite."""
        return self.outside_until_s if self.due_s <= self.outside_until_s else inf


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
    in_bend = announced(robot, before, word)
    held = held_parts(robot, state, raised)
    memory = memory_of(robot, before, held, in_bend, word)
    surveyor.survey(now_s, numbers, *robot.body.rows, memory)
    segment, roll_rad, pitch_rad, diameter_m, ahead_m = memory[surveyor.SEGMENT : surveyor.SAID]
    around, joint = joint_around(robot, before.joint, word, in_bend, ahead_m)
    found = Environment(_SEGMENTS[int(segment)], roll_rad, pitch_rad, diameter_m, joint)
    if joint == _REDUCER:
        found = found._replace(diameter_ahead_m=ahead_m)
    return remembered(before, memory)._replace(joint=around), found


def memory_of(
    robot: RobotSpec, before: Surveyed, held: Collection[int], in_bend: bool, word: str | None
) -> list[float]:
    """Return the memory of :mod:`surveyor` before a survey.

    Args:
        robot: The robot.
        before: What is remembered.
        held: The held parts.
        in_bend: Whether a word has announced a bend that is not passed yet.
        word: The detector's valid word, if any.
    """
    said, forces, parts = before.reported, before.forces, range(len(robot.body.parts))
    marks = [(surveyor.HELD if part in held else 0.0, nan, nan) for part in parts]
    return [
        *(before.part, before.felt_s, before.straight_m, before.due_s, len(forces) // 3),
        *(in_bend, word is not None, robot.link.stale_after_s),
        *[nan] * (surveyor.SAID - surveyor.SEGMENT),
        _SEGMENTS.index(said.segment) if said.segment in _SEGMENTS else -1,
        *(said.roll_rad, said.pitch_rad, said.diameter_m),
        *forces,
        *[nan] * (surveyor.MARKS - surveyor.FORCES - len(forces)),
        *chain.from_iterable(marks),
    ]


def remembered(before: Surveyed, memory: Sequence[float]) -> Surveyed:
    """Return what is remembered after a survey, but for the joint; ``memory`` is that of it."""
    part, felt_s, straight_m, due_s, count, in_bend = memory[: surveyor.WORD]
    return before._replace(
        forces=tuple(memory[surveyor.FORCES : surveyor.FORCES + 3 * int(count)]),
        felt_s=felt_s,
        part=int(part),
        in_bend=bool(in_bend),
        due_s=due_s,
        straight_m=straight_m,
    )


def announced(robot: RobotSpec, before: Surveyed, word: str | None) -> bool:
    """Return whether a word has announced a bend that is not passed yet."""
    return before.in_bend if word is None else word not in robot.words_behind


def held_parts(robot: RobotSpec, state: RobotState, raised: frozenset[int]) -> list[int]:
    """Return the parts whose clamp is confirmed, and those that faults show to be open."""
    opened = robot.held[state.configuration] & robot.denied_by(raised).keys()
    return sorted(confirmed_parts(robot, state) | opened)
