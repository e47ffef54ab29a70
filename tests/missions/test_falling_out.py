"""A robot that falls, rolls loose or leaves its pipe is at fault: it has not succeeded."""

from pathlib import Path

import pytest

from pirate_sm.model.effects import Fault

NEWT = str(Path(__file__).resolve().parents[1] / "robots" / "newt")
LOOSE = """\
format: 1
mission: loose
robot: pirate_ii
pipe: straight_turning
allow_unclamp: somebody holds it
starts_in: {BendingState: Unclamped}
start: clamp
phases:
  clamp: {do: [ClampFront, ClampRear, Reset], go: wait}
  wait: {wait: [{after: 50 s, go: done}]}
ends: {done: {succeed: Done}}
"""
OUT = """\
format: 1
mission: out
robot: pirate_ii
pipe: straight_113
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
on_fault: [{fault: [clamp.lost, robot.stuck, wheel.dead, sensor.jumped, motion.unasked], then: continue}]
start: drive
phases: {drive: {do: [COMMAND], wait: [{after: 20 s, go: halt}]}, halt: {do: [Brake], go: done}}
ends: {done: {succeed: Done}}
"""  # noqa: E501

LETS_GO = """\
format: 1
mission: lets_go
robot: pirate_ii
pipe: vertical
allow_unclamp: somebody holds it
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
on_fault: [{fault: [clamp.lost, robot.stuck, wheel.dead, sensor.jumped, motion.unasked], then: continue}]
start: reset
phases: {reset: {do: [COMMANDS], go: done}}
ends: {done: {succeed: Done}}
"""  # noqa: E501


@pytest.mark.parametrize("backend", ["sim", "physics", "bay"])
@pytest.mark.parametrize("commands", ["Reset", "Reset, ClampFront, ClampRear"])
def test_belief_in_a_success_ends_where_a_robot_lets_go_in_an_upright_pipe(
    run, tmp_path, backend, commands
):
    """Nothing waits after it has let go, and it may have clamped again farther down."""
    mission = tmp_path / "lets_go.yaml"
    mission.write_text(LETS_GO.replace("COMMANDS", commands), "utf-8")
    record = run(str(mission), backend=backend)
    assert record.ended.outcome == "fault"
    assert record.ended.message.split(":")[0] in ("robot.fallen", "robot.left_pipe")


@pytest.mark.parametrize("backend", ["sim", "physics"])
def test_belief_in_a_success_ends_when_a_loose_robot_slides_out(run, tmp_path, backend):
    """It let go in a flat pipe, which was turned upright: it succeeded 2.5 m below."""
    mission = tmp_path / "loose.yaml"
    mission.write_text(LOOSE, "utf-8")
    record = run(str(mission), backend=backend)
    assert record.ended.outcome == "fault"
    assert "robot.fallen" in record.ended.message


@pytest.mark.parametrize("pipe", ["straight_113", "straight_113_round"])
@pytest.mark.parametrize("command", ["DriveForward", "DriveBackward"])
def test_belief_in_a_success_ends_at_either_end_of_the_pipe(run, tmp_path, command, pipe):
    mission = tmp_path / "out.yaml"
    mission.write_text(OUT.replace("COMMAND", command), "utf-8")
    record = run(str(mission), backend="sim", pipe=pipe)
    assert record.ended.outcome == "fault"
    assert record.ended.message.split(":")[0] in ("robot.fallen", "robot.left_pipe")


def test_belief_in_a_success_ends_for_a_robot_without_an_accelerometer(run, tmp_path):
    """The simulator knows the end of the pipe; nothing on this robot feels the fall."""
    pipe = tmp_path / "upright.yaml"
    pipe.write_text(
        "format: 1\npipe: upright\ndiameter: 100 mm\ntilt: 90 deg\n"
        "segments: [{straight: 1 m}]\nstart: {at: 600 mm}\n",
        "utf-8",
    )
    mission = tmp_path / "wait.yaml"
    text = LOOSE.replace("BendingState: Unclamped", "Grip: Loose").replace("pirate_ii", NEWT)
    text = text.replace("[ClampFront, ClampRear, Reset]", "[SwitchLamp]")
    mission.write_text(text, "utf-8")
    record = run(str(mission), backend="sim", pipe=str(pipe))
    assert [fault.code for fault in record.of(Fault)] == ["robot.left_pipe"]
    assert record.ended.outcome == "fault"
