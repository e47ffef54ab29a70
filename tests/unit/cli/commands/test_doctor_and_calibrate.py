"""`pirate doctor` and `pirate calibrate`: once over a real port, and what they refuse."""

from __future__ import annotations

import json
import shutil
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator
from typer.testing import Result

from pirate_sm.core.loading import load_pipe, load_robot
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.node_handle import message_texts
from pirate_sm.simulation.bay.terminal import Terminal, serve
from pirate_sm.simulation.bay.virtual import VirtualBay

ROOT = Path(__file__).resolve().parents[4]
PATIENCE_S = 10.0
Call = Callable[..., Result]

LIGHT = """
format: 1
mission: light
robot: pirate_ii
pipe: mitre_90
start: only
phases: {only: {do: [ToggleLighting], go: lit}}
ends: {lit: {succeed: The lights are on}}
"""


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """A robot of our own, which boots quickly and may be calibrated."""
    folder = Path(shutil.copytree(ROOT / "hardware_profiles" / "pirate_ii", tmp_path / "robot"))
    profile = folder / "profile.yaml"
    profile.write_text(profile.read_text("utf-8").replace("boot: 2 s", "boot: 200 ms"), "utf-8")
    return folder


@pytest.fixture
def port(robot: Path) -> Iterator[str]:
    """The name of a port with a bay behind it, in real time."""
    profile = load_robot(robot).profile
    pipe = load_pipe(ROOT / "sequences" / "pipes" / "mitre_90.yaml")[0]
    bay = VirtualBay(profile, pipe, message_texts(robot, profile), Switches(boot_s=0.05))
    stop = threading.Event()
    with Terminal(baud=57600) as terminal:
        thread = threading.Thread(target=serve, args=(bay, terminal, stop.is_set))
        thread.start()
        yield terminal.name
        stop.set()
        thread.join(PATIENCE_S)


@pytest.mark.thorough
def test_a_robot_is_looked_at_moved_calibrated_and_run_over_a_real_port(
    pirate: Call, pirate_run: Call, port: str, robot: Path
) -> None:
    looked = pirate("doctor", "--port", port, "--robot", robot, "--seconds", 1, "--move", "--yes")

    # On a busy machine the emulation itself may be too slow to be a go.
    verdict = looked.stdout.splitlines()[-1]
    assert verdict.startswith("NO-GO" if looked.exit_code else "GO"), looked.output
    for word in ("setpoint_array", "bend_1", "gamma_1", "round trip of an array"):
        assert word in looked.stdout

    kept = pirate("calibrate", "--port", port, "--robot", robot, "--seconds", 3, "--yes")

    assert kept.exit_code == 0, kept.output
    (file,) = robot.glob("calibration-*.yaml")
    assert file.name in kept.stdout

    again = pirate("doctor", "--port", port, "--robot", robot, "--seconds", 1, "--json")

    found = json.loads(again.stdout)
    assert found["go"] is (again.exit_code == 0)
    assert any("joint zeros of" in finding["message"] for finding in found["findings"])
    assert found["move"] is None

    mission = robot.parent / "light.yaml"
    mission.write_text(LIGHT, "utf-8")
    ran = pirate_run(
        *(mission, "--robot", robot, "--backend", "serial", "--port", port, "--yes", "--json"),
        *("--detector", "odometry", "--no-record"),
    )

    lines = [json.loads(line) for line in ran.stdout.splitlines()]
    assert ran.exit_code == 0, ran.output
    assert (lines[0]["backend"], lines[0]["detector"]) == ("serial", "odometry")
    assert any("joint zeros of" in line["message"] for line in lines if line["type"] == "log")
    schema = json.loads((ROOT / "docs" / "schemas" / "output.schema.json").read_text("utf-8"))
    for line in lines:
        Draft202012Validator(schema).validate(line)


def test_a_run_that_leaves_a_guardian_behind_says_what_to_do(
    pirate_run: Call, port: str, robot: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parting = "cut the robot's power: it has not confirmed that it stopped"
    monkeypatch.setattr(SerialBackend, "parting", lambda backend: parting)
    mission = robot.parent / "light.yaml"
    mission.write_text(LIGHT, "utf-8")
    ran = pirate_run(
        *(mission, "--robot", robot, "--backend", "serial", "--port", port, "--yes", "--quiet"),
        *("--detector", "odometry", "--no-record", "--guard-for", "30 min"),
    )

    assert ran.stderr.splitlines()[-1] == parting


def test_a_port_that_is_not_there_is_exit_code_3(pirate: Call) -> None:
    result = pirate("doctor", "--port", "/nowhere/tty")

    assert result.exit_code == 3
    assert "there is no port /nowhere/tty" in result.stderr


@pytest.mark.parametrize(
    ("port", "told"),
    [
        ("/nowhere/tty", "there is no port /nowhere/tty"),
        ("/dev/null", "/dev/null is not a serial port"),
        ("loop://?x=1", "loop://?x=1 is not an address"),
    ],
)
def test_a_run_on_a_port_that_cannot_be_opened_says_so_in_one_sentence(
    pirate_run: Call, port: str, told: str
) -> None:
    options = ("--backend", "serial", "--port", port, "--yes", "--quiet", "--no-record")
    result = pirate_run("mitre_bend", *options)

    assert result.exit_code == 3
    (line,) = result.output.splitlines()
    assert told in line


def test_a_run_without_a_port_is_refused(pirate_run: Call) -> None:
    result = pirate_run("mitre_bend", "--backend", "serial", "--port", "", "--yes")

    assert result.exit_code == 2
    assert "the backend serial needs a port" in result.stderr


def test_nothing_is_moved_that_nobody_agreed_to(pirate: Call) -> None:
    result = pirate("doctor", "--port", "/nowhere/tty", "--move")

    assert result.exit_code == 2
    assert "is it on a block, with its wheels free? Agree to it with --yes" in result.stderr


def test_nobody_at_a_terminal_can_straighten_nothing(pirate: Call) -> None:
    result = pirate("calibrate", "--port", "/nowhere/tty")

    assert result.exit_code == 2
    assert "straighten the robot by hand" in result.stderr


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--skip", "gama_1"], "--skip: there is no joint 'gama_1': did you mean 'gamma_1'?"),
        (["--limit", "10"], "10"),
        (["--limit", "10 mm"], "an angle"),
        ([f"--skip=gamma_{n}" for n in (1, 2, 3, 4)], "no joint left to calibrate"),
        (["--robot", "newtt"], "there is no robot 'newtt'"),
    ],
)
def test_what_does_not_fit_is_refused_before_the_port_is_opened(
    pirate: Call, options: list[str], told: str
) -> None:
    result = pirate("calibrate", "--port", "/nowhere/tty", "--yes", *options)

    assert result.exit_code == 2
    assert told in result.stderr
