"""What a refused command is refused for is said by the commands that help."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core._engine.mission.planning import next_steps
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.robot import RobotSpec, RobotState, at_rest_in, marks_after, refusal, safety
from pirate_sm.core.sensing import nothing_known
from pirate_sm.running.wiring import Order, load
from pirate_sm.views.console.availability import commands_before

NEWT = Path(__file__).parents[3] / "robots/newt/take_hold.yaml"


@pytest.fixture(scope="module", params=["mitre_bend", str(NEWT)], ids=["pirate_ii", "newt"])
def loaded(request: pytest.FixtureRequest) -> LoadedMission:
    return load(Order(request.param))


def index_of(robot: RobotSpec, name: str) -> int:
    return robot.table.command_index[name]


def done(loaded: LoadedMission, body: RobotState, name: str) -> RobotState:
    """The robot after the command, as the engine carries it out."""
    robot, program = loaded.robot, loaded.program
    places, _ = safety.follow(program, robot, safety.unseen(program), body, 0)
    steps = next_steps(robot, program, nothing_known(robot, blind=True), body, places)
    return next(step.body for step, _ in steps if step.command == index_of(robot, name))


def test_what_is_named_helps_wherever_the_robot_is(loaded: LoadedMission) -> None:
    robot, named = loaded.robot, 0
    for here in range(len(robot.table.configurations)):
        body = at_rest_in(robot, here)
        for command, spec in enumerate(robot.commands):
            if not refusal(robot, body, command).startswith("impossible"):
                continue
            said = commands_before(robot, body, command)
            ways = said.split(" or ") if said else []
            for way in ways:
                after = body
                for name in way.split(", "):
                    after = done(loaded, after, name)
                assert not refusal(robot, after, command), (here, spec.name, way)
                named += 1
    assert named


def test_what_lets_go_of_the_pipe_is_never_named(loaded: LoadedMission) -> None:
    robot = loaded.robot
    letting_go = {each.name for each in robot.commands if each.lets_go}
    for here in range(len(robot.table.configurations)):
        for command in range(len(robot.commands)):
            said = commands_before(robot, at_rest_in(robot, here), command)
            assert not letting_go & set(said.replace(" or ", ", ").split(", "))


def test_a_clamp_that_was_not_seen_to_hold_is_given_again_before_a_drive() -> None:
    robot = load(Order("mitre_bend")).robot
    clamp, drive = index_of(robot, "ClampFront"), index_of(robot, "DriveForward")
    here = robot.table.initial
    body = at_rest_in(robot, robot.table.follow(here, clamp))
    body = body._replace(marks=marks_after(robot, here, body.marks, clamp))

    assert "no clamp is confirmed" in refusal(robot, body, drive)
    assert commands_before(robot, body, drive) == "ClampFront or ClampRear"
