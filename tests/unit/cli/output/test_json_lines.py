"""The JSON lines are an interface: real runs of many kinds hold to the published schema."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from representative import thorough_but

from ..conftest import NEWT, ROOT

SCHEMA = json.loads((ROOT / "docs" / "schemas" / "output.schema.json").read_text("utf-8"))
EXAMPLES = ROOT / "docs" / "examples"

RUNS = {
    "trace": ("mitre_bend", "--backend", "trace"),
    "sim": ("mitre_bend",),
    "questions": ("exp_2a_commands", "--backend", "trace"),
    "small robot": (NEWT / "patrol.yaml", "--seed", "3"),
    "defect": (NEWT / "patrol.yaml", "--defect", "hind_wheel_dead"),
    "fails": (NEWT / "patrol.yaml", "--backend", "trace", "--fire", "within"),
    "refused": (EXAMPLES / "on_failure_phase.yaml", "--backend", "trace"),
    "unmet": ("mitre_bend", "--defect", "gamma_2_sticks_at_zero"),
    "mirrored": (EXAMPLES / "polarity.yaml", "--backend", "trace"),
    "no pipe": (NEWT / "take_hold.yaml", "--backend", "trace"),
}


@pytest.fixture(scope="module")
def validator() -> Draft202012Validator:
    Draft202012Validator.check_schema(SCHEMA)
    return Draft202012Validator(SCHEMA)


@pytest.mark.parametrize("run", thorough_but({"trace", "defect", "unmet"}, RUNS))
def test_every_line_holds_to_the_schema(
    pirate_run: Any, validator: Draft202012Validator, run: str
) -> None:
    result = pirate_run(*RUNS[run], "--json")
    lines = [json.loads(text) for text in result.stdout.splitlines()]

    for line in lines:
        validator.validate(line)
    times = [line["t"] for line in lines]
    assert times == sorted(times)
    assert [line["type"] for line in lines].index("start") == 0
    assert [line["type"] for line in lines].index("end") == len(lines) - 1


@pytest.mark.thorough
def test_a_failed_command_has_the_limits_that_it_awaited(pirate_run: Any) -> None:
    result = pirate_run("mitre_bend", "--defect", "gamma_2_sticks_at_zero", "--json")
    failed = [line for line in map(json.loads, result.stdout.splitlines()) if "unmet" in line]

    assert {line["status"] for line in failed} == {"failed"}
    clamp = next(line for line in failed if line["name"] == "ClampFront")
    assert [each["signal"] for each in clamp["unmet"]] == ["gamma_rate_2"]
    assert clamp["unmet"][0]["value"] is None
    assert clamp["unmet"][0]["unknown"] == "implausible"
    assert "gamma_rate_2 should be within 0.0698 rad/s of zero" in clamp["reason"]


def test_the_schema_knows_every_type_that_is_written_and_no_other() -> None:
    documented = {
        "start", "phase", "command", "state", "setpoints", "trigger", "detected", "environment",
        "fault", "log", "end",
    }  # fmt: skip
    assert {name.rpartition("/")[2] for one in SCHEMA["oneOf"] for name in one.values()} == (
        documented
    )
    page = (ROOT / "docs" / "output.md").read_text("utf-8")
    assert all(f"| `{name}` |" in page for name in documented)


def test_the_schema_refuses_what_is_not_said() -> None:
    validator = Draft202012Validator(SCHEMA)

    assert not validator.is_valid({"t": 0.0, "type": "note"})
    assert not validator.is_valid({"t": 0.0, "type": "detected", "word": "in", "more": 1})
    assert not validator.is_valid({"type": "detected", "word": "in"})


def test_the_lines_tell_what_was_run_and_how_it_went(pirate_run: Any) -> None:
    result = pirate_run(NEWT / "patrol.yaml", "--seed", "3", "--set", "look=1 s", "--json")
    lines = [json.loads(text) for text in result.stdout.splitlines()]
    start, end = lines[0], lines[-1]
    states = [line for line in lines if line["type"] == "state"]
    arrays = [line for line in lines if line["type"] == "setpoints"]

    assert (start["mission"], start["robot"], start["pipe"]) == ("patrol", "newt", "elbow")
    assert (start["backend"], start["ideal"], start["seed"]) == ("sim", False, 3)
    assert start["parameters"] == {"look": "1 s"}
    assert {name.rpartition("/")[2] for name in start["files"]} == {
        "patrol.yaml", "take_hold.yaml", "elbow.yaml", "profile.yaml", "chart.yaml",
    }  # fmt: skip
    assert states[0]["state"] == {"Grip": "Loose", "Crawl": "Resting", "Lamp": "Dark"}
    assert {len(line["values"]) for line in arrays} == {len(start["slots"])} == {7}
    assert (end["outcome"], end["end"]) == ("succeeded", "back")
    assert end["sim_time_s"] == end["t"]
    assert end["distance_m"] == pytest.approx(0.0, abs=0.05)
    assert end["odometry_m"] == pytest.approx(0.0, abs=0.05)


def test_a_trace_claims_no_distance(pirate_run: Any) -> None:
    result = pirate_run(NEWT / "patrol.yaml", "--backend", "trace", "--json")
    lines = [json.loads(text) for text in result.stdout.splitlines()]

    assert lines[0]["ideal"] is True
    assert lines[1]["type"] == "log"
    assert "nothing moves" in lines[1]["message"]
    assert (lines[-1]["distance_m"], lines[-1]["odometry_m"]) == (None, None)


def test_equal_seeds_print_equal_lines(pirate_run: Any) -> None:
    order = (NEWT / "patrol.yaml", "--seed", "11", "--json")

    assert pirate_run(*order).stdout == pirate_run(*order).stdout


def test_an_answer_is_kept_and_its_question_not_called_withdrawn(pirate_run: Any) -> None:
    result = pirate_run("exp_1a_both", "--backend", "trace", "--yes", "--json")
    logs = [line for line in map(json.loads, result.stdout.splitlines()) if line["type"] == "log"]
    told = [line["message"] for line in logs]

    assert "answered 'removed' (--yes)" in told
    assert "the question is withdrawn" not in told


def test_what_nobody_could_see_is_written_out_and_is_still_there(
    pirate_run: Any, tmp_path: Path
) -> None:
    mission = tmp_path / "m.yaml"
    mission.write_text(
        f"format: 1\nmission: m\nrobot: {NEWT}\nstart: a\n"
        "phases: {a: {do: [HoldNose], go: e}}\n"
        'ends: {e: {succeed: "5 \u00b0 \\u202eback \\u200b"}}\n',
        "utf-8",
    )

    out = pirate_run(mission, "--backend", "trace", "--json").stdout

    assert all(line.isprintable() for line in out.splitlines())
    assert json.loads(out.splitlines()[-1])["message"] == "5 \u00b0 \u202eback \u200b"


def test_belief_is_written_with_what_has_shown_it(pirate_run: Any) -> None:
    result = pirate_run(NEWT / "take_hold.yaml", "--pipe", NEWT / "elbow.yaml", "--json")
    lines = [json.loads(text) for text in result.stdout.splitlines()]

    first, *_, last = [line for line in lines if line["type"] == "state"]
    assert {it["source"] for it in first["evidence"].values()} == {"person", "nothing"}
    assert last["evidence"]["nose"]["source"] == last["evidence"]["tail"]["source"] == "sensor"
    assert 0 < last["evidence"]["tail"]["at_s"] <= last["t"]
