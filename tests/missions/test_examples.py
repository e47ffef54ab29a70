"""The examples of docs/missions.md run, and end as they say."""

from __future__ import annotations

from pathlib import Path

import pytest
from representative import thorough_but

from pirate_sm.running.runtime.scripted_events import Firing

DOCS = Path(__file__).resolve().parents[2] / "docs"
EXAMPLES = sorted((DOCS / "examples").glob("*.yaml"))

# The end that each reaches in a trace; `""` where it is not an end of the mission's own.
ENDS = {
    "after": "held",
    "ask": "clamped",
    "call": "entered",
    "choose": "clamped",
    "condition": "lit",
    "control": "arrived",
    "held": "steady",
    "inline_pipe": "arrived",
    "log": "said",
    "on_a_block": "obeys",
    "on_failure_continue": "held",
    "on_failure_mission": "gave_up",
    "on_failure_phase": "refused",
    "on_failure_step": "relaxed",
    "on_fault": "arrived",
    "operator": "stopped",
    "parameters": "arrived",
    "polarity": "arrived",
    "repeat": "blinked",
    "resume": "measured",
    "retry": "clamped",
    "starts_in": "clamped",
    "time_limit": "",
    "unneeded": "clamped",
    "wait_step": "driven",
    "within": "nothing",
}

# What happens in the trace's ideal world that the example is about.
FIRINGS = {"within": (Firing("within"),)}


def test_every_example_has_an_expected_end():
    assert [path.stem for path in EXAMPLES] == sorted(ENDS)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_ends_as_expected(run, path):
    record = run(path, backend="trace", firings=FIRINGS.get(path.stem, ()))
    assert record.ended.end == ENDS[path.stem]


@pytest.mark.parametrize("path", thorough_but(EXAMPLES[::3], EXAMPLES), ids=lambda path: path.stem)
def test_an_example_ends_alike_in_the_simulator(run, path):
    assert run(path, backend="sim").ended.end == ENDS[path.stem]


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_referred_to(path):
    assert f"(examples/{path.name})" in (DOCS / "missions.md").read_text("utf-8")


@pytest.mark.parametrize("distance", ["50 mm", "0.3 m"])
def test_a_parameter_can_be_given(run, distance):
    path = DOCS / "examples" / "parameters.yaml"
    record = run(path, backend="sim", settings={"distance": distance})
    odometry = record.prepared.truth().distance_m
    assert record.ended.end == "arrived"
    assert odometry == pytest.approx(
        float(distance.split()[0]) / 1000 if "mm" in distance else 0.3, abs=0.05
    )


@pytest.mark.parametrize(
    "page", [DOCS / "missions.md", DOCS.parent / "README.md"], ids=lambda page: page.name
)
def test_the_first_mission_of_a_page_runs(run, tmp_path, page):
    block = page.read_text("utf-8").split("```yaml\n", 1)[1].split("```", 1)[0]
    mission = tmp_path / "first.yaml"
    mission.write_text(block, encoding="utf-8")
    assert run(mission, backend="sim").ended.end == "arrived"
