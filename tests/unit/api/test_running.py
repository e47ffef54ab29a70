from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import pirate_sm
from pirate_sm.robot.backends.trace import TraceBackend

from .conftest import PATROL


def test_a_run_says_how_it_ended(patrolled: pirate_sm.Run) -> None:
    assert (patrolled.outcome, patrolled.message) == ("succeeded", "Back where it began")
    assert patrolled.ended is not None
    assert patrolled.ended.end == "back"
    assert patrolled.duration_s > 5.0
    assert repr(patrolled).startswith("<Run of patrol on sim: succeeded after ")


def test_equal_seeds_give_equal_runs_and_others_do_not(
    patrol: pirate_sm.LoadedMission, patrolled: pirate_sm.Run
) -> None:
    assert repr(pirate_sm.run(patrol, seed=2).signals) == repr(patrolled.signals)
    assert repr(pirate_sm.run(patrol, seed=3).signals) != repr(patrolled.signals)


def test_a_defect_is_a_fault_of_the_run_and_no_exception() -> None:
    run = pirate_sm.run("mitre_bend", defects="wheels_3_4_dead")

    assert run.outcome == "succeeded", "the mission has a handler for it"
    assert "wheel.dead" in run.faults["code"]


@pytest.mark.thorough
def test_belief_is_tried_with_timed_defects_in_both_simulators_and_the_run_repeats() -> None:
    drawn = {"defect": "wheel_1_dead", "after": "1 s..3 s"}
    # It takes 5 s at 0.15 m/s: 3 s at most until the wheel dies, and 1.7 s until that is found.
    options: dict[str, Any] = {"set": {"way": "700 mm"}, "defects": drawn}
    runs = {
        (backend, seed): pirate_sm.run("drive_on", backend, seed=seed, **options)
        for backend in ("sim", "physics")
        for seed in (1, 2)
    }
    died = {which: run.faults["time_s"][0] for which, run in runs.items()}

    assert {run.faults["code"][0] for run in runs.values()} == {"wheel.dead"}
    assert len(set(died.values())) > 1
    text = "wheel_1_dead:after=1s..3s"
    again = pirate_sm.run("drive_on", seed=1, set={"way": "700 mm"}, defects=(text,))
    assert repr(again.signals) == repr(runs["sim", 1].signals)
    (shown,) = again.header.options["defects"]
    assert ".." not in shown, "what was drawn is recorded"
    repeated = pirate_sm.run("drive_on", seed=1, set={"way": "700 mm"}, defects=shown)
    assert repr(repeated.signals) == repr(again.signals)


def test_a_trace_runs_without_the_simulator() -> None:
    run = pirate_sm.run(PATROL, "trace")

    assert run.outcome == "succeeded"
    assert "signals" not in run.tables


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ({"backend": "sin"}, "did you mean 'sim'"),
        ({"defects": ["rust"]}, "rust"),
        ({"backend": "serial"}, "needs a port"),
        ({"backend": "serial", "port": "/dev/null"}, "agree to it with yes=True"),
        ({"backend": "serial", "port": "/dev/null", "yes": "no"}, "yes: expected True or False"),
        ({"check": "no"}, "check: expected True or False"),
        ({"detector": "operator"}, "needs an operator"),
        ({"set": {3: "3 s"}}, "set: expected values by the names of parameters"),
        ({"set": {"glance": "3 s"}}, "no parameter 'glance'"),
    ],
)
def test_an_argument_that_does_not_fit_is_refused(arguments: dict[str, Any], why: str) -> None:
    with pytest.raises(pirate_sm.UsageError, match=why):
        pirate_sm.run(PATROL, **arguments)


def test_a_mission_with_something_wrong_is_refused_with_its_findings(faulty: Path) -> None:
    with pytest.raises(pirate_sm.CheckError) as caught:
        pirate_sm.run(faulty)

    assert caught.value.findings[0].place.line == 7


def test_ctrl_c_leads_through_the_safe_state_and_is_raised_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sent: list[tuple[float, ...]] = []
    submit, closed = TraceBackend.submit, []

    def noted(backend: TraceBackend, setpoint_id: int, values: tuple[float, ...]) -> None:
        sent.append(values)
        submit(backend, setpoint_id, values)

    def interrupted(backend: TraceBackend, until_s: float) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(TraceBackend, "submit", noted)
    monkeypatch.setattr(TraceBackend, "advance", interrupted)
    monkeypatch.setattr(TraceBackend, "close", lambda backend: closed.append(True))

    with pytest.raises(KeyboardInterrupt):
        pirate_sm.run(PATROL, "trace")

    assert len(sent) == 2, "the first array of the mission, then the safe one"
    assert closed


def test_a_backend_that_cannot_be_opened_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def closed(backend: TraceBackend) -> None:
        raise pirate_sm.BackendError("no such line")

    monkeypatch.setattr(TraceBackend, "open", closed)

    with pytest.raises(pirate_sm.BackendError, match="no such line"):
        pirate_sm.run(PATROL, "trace")


def test_a_recording_must_not_exist_yet(tmp_path: Path) -> None:
    file = tmp_path / "run.mcap"
    file.write_text("mine")

    with pytest.raises(pirate_sm.RecordingError, match="exists already"):
        pirate_sm.run(PATROL, "trace", record=file)

    assert file.read_text() == "mine"
