from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from pirate_sm.core.effects import Ended, Fault
from pirate_sm.running.wiring import Order, prepare
from pirate_sm.views.console.availability import controls
from pirate_sm.views.showing import alarms, panels
from pirate_sm.views.showing.effect_lines import EffectLine
from pirate_sm.views.showing.panels import waiting
from pirate_sm.views.showing.snapshot import (
    Memory,
    NumberedLine,
    Snapshot,
    Trends,
    scene_of,
    snapshot_of,
)

ROOT = Path(__file__).parents[4]
PATROL = str(ROOT / "tests" / "robots" / "newt" / "patrol.yaml")


@pytest.fixture
def snapshot() -> Snapshot:
    return beginning(PATROL)


def beginning(mission: str, backend: str = "trace") -> Snapshot:
    """The moment when a mission begins."""
    prepared = prepare(Order(mission, backend=backend))
    scene = scene_of(prepared)
    state, effects = prepared.engine.start(0.0, prepared.backend.open())
    memory = Memory(scene.robot)
    memory.see(effects, 0.0)
    return snapshot_of(scene, prepared, state, 0.0, memory.story, Trends())


def after(snapshot: Snapshot, *effects: Fault | Ended) -> Snapshot:
    memory = Memory(snapshot.scene.robot)
    memory.see(effects, 1.0)
    return replace(snapshot, story=memory.story)


@pytest.mark.parametrize(
    ("outcome", "word"),
    [("succeeded", "SUCCEEDED"), ("failed", "FAILED"), ("interrupted", "STOPPED")],
)
def test_the_first_word_of_a_run_that_is_over_is_how_it_ended(
    snapshot: Snapshot, outcome: str, word: str
) -> None:
    over = replace(after(snapshot, Ended(outcome, "so it was")), over=True)

    assert panels.header(over, 80).plain.startswith(f" ■ {word} ")
    assert f"{word}: so it was" in str(alarms.bar(over, (), 80)[0])


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


def test_a_mission_that_has_not_begun_is_in_no_phase(snapshot: Snapshot) -> None:
    assert snapshot.state is not None
    program = snapshot.scene.loaded.program
    waiting_ = snapshot.state.mission._replace(pc=program.start, begun=False, paused_s=0.0)
    before = replace(snapshot, state=snapshot.state._replace(mission=waiting_))

    assert {each.plain[0] for each in panels.phases(snapshot, 40, 9)} >= {"▶"}
    assert not {each.plain[0] for each in panels.phases(before, 40, 9)} & {"▶", "▷"}


def test_phases_of_missions_that_are_called_are_left_out_where_there_is_little_room() -> None:
    bend = beginning("mitre_bend")
    names = bend.scene.loaded.program.phases
    called = [each.rpartition("/")[2] for each in names if "/" in each]
    few, many = (
        "\n".join(each.plain for each in panels.phases(bend, 40, rows))
        for rows in (len(names) - 1, len(names))
    )

    assert called
    assert all(each not in few for each in called)
    assert all(each in many for each in called)


def test_a_line_of_the_log_is_shown_in_full() -> None:
    told = NumberedLine(1, 2.0, EffectLine("warning", "every word of it " * 12))
    shown = panels.log([told], 60, 9)

    assert len(shown) > 1
    assert all(len(each) <= 60 for each in shown)
    assert " ".join(" ".join(each.plain for each in shown).split()) == (
        "2.00 warning " + ("every word of it " * 12).strip()
    )


def test_a_run_that_is_over_before_it_began_is_not_being_opened(snapshot: Snapshot) -> None:
    over = replace(after(snapshot, Ended("fault", "link.lost: no port")), state=None, over=True)

    assert [each.plain for each in panels.now(over, 60)] == ["link.lost: no port"]
    assert "being opened" in panels.now(replace(over, over=False), 60)[0].plain


def test_the_time_that_is_left_stands_below_what_is_waited_for(snapshot: Snapshot) -> None:
    assert not any("≈" in each.plain for each in panels.now(snapshot, 60))
    known = replace(snapshot, left="30.0 to 41.5 s left if it succeeds")
    assert panels.now(known, 60)[-1].plain == "≈ 30.0 to 41.5 s left if it succeeds"
    assert len(panels.now(known, 60)) == len(panels.now(snapshot, 60)) + 1
