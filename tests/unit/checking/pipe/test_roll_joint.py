"""The roll joint turns the side that does not hold, and relaxed parts stay wound until sought."""

from __future__ import annotations

from dataclasses import replace
from math import isnan

import pytest

from pirate_sm.checking.actuation_in_force import InForce
from pirate_sm.checking.pipe.robot_in_pipe import PartRolls, RollJoint
from pirate_sm.core.loading import LoadedRobot, load_robot
from pirate_sm.core.robot import RobotSpec

from ..robots import NEWT, PIRATE


@pytest.fixture(scope="module")
def loaded() -> LoadedRobot:
    return load_robot(PIRATE)


@pytest.fixture(scope="module")
def robot(loaded: LoadedRobot) -> RobotSpec:
    return loaded.normal


@pytest.fixture(scope="module")
def joint(loaded: LoadedRobot, robot: RobotSpec) -> RollJoint:
    return RollJoint(InForce(loaded.profile, robot))


def course(robot: RobotSpec, *commands: str) -> list[tuple[int, int, int]]:
    """Configuration before, command and configuration after, from the initial one on."""
    found, now = [], robot.table.initial
    for name in commands:
        command = robot.table.command_index[name]
        after = robot.table.follow(now, command)
        assert after != now, name
        found.append((now, command, after))
        now = after
    return found


def rolls(robot: RobotSpec, joint: RollJoint, *commands: str) -> PartRolls | None:
    now: PartRolls | None = PartRolls()
    for before, _, after in course(robot, *commands):
        now = joint.after(now, before, after)
    return now


REAR = ("ClampRear",)
FRONT = ("ClampFront",)


@pytest.mark.parametrize(
    ("commands", "ahead", "behind"),
    [
        ((*REAR, "AlignRight"), 1, 0),
        ((*REAR, "AlignLeft"), -1, 0),
        ((*REAR, "AlignLeft", "AlignRight"), 1, 0),
        ((*FRONT, "AlignRight"), 0, -1),
        ((*REAR, "AlignRight", "ClampFront", "RelaxRear", "AlignStraight"), 1, 1),
        ((*REAR, "AlignRight", "ClampFront", "RelaxRear", "AlignLeft"), 1, 2),
        ((*REAR, "AlignStraight"), 0, 0),
    ],
)
def test_the_side_that_does_not_hold_turns(
    robot: RobotSpec, joint: RollJoint, commands: tuple[str, ...], ahead: float, behind: float
) -> None:
    assert rolls(robot, joint, *commands) == PartRolls(ahead, behind)


def test_nobody_knows_how_a_robot_turns_that_holds_nowhere(
    robot: RobotSpec, joint: RollJoint
) -> None:
    assert rolls(robot, joint, "AlignRight") is None
    assert rolls(robot, joint, *REAR, "Reset") is None
    assert rolls(robot, joint, *REAR, "Reset", "ClampRear") is None


def test_the_angle_of_the_joint_is_that_between_its_sides() -> None:
    assert PartRolls(1, 2).joint == -1
    assert PartRolls(-1, 2).joint == 1
    assert PartRolls().turned(3, ahead=True) == PartRolls(-1, 0)
    assert PartRolls(0, 1).turned(1, ahead=False) == PartRolls()


def test_a_command_is_known_by_the_angle_that_it_turns_to(joint: RollJoint) -> None:
    assert joint.commands_to(1) == ("AlignRight",)
    assert joint.commands_to(-1) == ("AlignLeft",)
    assert joint.commands_to(0) == ("AlignStraight",)
    assert joint.commands_to(2) == ()


def test_an_angle_known_only_during_the_run_is_one_turn_with_an_unknown_aim(
    loaded: LoadedRobot, robot: RobotSpec
) -> None:
    region = robot.regions.index("RotationState")
    states = dict(robot.actuation[region])
    (stage,) = states["AlignedRight"]
    states["AlignedRight"] = (tuple(write._replace(share_of=0) for write in stage),)
    actuation = (*robot.actuation[:region], states, *robot.actuation[region + 1 :])
    joint = RollJoint(InForce(loaded.profile, replace(robot, actuation=actuation)))
    right, hold, relax = course(robot, *REAR, "AlignRight", "ClampFront", "RelaxRear")[1:]

    aim = joint.aim(right[2])
    assert aim is not None
    assert isnan(aim)
    assert joint.turns(right[0], right[2])
    assert not joint.turns(hold[0], hold[2])
    assert not joint.turns(relax[0], relax[2])
    assert joint.after(PartRolls(), right[0], right[2]) is None


@pytest.mark.parametrize(
    ("commands", "wound"),
    [
        (("ClampFront", "ClampRear"), set()),
        (("ClampFront", "ClampRear", "RelaxFront"), {"front"}),
        (("ClampFront", "ClampRear", "RelaxFront", "ToggleLighting"), {"front"}),
        (("ClampFront", "ClampRear", "RelaxFront", "ClampFront"), set()),
        (("ClampFront", "ClampRear", "RelaxFront", "BendInto"), set()),
        (("ClampFront", "ClampRear", "RelaxFront", "AlignRight"), set()),  # by its posture
        (("ClampFront", "ClampRear", "Reset"), set()),
    ],
)
def test_a_relaxed_part_stays_wound_until_its_joints_are_sought(
    robot: RobotSpec, joint: RollJoint, commands: tuple[str, ...], wound: set[str]
) -> None:
    found = frozenset[int]()
    for before, command, after in course(robot, *commands):
        found = joint.wound(found, before, command, after)

    assert {robot.parts[part] for part in found} == wound


def test_a_robot_without_a_roll_joint_never_turns() -> None:
    loaded = load_robot(NEWT)
    robot = loaded.normal
    joint = RollJoint(InForce(loaded.profile, robot))

    assert joint.link == -1
    aims = [joint.aim(number) for number in range(len(robot.table.configurations))]
    assert set(aims) == {None}
    assert not any(aim is not None and isnan(aim) for aim in aims)
    assert joint.after(PartRolls(), 0, 1) == PartRolls()
