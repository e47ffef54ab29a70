"""What has shown the state of each region and the clamp of each part, and when."""

from __future__ import annotations

import pytest
from driving import BOTH_CLAMPED, FRONT_CLAMPED, IDLE, command

from pirate_sm.core._engine.robot.evidence import (
    NOTHING,
    Evidence,
    Proofs,
    proofs_after,
    proofs_at_start,
)
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    DECLARED,
    DENIED,
    LAPSED,
    STOPPED,
    Mark,
    RobotState,
    at_rest_in,
)

THEN, NOW = Evidence("sensor", 1.0, 0), Evidence("sensor", 9.0, 2)
FRONT = Mark("part", 0, DECLARED)


@pytest.fixture
def robot(drive) -> RobotSpec:
    return drive(IDLE, states=BOTH_CLAMPED).robot


def body_in(robot: RobotSpec, states: dict[str, str], *marks: Mark) -> RobotState:
    found = next(
        at
        for at, names in enumerate(robot.table.configurations)
        if states.items() <= dict(zip(robot.regions, names, strict=True)).items()
    )
    return at_rest_in(robot, found)._replace(marks=frozenset(marks))


def of_part(robot: RobotSpec, proofs: Proofs, part: int) -> Evidence:
    return proofs[len(robot.regions) + part]


def known(robot: RobotSpec) -> Proofs:
    """Everything was shown by sensors earlier."""
    return (THEN,) * (len(robot.regions) + len(robot.parts))


def test_at_the_start_what_is_marked_was_said_and_all_else_is_assumed(robot):
    proofs = proofs_at_start(robot, body_in(robot, FRONT_CLAMPED, FRONT), NOW)

    assert len(proofs) == len(robot.regions) + len(robot.parts)
    assert of_part(robot, proofs, 0) == NOW._replace(source="person")
    assert of_part(robot, proofs, 1) == NOTHING, "nobody says that the rear holds"
    assert set(proofs[: len(robot.regions)]) == {NOW._replace(source="assumption")}


def test_what_does_not_change_keeps_its_evidence(robot):
    body = body_in(robot, BOTH_CLAMPED, FRONT)

    assert proofs_after(robot, body, body, known(robot), NOW) == known(robot)


@pytest.mark.parametrize("command_", [DENIED, LAPSED])
def test_a_clamp_that_is_denied_or_out_of_sight_has_no_evidence(robot, command_):
    before = body_in(robot, BOTH_CLAMPED)
    after = body_in(robot, BOTH_CLAMPED, FRONT._replace(command=command_))

    proofs = proofs_after(robot, before, after, known(robot), NOW)

    assert of_part(robot, proofs, 0) == NOTHING
    assert of_part(robot, proofs, 1) == THEN


@pytest.mark.parametrize("command_", [DECLARED, STOPPED])
def test_what_is_declared_or_stopped_was_known_by_older_evidence(robot, command_):
    before = body_in(robot, BOTH_CLAMPED)
    after = body_in(robot, BOTH_CLAMPED, FRONT._replace(command=command_))

    assert proofs_after(robot, before, after, known(robot), NOW) == known(robot)


def test_a_part_that_lets_go_has_no_evidence(robot):
    before, after = body_in(robot, BOTH_CLAMPED), body_in(robot, FRONT_CLAMPED)

    proofs = proofs_after(robot, before, after, known(robot), NOW)

    assert of_part(robot, proofs, 0) == THEN
    assert of_part(robot, proofs, 1) == NOTHING


def test_a_declared_clamp_is_shown_by_sensors_now(robot):
    before, after = body_in(robot, BOTH_CLAMPED, FRONT), body_in(robot, BOTH_CLAMPED)

    assert of_part(robot, proofs_after(robot, before, after, known(robot), NOW), 0) == NOW


@pytest.mark.parametrize("first", [True, False])
def test_while_its_command_is_under_way_an_echo_shows_that_its_array_arrived(robot, first):
    command_ = 0 if first else robot.table.command_index["ClampFront"]
    before = body_in(robot, BOTH_CLAMPED)
    after = body_in(robot, BOTH_CLAMPED, FRONT._replace(command=command_))

    proofs = proofs_after(robot, before, after, known(robot), NOW)

    assert of_part(robot, proofs, 0) == NOW._replace(source="echo")


@pytest.mark.parametrize(("name", "source"), [("ClampFront", "sensor"), ("any other", "echo")])
def test_a_command_that_is_done_is_proved_by_what_its_criterion_looks_at(robot, name, source):
    found = {each.name: (at, each.proof) for at, each in enumerate(robot.commands)}
    at, proof = found.get(name) or next(each for each in found.values() if each[1] == source)
    assert proof == source
    before = body_in(robot, BOTH_CLAMPED, FRONT._replace(command=at))
    after = body_in(robot, BOTH_CLAMPED)

    proofs = proofs_after(robot, before, after, known(robot), NOW)

    assert of_part(robot, proofs, 0) == NOW._replace(source=source)


def test_a_state_that_only_an_echo_can_show_is_shown_by_it(robot):
    light = Mark("region", robot.regions.index("LightingState"), DECLARED)
    before, after = body_in(robot, BOTH_CLAMPED, light), body_in(robot, BOTH_CLAMPED)

    proofs = proofs_after(robot, before, after, known(robot), NOW)

    assert proofs[light.which] == NOW._replace(source="echo")


def test_a_command_that_is_done_at_once_proves_by_its_own_criterion(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.run(0.4)
    robot, before = driver.robot, driver.state.robot
    command(driver, "ToggleLighting")
    under_way = driver.state.robot
    assert under_way.motion is not None
    lit = next(
        at
        for at, names in enumerate(robot.table.configurations)
        if at != before.configuration
        and sum(a != b for a, b in zip(names, driver.states.values(), strict=True)) == 1
        and names[robot.regions.index("LightingState")] != driver.states["LightingState"]
    )
    after = under_way._replace(configuration=lit, motion=None)

    proofs = proofs_after(robot, under_way, after, known(robot), NOW)

    at = robot.regions.index("LightingState")
    assert proofs[at] == NOW._replace(source="echo")
    assert proofs[:at] == known(robot)[:at]
