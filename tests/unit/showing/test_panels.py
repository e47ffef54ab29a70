from __future__ import annotations

from dataclasses import replace
from math import nan
from pathlib import Path

import pytest

from pirate_sm.backends.serial.health import LinkHealth
from pirate_sm.console.availability import controls
from pirate_sm.model.effects import Ended, Fault
from pirate_sm.showing import panels
from pirate_sm.showing.live_snapshots import Trends, scene_of, snapshot_of
from pirate_sm.showing.progress_lines import waiting
from pirate_sm.showing.run_history import Memory
from pirate_sm.showing.snapshot import Snapshot
from pirate_sm.wiring import Order, prepare

ROOT = Path(__file__).parents[3]
PATROL = str(ROOT / "tests" / "robots" / "newt" / "patrol.yaml")


@pytest.fixture
def snapshot() -> Snapshot:
    return beginning(PATROL)


def beginning(mission: str) -> Snapshot:
    """The moment when a mission begins."""
    prepared = prepare(Order(mission, backend="trace"))
    scene = scene_of(prepared)
    state, effects = prepared.engine.start(0.0, prepared.backend.open())
    memory = Memory(scene.robot)
    memory.see(effects, 0.0)
    return snapshot_of(scene, prepared, state, 0.0, memory.story(), Trends())


def after(snapshot: Snapshot, *effects: Fault | Ended) -> Snapshot:
    memory = Memory(snapshot.scene.robot)
    memory.see(effects, 1.0)
    return replace(snapshot, story=memory.story())


def away(snapshot: Snapshot) -> Snapshot:
    link = LinkHealth(9, 0, 3, 0, 0, nan, 2.5, "nothing comes from the robot", 7.6)
    return replace(snapshot, link=link)


def test_a_warning_goes_when_its_cause_has_gone(snapshot: Snapshot) -> None:
    code = snapshot.scene.robot.faults[0].code
    told = after(snapshot, Fault(code, "it is so", "continue"))
    assert told.state is not None
    faults = told.state.faults._replace(raised=frozenset({0}))
    raised = replace(told, state=told.state._replace(faults=faults))

    assert f"{code}: it is so" in str(panels.alarm(raised, 0))
    assert panels.alarm(told, 0) is None


def test_a_warning_whose_cause_nobody_follows_stays_until_it_is_seen(snapshot: Snapshot) -> None:
    told = after(snapshot, Fault("firmware.reset", "the controller was reset", "continue"))

    assert "firmware.reset" in str(panels.alarm(told, 0))
    assert panels.alarm(told, 10**9) is None


def test_a_silent_board_is_a_cause_that_may_go(snapshot: Snapshot) -> None:
    told = after(snapshot, Fault("sensor.silent", "the board says nothing", "continue"))
    assert told.state is not None
    faults = told.state.faults._replace(silent=frozenset({0}))

    assert panels.alarm(replace(told, state=told.state._replace(faults=faults)), 0) is not None
    assert panels.alarm(told, 0) is None


@pytest.mark.parametrize(
    ("outcome", "word"),
    [("succeeded", "SUCCEEDED"), ("failed", "FAILED"), ("interrupted", "STOPPED")],
)
def test_the_first_word_of_a_run_that_is_over_is_how_it_ended(
    snapshot: Snapshot, outcome: str, word: str
) -> None:
    over = replace(after(snapshot, Ended(outcome, "so it was")), over=True)

    assert panels.header(over, 80).plain.startswith(f" ■ {word} ")
    assert f"{word}: so it was" in str(panels.alarm(over, 0))


def test_a_stop_says_for_how_long_it_waits_for_a_link_that_is_away(snapshot: Snapshot) -> None:
    running = away(snapshot)
    assert running.state is not None
    mission = running.state.mission._replace(ending=Ended("interrupted", "Ctrl-C"))
    stopping = replace(running, state=running.state._replace(mission=mission))

    assert str(panels.trouble(running)).strip() == (
        "⚠ link: nothing comes from the robot, for 2.5 s"
    )
    assert "stopping waits for the link, given up in 8 s" in str(panels.trouble(stopping))


@pytest.mark.parametrize("width", [20, 40, 80, 200])
def test_no_header_is_wider_than_the_screen(snapshot: Snapshot, width: int) -> None:
    assert len(panels.header(snapshot, width, how="sim (seed 0)", pace="4 ×")) <= max(width, 30)


SWITCHING = f"""\
format: 1
mission: switching
robot: {ROOT / "hardware_profiles" / "pirate_ii"}
starts_in: {{BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}}
control: exp_3a
start: p
phases: {{p: {{do: [ToggleLighting], go: done}}}}
ends: {{done: {{succeed: Done}}}}
"""


def test_a_control_is_waited_for_and_may_be_passed_over(tmp_path: Path) -> None:
    mission = tmp_path / "switching.yaml"
    mission.write_text(SWITCHING, encoding="utf-8")

    switching = beginning(str(mission))

    said, left = (each.plain for each in waiting(switching, 40))
    assert said == "○ exp_3a: until the joints bear their torques"
    assert left.endswith("10.0 s left")
    assert {each.name: each.reason for each in controls(switching, None)}["skip"] == ""


@pytest.mark.parametrize("width", [40, 78])
def test_the_control_in_force_stands_beside_the_states(tmp_path: Path, width: int) -> None:
    mission = tmp_path / "switching.yaml"
    mission.write_text(SWITCHING, encoding="utf-8")
    usual = mission.with_name("usual.yaml")
    usual.write_text(SWITCHING.replace("control: exp_3a\n", ""), encoding="utf-8")

    switched, as_ever = (
        "\n".join(each.plain for each in panels.states(beginning(str(file)), width))
        for file in (mission, usual)
    )

    assert "◆ Control" in switched
    assert "exp_3a" in switched
    assert "Control" not in as_ever
