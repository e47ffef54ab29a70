"""When a command is refused, and by which of the two words (decisions, section 3)."""

from __future__ import annotations

from dataclasses import replace

import pytest
from driving import (
    BOTH_CLAMPED,
    DRIVING_FORWARD,
    FRONT_CLAMPED,
    IDLE,
    PIRATE,
    REAR_CLAMPED,
    command,
)

from pirate_sm.core._engine.robot.command_outcome import refusal
from pirate_sm.core._engine.robot.robot_state import DECLARED, STOPPED, Mark, at_rest_in
from pirate_sm.core._loading.robot.loader import load_robot
from pirate_sm.core._model.events import Skip

FRONT_HELD = {
    "FrontClampedRearRelaxed",
    "DoubleClamped",
    "FrontClampedRearBending",
    "FrontClampedRearBendingBack",
}
REAR_HELD = {
    "RearClampedFrontRelaxed",
    "DoubleClamped",
    "RearClampedFrontBending",
    "RearClampedFrontBendingBack",
}
DRIVING = {"DrivingForward", "DrivingBackward"}
REAR_ONLY = ("RearClampedFrontRelaxed", "Unaligned", "Off")


def is_so_already(name: str, front: str, rear: str, bend: str, rotation: str, light: str) -> bool:
    """What section 3 says that each command asks for."""
    wheels = {front, rear}
    asked = {
        "ClampFront": bend in FRONT_HELD,
        "ClampRear": bend in REAR_HELD,
        "RelaxFront": bend in {"Unclamped", "RearClampedFrontRelaxed"},
        "RelaxRear": bend in {"Unclamped", "FrontClampedRearRelaxed"},
        "BendInto": bend in {"RearClampedFrontBending", "FrontClampedRearBending"},
        "BendBack": bend in {"RearClampedFrontBendingBack", "FrontClampedRearBendingBack"},
        "DriveForward": "DrivingForward" in wheels,
        "DriveBackward": "DrivingBackward" in wheels,
        "Brake": not wheels & DRIVING,
        "AlignStraight": rotation == "AlignedStraight",
        "AlignLeft": rotation == "AlignedLeft",
        "AlignRight": rotation == "AlignedRight",
        "ToggleLighting": False,
        "Reset": (front, rear, bend, rotation, light)
        == ("Free", "Free", "Unclamped", "Unaligned", "Off"),
    }
    return asked[name]


BENT = "impossible: a bent part does not turn; clamp it, or relax it first"


def test_in_every_configuration_each_command_moves_or_is_refused_by_the_right_word():
    robot = load_robot(PIRATE).normal
    counted = {"moves": 0, "bent": 0, "unneeded": 0, "impossible": 0}

    for here, states in enumerate(robot.table.configurations):
        for number, name in enumerate(robot.table.commands):
            reason = refusal(robot, at_rest_in(robot, here), number)
            if robot.table.follow(here, number) != here:
                bent = name.startswith("Align") and "Bending" in states[2]
                assert reason == (BENT if bent else ""), (states, name)
                counted["bent" if bent else "moves"] += 1
            else:
                word = "unneeded" if is_so_already(name, *states) else "impossible"
                assert reason.startswith(f"{word}: "), (states, name, reason)
                counted[word] += 1

    assert counted["moves"] + counted["bent"] == 1173
    assert sum(counted.values()) == 2464


def test_only_reset_reaches_the_state_that_operation_must_never_enter():
    table = load_robot(PIRATE).table
    bending = table.regions.index("BendingState")
    leading = {
        table.commands[number]
        for here, states in enumerate(table.configurations)
        for number in range(len(table.commands))
        if states[bending] != "Unclamped"
        and table.configurations[table.follow(here, number)][bending] == "Unclamped"
    }

    assert leading == {"Reset"}


@pytest.mark.parametrize(
    ("states", "name", "reason"),
    [
        (FRONT_CLAMPED, "ClampFront", "unneeded"),
        (FRONT_CLAMPED, "RelaxFront", "impossible: it needs BendingState in (DoubleClamped,"),
        (
            {},
            "DriveForward",
            "impossible: it needs FrontWheelsState in (Fixed, DrivingBackward), or ",
        ),
        (
            DRIVING_FORWARD,
            "RelaxRear",
            "impossible: it needs FrontWheelsState != DrivingForward and ",
        ),
        (BOTH_CLAMPED, "AlignLeft", "impossible: it needs BendingState != DoubleClamped"),
        ({}, "AlignOther", "impossible: there is no such command"),
        ({}, "clampfront", "impossible: there is no such command"),
    ],
)
def test_a_refusal_says_what_the_command_needs(drive, states, name, reason):
    driver = drive(IDLE, states=states)

    command(driver, name)

    assert driver.last_status.status == "refused"
    assert driver.last_status.reason.startswith(reason)
    assert not driver.in_flight, "nothing is sent"


def test_an_unconfirmed_clamp_is_no_clamp(drive):
    driver = drive(IDLE, states=REAR_CLAMPED)
    driver.report_all(0.1)
    command(driver, "ClampFront")
    driver.accept()
    driver.run(50.0)  # no torque ever comes
    assert driver.statuses[-1] == ("ClampFront", "failed")
    assert driver.states["BendingState"] == "DoubleClamped"

    command(driver, "RelaxRear")

    assert driver.last_status.reason == (
        "impossible: it would let go of the last confirmed clamp (rear); "
        "front: no sensor has shown that it holds"
    )
    command(driver, "RelaxFront")  # the other way round it is safe
    assert driver.statuses[-1] == ("RelaxFront", "sent")


def test_what_a_part_depends_on_stays_unconfirmed_with_it(drive):
    driver = drive(IDLE)
    driver.report_all(0.1)
    command(driver, "ClampFront")
    driver.accept()
    driver.run(50.0)
    command(driver, "ClampRear")
    driver.until_done("ClampRear")

    assert driver.states["BendingState"] == "DoubleClamped"
    assert driver.unconfirmed == {"FrontWheelsState", "BendingState"}
    command(driver, "ClampFront")
    driver.until_done("ClampFront")
    assert driver.unconfirmed == set()


def test_it_stays_unconfirmed_whatever_other_command_comes_between(drive):
    driver = drive(IDLE, states=REAR_CLAMPED)
    driver.report_all(0.1)
    command(driver, "ClampFront")
    driver.accept()
    driver.run(50.0)
    command(driver, "ToggleLighting")
    driver.until_done("ToggleLighting")

    command(driver, "RelaxRear")

    assert "last confirmed clamp (rear)" in driver.last_status.reason


def test_a_clamp_that_was_passed_over_is_no_clamp_either(drive):
    mission = """\
start: hold
phases:
  hold: {do: [ClampRear, ClampFront, RelaxRear], go: held, on_failure: idle}
  idle: {wait: [{operator: x, go: held}], within: {time: 1 h, go: held}}
ends: {held: {succeed: Held}}
"""
    driver = drive(mission)
    driver.until_sent("ClampFront")
    driver.accept()

    driver.give(Skip())

    assert ("ClampFront", "skipped") in driver.statuses
    assert driver.statuses[-1] == ("RelaxRear", "refused")
    assert "last confirmed clamp (rear)" in driver.last_status.reason


def test_the_same_command_again_is_purposeful_after_a_failure(drive):
    driver = drive(IDLE)
    driver.report_all(0.1)
    command(driver, "ClampFront")
    driver.accept()
    driver.run(50.0)
    assert driver.unconfirmed == {"FrontWheelsState", "BendingState"}

    command(driver, "ClampFront")
    driver.until_done("ClampFront")

    assert driver.unconfirmed == set()
    command(driver, "ClampFront")
    assert driver.last_status.reason == "unneeded: it is so already"


def test_reset_may_open_the_last_clamp(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)

    command(driver, "Reset")

    assert driver.statuses[-1] == ("Reset", "sent")


def test_clamping_is_open_even_when_nothing_is_confirmed(drive):
    driver = drive(IDLE)
    driver.report_all(0.1)
    command(driver, "ClampFront")
    driver.accept()
    driver.run(50.0)

    command(driver, "ClampRear")

    assert driver.statuses[-1] == ("ClampRear", "sent")


def test_one_command_at_a_time(drive):
    driver = drive(IDLE)
    command(driver, "ClampFront")

    command(driver, "ToggleLighting")
    assert driver.last_status.reason == "impossible: another command is under way"
    driver.accept()
    command(driver, "ToggleLighting")
    assert driver.last_status.reason == "impossible: another command is under way"


def test_nothing_drives_on_a_clamp_that_is_not_confirmed():
    robot = load_robot(PIRATE).normal
    held = at_rest_in(robot, robot.table.index_of(("Free", "Fixed", *REAR_ONLY)))
    drive, clamp = (robot.table.command_index[name] for name in ("DriveForward", "ClampRear"))
    rear = robot.parts.index("rear")
    doubtful = held._replace(marks=frozenset({Mark("part", rear, clamp)}))

    assert refusal(robot, held, drive) == ""
    assert refusal(robot, doubtful, drive) == (
        "impossible: no clamp is confirmed to drive with; rear: no sensor has shown that it holds"
    )


def marked(robot, states, *marks):
    """The robot in a configuration of which so much is not confirmed."""
    return at_rest_in(robot, robot.table.index_of(states))._replace(marks=frozenset(marks))


def why_not(robot, body, name):
    return refusal(robot, body, robot.table.command_index[name])


def test_a_doubted_clamp_is_no_reason_for_unneeded():
    robot = load_robot(PIRATE).normal
    front, rear = robot.parts.index("front"), robot.parts.index("rear")
    states = ("Fixed", "Fixed", "DoubleClamped", "Unaligned", "Off")

    body = marked(robot, states, Mark("part", front, DECLARED))

    assert why_not(robot, body, "ClampFront") == ""
    assert why_not(robot, body, "ClampRear") == "unneeded: it is so already"
    both = marked(robot, states, Mark("part", front, DECLARED), Mark("part", rear, DECLARED))
    unseen = "front: no sensor has shown that it holds"
    assert why_not(robot, both, "RelaxRear") == (
        f"impossible: no clamp that would remain is confirmed; {unseen}"
    )
    assert why_not(robot, both, "DriveForward").startswith(
        f"impossible: no clamp is confirmed to drive with; {unseen}; rear: "
    )


def test_stopped_wheels_are_no_reason_for_unneeded():
    robot = load_robot(PIRATE).normal
    front, rear = 0, 1
    driving = ("DrivingForward", "DrivingForward", "DoubleClamped", "Unaligned", "Off")
    stopped = Mark("region", front, STOPPED), Mark("region", rear, STOPPED)

    assert why_not(robot, marked(robot, driving, *stopped), "DriveForward") == ""
    one = marked(robot, driving, stopped[0])
    assert why_not(robot, one, "DriveForward") == "unneeded: it is so already"
    part = Mark("part", robot.parts.index("front"), DECLARED)
    other = Mark("part", robot.parts.index("rear"), DECLARED)
    loose = marked(robot, driving, *stopped, part, other)
    assert why_not(robot, loose, "DriveForward").startswith("impossible: no clamp is confirmed")


def test_a_retry_confirms_only_what_it_rests_on(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    front = driver.robot.parts.index("front")
    rotation = driver.robot.regions.index("RotationState")
    marks = {Mark("part", front, DECLARED), Mark("region", rotation, DECLARED)}
    driver.state = driver.state._replace(robot=driver.state.robot._replace(marks=frozenset(marks)))

    command(driver, "ClampFront")
    driver.until_done("ClampFront")

    assert driver.unconfirmed == {"RotationState"}


def test_each_robot_is_asked_for_itself():
    robot = load_robot(PIRATE).normal
    holding = tuple(replace(each, lets_go=False) for each in robot.commands)
    other = replace(robot, commands=holding)
    rear_only = ("Free", "Fixed", *REAR_ONLY)

    for _ in range(2):  # what has been answered once is remembered
        assert why_not(robot, marked(robot, rear_only), "Reset") == ""
        refused = why_not(other, marked(other, rear_only), "Reset")
        assert refused == "impossible: it would let go of the last confirmed clamp (rear)"
