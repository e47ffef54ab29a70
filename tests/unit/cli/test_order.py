"""What the options of a run and of the console order."""

from __future__ import annotations

from typing import Any

import pytest

from pirate_sm.cli.options.running import ConsoleOptions, RunOptions
from pirate_sm.core.errors import UsageError
from pirate_sm.running.runtime.scripted_events import Firing
from pirate_sm.running.wiring import Order

SHARED: dict[str, Any] = {
    "backend": "serial",
    "robot": "r",
    "pipe": "p",
    "settings": ["a=1"],
    "states": ["Front=Held"],
    "seed": 7,
    "defects": ["late", "late"],
    "fidelity": "fast",
    "port": "/dev/x",
    "baud": 9600,
    "guard_for_s": "2 min",
    "detector": "odometry",
    "start_at_m": "0.7 m",
    "calibration": False,
    "check": False,
}
ORDER = Order(
    mission="m.yaml",
    backend="serial",
    robot="r",
    pipe="p",
    settings={"a": "1"},
    states={"Front": "Held"},
    seed=7,
    defects=("late",),
    fidelity="fast",
    port="/dev/x",
    baud=9600,
    guard_for_s=120.0,
    detector="odometry",
    start_at_m=0.7,
    calibration=False,
    check=False,
)


def test_a_run_and_the_console_order_the_same_by_the_same_options() -> None:
    assert RunOptions(mission="m.yaml", written=SHARED).order() == ORDER
    assert ConsoleOptions(mission="m.yaml", written=SHARED).order() == ORDER


def test_options_that_are_left_out_are_those_of_an_order() -> None:
    assert RunOptions(mission="m").order() == Order("m", check=True)


def test_triggers_are_fired_in_order() -> None:
    order = RunOptions(mission="m", fire=["past=2.5", "home"]).order()

    assert order.firings == (Firing("past", 2.5), Firing("home", None))


@pytest.mark.parametrize("text", ["past=soon", "past=-1", "past=inf"])
def test_a_trigger_fires_after_seconds(text: str) -> None:
    with pytest.raises(UsageError, match="expected TRIGGER or TRIGGER=SECONDS"):
        RunOptions(mission="m", fire=[text]).order()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--jitter", "begin=20mm"], "--jitter begin: "),
        (["--jitter", "start"], "--jitter start: expected NAME=VALUE"),
        (["--jitter", "start=20"], "--jitter start=20: "),
        (["--jitter", "friction=100%"], "friction=100%: expected less than 100 %, got '100%'"),
        (["--jitter", "start=-5mm"], "start=-5mm: expected at least 0 mm, got '-5mm'"),
        (["--jitter", "start=5 inch"], "(unknown unit 'inch' in '5 inch'); did you mean '127 mm'?"),
        (["--backend", "bay", "--line", "loss=1%"], "--line loss: "),
    ],
)
def test_jitter_and_faults_of_a_line_are_read_as_in_files(words, message, pirate_run):
    told = pirate_run("enter_2d", "--no-record", "--quiet", *words)

    assert told.exit_code == 2
    assert message in told.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--defect", "a", "--defect", "gamma_2_stickz"], ["'a'", "mean 'gamma_2_sticks'?"]),
        (["--defect", "a,b"], ["'a,b'", "; repeat --defect for each"]),
        (["--set", "a=1", "--set", "give_upp=2 s"], ["'a'", "'give_up'?"]),
        (["--set", "a=1", "--set", "give_up=x"], ["'a'", "parameter 'give_up': "]),
        (["--jitter", "begin=20mm", "--jitter", "start=20"], ["begin: ", "start=20: "]),
        (["--backend", "trace", "--fire", "a", "--fire", "pas"], ["'a'", "'pass'?"]),
        (["--state", "A=b", "--state", "C=d"], ["'A'", "'C'"]),
    ],
)
def test_all_names_that_do_not_exist_are_named_at_once(words, said, pirate_run):
    result = pirate_run("mitre_bend", "--no-record", "--quiet", *words)

    assert result.exit_code == 2
    assert all(each in result.stderr for each in said), result.stderr


def test_jitter_changes_a_run_and_its_seed_repeats_it(pirate_run):
    words = ("enter_2d", "--no-record", "--json", "--jitter", "friction=20%", "--seed")
    first, again, other = (pirate_run(*words, seed).stdout for seed in ("1", "1", "2"))

    assert first == again
    assert first != other


@pytest.mark.thorough
def test_a_mission_runs_over_the_link_to_the_emulated_bay_in_virtual_time(pirate_run):
    words = ("enter_2d", "--no-record", "--quiet", "--backend", "bay")
    clean = pirate_run(*words)
    bad = pirate_run(*words, "--line", "loss_in=20%", "--line", "loss_out=20%")

    assert (clean.exit_code, bad.exit_code) == (0, 0)
    assert clean.stdout != bad.stdout
