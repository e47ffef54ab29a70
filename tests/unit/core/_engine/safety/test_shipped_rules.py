"""The fault rules of a shipped robot see what they are there for, and nothing else."""

from __future__ import annotations

import pytest
from driving import IDLE, PIRATE

BODY = """\
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
on_fault:
  - {fault: [sensor.silent, sensor.stuck, wheel.dead, motion.unasked], then: continue}
  - {fault: robot.stuck, go: stuck}
start: drive
phases:
  drive: {do: [DriveForward], wait: [{operator: on, go: done}], within: {time: 1 h, go: done}}
  stuck: {wait: [{operator: on, go: done}], within: {time: 1 h, go: done}}
ends: {done: {succeed: Done}}
"""
RIM_M_S = 0.15
"""Speed of the rim of a wheel that is driven with full duty."""


@pytest.mark.parametrize(
    ("turning", "stuck"),
    [
        ((), True),
        ((1,), True),
        ((1, 2, 3), True),
        ((1, 4), False),
        ((2, 5), False),
        ((1, 6), False),
        ((1, 2, 3, 4, 5, 6), False),
    ],
)
def test_a_robot_that_drives_forward_is_stuck_where_all_its_rear_stands(
    drive, turning: tuple[int, ...], stuck: bool
) -> None:
    driver = drive(BODY, PIRATE)
    names, wheels = driver.robot.vocabulary.numbers, driver.robot.wheels
    rates = {names[w.angle]: RIM_M_S / w.metres_per_rad for w in wheels if w.place + 1 in turning}
    driver.accept()
    driver.run(0.5, **rates)
    driver.accept()

    driver.run(8.0, **rates)

    assert [code for code, _ in driver.faults].count("robot.stuck") == stuck


@pytest.mark.parametrize(
    ("command", "turning", "bearing", "stuck"),
    [
        ("DriveForward", (1, 2, 3, 4), (5, 6), True),
        ("DriveBackward", (3, 4, 5, 6), (1, 2), True),
        ("DriveForward", (1, 2, 3, 4), (5,), False),  # the motor of one wheel is dead
        ("DriveForward", (1, 2, 3, 4), (), False),
        ("DriveForward", (1, 2, 3, 4, 5), (6,), False),
        ("DriveForward", (3, 4, 5, 6), (1, 2), False),  # an edge may stall it, the rear pushes
    ],
)
def test_a_part_is_wedged_whose_last_wheels_stall_while_the_others_turn(
    drive, command: str, turning: tuple[int, ...], bearing: tuple[int, ...], stuck: bool
) -> None:
    driver = drive(BODY.replace("DriveForward", command), PIRATE)
    names, wheels = driver.robot.vocabulary.numbers, driver.robot.wheels
    rates = {names[w.angle]: RIM_M_S / w.metres_per_rad for w in wheels if w.place + 1 in turning}
    driver.accept()
    driver.run(0.5, **rates)
    driver.accept()
    driver.signals |= {f"wheel_current_{number}": 0.3 for number in bearing}

    driver.run(8.0, **rates)

    assert [code for code, _ in driver.faults].count("robot.stuck") == stuck


@pytest.mark.parametrize(
    ("bending", "lasting_s", "fallen"),
    [
        ("DoubleClamped", 0.3, False),
        ("DoubleClamped", 0.5, True),
        ("FrontClampedRearBending", 0.3, False),
        ("FrontClampedRearBending", 0.5, True),
    ],
)
def test_a_robot_that_weighs_less_for_long_slides_also_while_a_part_bends(
    drive, bending: str, lasting_s: float, fallen: bool
) -> None:
    rear = "Fixed" if bending == "DoubleClamped" else "Free"
    states = {"BendingState": bending, "FrontWheelsState": "Fixed", "RearWheelsState": rear}
    driver = drive(IDLE, PIRATE, states=states)
    driver.run(0.5)

    driver.signals["acc_z"] = 8.0
    driver.run(0.5 + lasting_s + 0.05)

    assert ("robot.fallen" in dict(driver.faults)) == fallen
