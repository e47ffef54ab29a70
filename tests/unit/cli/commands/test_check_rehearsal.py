"""`pirate check --rehearse`, with the simulator."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from pirate_sm.running.wiring.backends import COMPILING
from pirate_sm.simulation.backend import SimulatorBackend

from ..conftest import NEWT, ROOT

SHIPPED = sorted((ROOT / "sequences").glob("*.yaml"))
SCHEMA = json.loads((ROOT / "docs" / "schemas" / "check.schema.json").read_text("utf-8"))

ENDLESS = """\
format: 1
mission: endless
robot: pirate_ii
pipe: straight_113
start: wait
phases:
  wait: {wait: [{operator: enough, go: done}], within: {time: 24 h, go: gave_up}}
ends:
  done: {succeed: ok}
  gave_up: {fail: nobody came}
"""


def rehearsed(pirate: Any, *arguments: Any) -> list[dict[str, Any]]:
    result = pirate("check", *arguments, "--rehearse", "--format", "json")
    # Whoever uses the simulator first on a machine is told that it is compiled.
    assert result.stderr.removeprefix(f"{COMPILING}\n") == ""
    data = json.loads(result.stdout)
    jsonschema.validate(data, SCHEMA)
    found: list[dict[str, Any]] = data["rehearsals"]
    return found


@pytest.mark.thorough
@pytest.mark.parametrize(
    "names",
    [
        ("mitre_bend", "climb", "enter_3d", "exp_1d_round_pipe", "exp_2c_tilted", "exp_3_drive"),
        pytest.param(tuple(path.stem for path in SHIPPED), marks=pytest.mark.slow, id="all"),
    ],
)
def test_a_shipped_mission_succeeds_in_its_pipe(pirate: Any, names: tuple[str, ...]) -> None:
    found = rehearsed(pirate, *(ROOT / "sequences" / f"{name}.yaml" for name in names))

    assert len(found) == len(names)
    for each in found:
        (run,) = each["runs"]
        assert (run["outcome"], each["skipped"]) == ("succeeded", "")
        assert each["nearly"]


@pytest.mark.thorough
def test_the_closest_calls_of_the_bend(pirate: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr("pirate_sm.cli.commands.rehearsal.MOST_CALLS", 100)
    (found,) = rehearsed(pirate, ROOT / "sequences" / "mitre_bend.yaml")
    texts = [each["text"] for each in found["nearly"]]
    shares = [each["share"] for each in found["nearly"]]

    faults = [text for text in texts if " came up to " in text or " came down to " in text]
    assert faults[0].startswith("clamp.lost: abs(gamma_")
    assert any("ClampRear (" in text and "of the 20 s that it has" in text for text in texts)
    assert any("BendBack (" in text and "of the 40 s that it has" in text for text in texts)
    assert shares == sorted(shares, reverse=True)
    assert all(0.1 <= share < 1 for share in shares)


@pytest.mark.thorough
def test_seeds_are_counted_from_zero_and_tell_their_calls(pirate: Any) -> None:
    (found,) = rehearsed(pirate, NEWT / "patrol.yaml", "--seeds", 3)

    assert [run["seed"] for run in found["runs"]] == [0, 1, 2]
    assert {each["seed"] for each in found["nearly"]} <= {0, 1, 2}


@pytest.mark.thorough
def test_twice_the_same_comes_out(pirate: Any) -> None:
    first, second = (rehearsed(pirate, "enter_2d", "--seeds", 2) for _ in range(2))

    assert first == second


def test_a_mission_without_a_pipe_is_not_run_unless_one_is_given(
    pirate: Any, tmp_path: Path
) -> None:
    file = tmp_path / "m.yaml"
    text = ENDLESS.replace("pipe: straight_113\n", "").replace("24 h", "1 s")
    file.write_text(text, encoding="utf-8")

    (found,) = rehearsed(pirate, file)
    assert (found["runs"], found["skipped"]) == ([], "it names no pipe; --pipe gives one")
    (found,) = rehearsed(pirate, file, "--pipe", "straight_113")
    assert len(found["runs"]) == 1


def test_a_mission_that_does_not_end_is_ended(
    pirate: Any, tmp_path: Path, monkeypatch: Any
) -> None:
    monkeypatch.setattr("pirate_sm.running.runtime.scripted_events.LONGEST_S", 2.0)
    file = tmp_path / "m.yaml"
    file.write_text(ENDLESS, encoding="utf-8")

    result = pirate("check", file, "--rehearse")
    assert result.exit_code == 1
    assert "error [rehearsal.failed]" in result.stdout
    assert "it had not ended after 2 s" in result.stdout


def test_seeds_alone_are_refused(pirate: Any) -> None:
    result = pirate("check", "climb", "--seeds", 2)

    assert (result.exit_code, result.stdout) == (2, "")
    assert "--seeds is for --rehearse" in result.stderr


def test_a_trigger_that_was_true_as_its_wait_began_is_pointed_out(
    pirate: Any, tmp_path: Path
) -> None:
    file = tmp_path / "m.yaml"
    file.write_text(
        """\
format: 1
mission: m
robot: pirate_ii
pipe: straight_113
start: on
phases:
  on:
    do: [ClampFront, ClampRear, DriveForward]
    wait: [{when: odometry >= 20 mm, go: further}]
    within: {time: 20 s, go: halt}
  further:
    wait: [{when: odometry >= 10 mm, held: 200 ms, go: halt}]
    within: {time: 20 s, go: halt}
  halt: {do: [Brake], go: there}
ends: {there: {succeed: There}}
""",
        encoding="utf-8",
    )
    result = pirate("check", file, "--rehearse")

    assert result.exit_code == 0
    assert result.stdout.count("[rehearsal.at_once]") == 1
    assert "m.yaml:12:12: warning [rehearsal.at_once]" in result.stdout


def test_an_interrupt_ends_the_check_and_is_no_finding(pirate: Any, monkeypatch: Any) -> None:
    """It was taken for the end of one run, which was then reported to have failed."""

    def interrupted(backend: Any, until_s: float) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(SimulatorBackend, "advance", interrupted)
    result = pirate("check", "climb", "--rehearse")

    assert result.exit_code == 130
    assert "rehearsal.failed" not in result.stdout
    assert "interrupted" in result.stderr
