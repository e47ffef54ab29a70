"""A robot that falls, rolls loose or leaves its pipe is at fault: it has not succeeded."""

from pathlib import Path

import pytest
from representative import thorough_but

from pirate_sm.core import library
from pirate_sm.core.effects import Fault

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


@pytest.mark.parametrize(
    ("backend", "upright_s", "fault"),
    thorough_but(
        {("sim", 52, "robot.fallen")},
        [
            ("sim", 50, "robot.fallen"),
            ("physics", 50, "robot.fallen"),
            ("sim", 52, "robot.fallen"),
            # Turned so slowly it has slid 0.4 m before it falls.
            ("physics", 52, "robot.slid"),
        ],
    ),
)
def test_belief_in_a_success_ends_when_a_loose_robot_slides_out(
    run, tmp_path, backend, upright_s, fault
):
    """It let go in a flat pipe, which was turned upright: it succeeded 2.5 m below."""
    text = library.find_pipe("straight_turning").read_text("utf-8")
    turned = "to: 52 s"
    assert turned in text
    pipe = tmp_path / "turning.yaml"
    pipe.write_text(text.replace(turned, f"to: {upright_s} s"), "utf-8")
    mission = tmp_path / "loose.yaml"
    mission.write_text(LOOSE, "utf-8")
    record = run(str(mission), backend=backend, pipe=str(pipe))
    assert record.ended.outcome == "fault"
    assert record.ended.message.split(":")[0] == fault


SLOPE = """\
format: 1
pipe: slope
diameter: 120 mm
tilt: 28 deg
uphill: 0 deg
segments: [{straight: 9 m}]
start: {at: 8 m}
"""


@pytest.mark.parametrize("backend", ["sim", "physics", "bay"])
def test_belief_in_a_success_ends_where_friction_nearly_holds_a_robot_that_lets_go(
    run, tmp_path, backend
):
    """It slid 6.6 m with standing wheels, while it weighed nearly what it does at rest."""
    mission, pipe = tmp_path / "lets_go.yaml", tmp_path / "slope.yaml"
    mission.write_text(LETS_GO.replace("COMMANDS", "Reset"), "utf-8")
    pipe.write_text(SLOPE, "utf-8")
    record = run(str(mission), backend=backend, pipe=str(pipe))
    assert [fault.code for fault in record.of(Fault)][-1] == "robot.slid"
    assert record.ended.outcome == "fault"


@pytest.mark.parametrize("backend", ["sim", "physics", "bay"])
def test_belief_in_a_success_ends_when_a_bend_ends_a_fall(run, tmp_path, backend):
    """It fell 0.26 m onto the far leg and lay there, which no sensor shows any more."""
    mission = tmp_path / "lets_go.yaml"
    mission.write_text(LETS_GO.replace("COMMANDS", "Reset"), "utf-8")
    record = run(str(mission), backend=backend, pipe="mitre_90_from_above")
    assert record.ended.outcome == "fault"
    assert record.ended.message.split(":")[0] in ("robot.fallen", "robot.slid")


@pytest.mark.parametrize("backend", thorough_but(["sim"], ["sim", "physics", "bay"]))
def test_a_robot_that_lets_go_where_it_lies_has_not_slid(run, tmp_path, backend):
    mission = tmp_path / "lets_go.yaml"
    commands = "Reset, ClampRear, Reset, ClampFront, Reset"
    mission.write_text(LETS_GO.replace("COMMANDS", commands), "utf-8")
    assert run(str(mission), backend=backend, pipe="straight_113").ended.outcome == "succeeded"


@pytest.mark.parametrize(
    "pipe", thorough_but(["straight_113_round"], ["straight_113", "straight_113_round"])
)
@pytest.mark.parametrize("command", ["DriveForward", "DriveBackward"])
@pytest.mark.parametrize("backend", ["sim", "bay"])
def test_belief_in_a_success_ends_at_either_end_of_the_pipe(run, tmp_path, command, pipe, backend):
    mission = tmp_path / "out.yaml"
    mission.write_text(OUT.replace("COMMAND", command), "utf-8")
    record = run(str(mission), backend=backend, pipe=pipe)
    assert record.ended.outcome == "fault"
    assert record.ended.message.split(":")[0] in ("robot.fallen", "robot.left_pipe")


@pytest.mark.parametrize("backend", ["sim", "bay"])
def test_belief_in_a_success_ends_for_a_robot_without_an_accelerometer(run, tmp_path, backend):
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
    record = run(str(mission), backend=backend, pipe=str(pipe))
    assert [fault.code for fault in record.of(Fault)] == ["robot.left_pipe"]
    assert record.ended.outcome == "fault"
