"""A recording is executed again on the production engine; a change shows where it first counts."""

from __future__ import annotations

import json
import shutil
from itertools import pairwise
from math import isnan, nan

import pytest
from recording_runs import ROOT, record, record_serial
from representative import MISSIONS, thorough_but

from pirate_sm.core.effects import CommandStatus, Log, PhaseChange, Setpoints, StateChange
from pirate_sm.core.events import SensorFrame
from pirate_sm.core.loading import load_mission
from pirate_sm.core.robot import confirmed_parts
from pirate_sm.running.recording.format.json_values import state_from_text, state_to_text
from pirate_sm.running.recording.read import pieces
from pirate_sm.running.recording.read.pieces import Gap
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import as_recorded, recorded_mission
from pirate_sm.running.recording.replay import engine_of, replay, rerun, rerun_steps, same
from pirate_sm.running.recording.write import piece_maker, recorder
from pirate_sm.running.wiring import Order
from pirate_sm.simulation.bay.bay_defects import Switches

SHIPPED = sorted(path.stem for path in (ROOT / "sequences").glob("*.yaml"))
SHORT = [name for name in SHIPPED if not name.startswith("exp_1") and name != "exp_2a_commands"]
# They differ in their control, and last two minutes each; exp_3d does all that exp_3b and c do.
ALIKE = ["exp_3b", "exp_3c"]
SHORT = [
    *thorough_but(MISSIONS, [name for name in SHORT if name not in ALIKE]),
    *(pytest.param(name, marks=pytest.mark.slow) for name in ALIKE),
]


@pytest.fixture(scope="module")
def bend(tmp_path_factory):
    path = tmp_path_factory.mktemp("runs") / "bend.mcap"
    return record(path, Order("mitre_bend", seed=5, check=False))


@pytest.mark.parametrize("backend", ["trace", pytest.param("sim", marks=pytest.mark.thorough)])
def test_breakpoints_pause_a_replay_where_they_paused_the_run(backend, tmp_path):
    where = ("enter", "pass_bend.yaml:20", "halt")
    order = Order("mitre_bend", backend=backend, breakpoints=where, check=False)
    recording = record(tmp_path / "run.mcap", order)

    lines = [log for step in recording.steps() for log in step.effects if isinstance(log, Log)]
    hits = [each.message for each in lines if each.message.startswith("breakpoint")]
    assert [each.split()[1] for each in hits] == ["enter", "pass/pass_bend.pass", "halt"]
    with recorded_mission(recording.header) as loaded:
        assert replay(recording, loaded).difference is None


@pytest.mark.parametrize("name", thorough_but(MISSIONS, SHIPPED))
def test_every_shipped_mission_comes_out_the_same_in_a_trace(name, tmp_path):
    recording = record(tmp_path / "run.mcap", Order(name, backend="trace"))

    with recorded_mission(recording.header) as loaded:
        assert replay(recording, loaded).difference is None


@pytest.mark.thorough
@pytest.mark.parametrize("name", SHORT)
def test_every_shipped_mission_comes_out_the_same_over_the_serial_link(name, tmp_path):
    recording = record_serial(tmp_path / "run.mcap", name, Switches())

    with recorded_mission(recording.header) as loaded:
        result = replay(recording, loaded)

    assert result.difference is None
    assert result.steps > 100


def test_a_run_over_a_bad_line_comes_out_the_same(tmp_path):
    switches = Switches(loss_in=0.2, loss_out=0.2, corruption=0.01, reset_at_s=(9.0,))
    recording = record_serial(tmp_path / "run.mcap", "mitre_bend", switches, seed=3)

    with recorded_mission(recording.header) as loaded:
        assert replay(recording, loaded).difference is None


def test_a_mission_with_files_of_its_own_is_made_again_from_the_recording_alone(tmp_path):
    folder = tmp_path / "newt"
    shutil.copytree(ROOT / "tests" / "robots" / "newt", folder)
    recording = record(tmp_path / "run.mcap", Order(str(folder / "patrol.yaml")))
    shutil.rmtree(folder)

    with recorded_mission(recording.header) as loaded:
        result = replay(read_recording(tmp_path / "run.mcap"), loaded)

    assert result.difference is None


def changed(tmp_path, file, old, new):
    """The shipped bend mission and robot with one thing changed."""
    for name in ("sequences", "hardware_profiles"):
        shutil.copytree(ROOT / name, tmp_path / name, dirs_exist_ok=True)
    path = tmp_path / file
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return load_mission(
        tmp_path / "sequences" / "mitre_bend.yaml",
        robot=str(tmp_path / "hardware_profiles" / "pirate_ii"),
        pipe=str(tmp_path / "sequences" / "pipes" / "mitre_90.yaml"),
    )


@pytest.mark.parametrize(
    ("file", "old", "new", "phase"),
    [
        ("sequences/mitre_bend.yaml", "when: detector == in", "when: detector == past", "prepare"),
        ("sequences/mitre_bend.yaml", "      - DriveForward\n", "", "enter"),
        (
            "hardware_profiles/pirate_ii/profile.yaml",
            "loaded: [gamma_1, gamma_2], share: 70 %, at_least: 100 mNm, settled: 1.5 s",
            "loaded: [gamma_1, gamma_2], torque: 900 mNm",
            "enter",
        ),
    ],
)
def test_a_change_shows_the_first_difference(bend, tmp_path, file, old, new, phase):
    loaded = as_recorded(changed(tmp_path, file, old, new), bend.header)

    result = replay(bend, loaded, changed=True)

    assert result.difference is not None
    assert result.difference.phase.split("/")[0] == phase
    assert result.difference.recorded != result.difference.replayed
    assert result.steps == result.difference.step.number


def test_a_changed_chart_shows_the_first_difference(bend, tmp_path):
    loaded = changed(
        tmp_path,
        "hardware_profiles/pirate_ii/chart.yaml",
        "{event: Brake, target: RearWheelsState.Fixed}",
        "{event: Brake, target: RearWheelsState.Free}",
    )

    result = replay(bend, as_recorded(loaded, bend.header), changed=True)

    assert result.difference is not None
    assert any(
        isinstance(each, CommandStatus | Setpoints) or "Free" in repr(each)
        for each in result.difference.replayed
    )


def test_a_rerun_knows_the_engine_after_every_step(bend):
    with recorded_mission(bend.header) as loaded:
        states = [again.state for again in rerun(bend, loaded) if again.step.by == "engine"]

    assert states[-1].mission.ended
    assert all(state is not None for state in states)


@pytest.mark.thorough
def test_after_a_gap_that_is_known_which_the_records_after_it_say(bend):
    with recorded_mission(bend.header) as loaded:
        whole = list(rerun(bend, loaded))
        engine = engine_of(bend.header, loaded)
    kept = whole[-1].step.number - 100
    steps = [it.step._replace(state=it.state if it.step.number == kept else None) for it in whole]
    gap = Gap(steps[700].number, 0.0, steps[700].at_s)

    again = list(rerun_steps(engine, steps[:600] + steps[700:], [gap]))[600:]

    robot, heard, changed = loaded.robot, set(), False
    assert [it.at_s for it in again] == [it.at_s for it in whole[700:]]
    for it, right in zip(again, (it.state for it in whole[700:]), strict=True):
        if it.step.number >= kept:
            assert same(it.state, right)
            continue
        if isinstance(it.step.event, SensorFrame):
            heard.add(it.step.event.board)
        changed |= any(isinstance(each, StateChange) for each in it.step.effects)
        assert not changed or it.state.robot.configuration == right.robot.configuration
        assert confirmed_parts(robot, it.state.robot) <= confirmed_parts(robot, right.robot)
        shown = it.state.sensing.numbers
        assert isnan(shown[robot.odometry])
        for board in map(robot.boards.__getitem__, heard):
            assert not any(isnan(shown[at]) for _, at, _ in board.channels)
            torques = {
                each.target for each in board.derived if each.how == "torque"
            }  # the echo of an array may be under way
            for at in board.numbers:
                true = right.sensing.numbers[at]
                alike = shown[at] * true >= 0.0 if at in torques else same(shown[at], true)
                assert isnan(shown[at]) or alike
    assert changed
    assert heard == set(robot.boards)
    assert any(isinstance(each, PhaseChange) for it in again for each in it.step.effects)


@pytest.mark.parametrize(
    ("one", "other", "alike"),
    [
        (nan, nan, True),
        ((1.0, (nan, "a")), (1.0, (nan, "a")), True),
        ((1.0,), (1.0, 2.0), False),
        (1.0, 1.0000000000000002, False),
        (CommandStatus("A", "sent"), CommandStatus("A", "done"), False),
        (CommandStatus("A", "sent"), ("A", "sent", "", ""), False),
    ],
)
def test_unknown_is_the_same_as_unknown_and_nothing_else_is_rounded(one, other, alike):
    assert same(one, other) is alike


# --- beginning anywhere ---------------------------------------------------------------------


@pytest.fixture
def often(monkeypatch):
    """Checkpoints come several times in a run of seconds."""
    monkeypatch.setattr(recorder, "CHECKPOINT_S", 2.0)


def replayed_piece_by_piece(recording, loaded):
    """From each checkpoint the run comes to the next one, in the state that is stored there.

    An engine in the same state does the same, so from each it comes to the end as well.
    """
    checkpoints = list(recording.checkpoints())
    for after, until in pairwise((None, *checkpoints, None)):
        result = replay(recording, loaded, after=after, until=until)
        assert result.difference is None
        assert result.executed
        if after is not None and until is not None:
            assert result.steps == until.step - after.step
    return checkpoints


@pytest.mark.thorough
@pytest.mark.parametrize("name", SHORT)
def test_every_shipped_mission_comes_out_the_same_from_its_start_and_every_checkpoint(
    name, tmp_path, often
):
    recording = record(tmp_path / "run.mcap", Order(name, seed=2))

    with recorded_mission(recording.header) as loaded:
        result = replay(recording, loaded)
        checkpoints = replayed_piece_by_piece(recording, loaded)

    assert result.difference is None
    assert result.steps > 100
    assert len(checkpoints) >= recording.until_s // 2.1 - 1


@pytest.mark.thorough
def test_from_every_checkpoint_the_run_is_replayed_to_its_end(tmp_path, often):
    recording = record(tmp_path / "run.mcap", Order("mitre_bend", seed=2))

    with recorded_mission(recording.header) as loaded:
        whole = replay(recording, loaded)
        assert whole.difference is None
        for checkpoint in recording.checkpoints():
            result = replay(recording, loaded, after=checkpoint)
            assert result.difference is None
            assert result.steps == whole.steps - checkpoint.step - 1
            assert result.until_s == max(whole.until_s, checkpoint.at_s)


def test_from_every_checkpoint_over_a_bad_line_the_same_comes_out_again(tmp_path, often):
    switches = Switches(loss_in=0.2, loss_out=0.2, corruption=0.01, reset_at_s=(9.0,))
    recording = record_serial(tmp_path / "run.mcap", "mitre_bend", switches, seed=3)

    with recorded_mission(recording.header) as loaded:
        assert len(replayed_piece_by_piece(recording, loaded)) >= 2


def test_a_state_comes_back_whatever_the_engine_is_at(bend):
    with recorded_mission(bend.header) as loaded:
        states = [again.state for again in rerun(bend, loaded) if again.state is not None]

    for state in states[:: len(states) // 300]:
        assert same(state_from_text(state_to_text(state)), state)


@pytest.mark.parametrize(
    "written", ["{}", "[]", "nonsense", "null", '{"robot": 3}', '{"faults": {}}']
)
def test_a_state_of_another_engine_is_refused(written):
    with pytest.raises(ValueError):  # noqa: PT011 - of whatever kind
        state_from_text(written)


def test_a_state_of_an_engine_without_loops_of_states_is_read(bend):
    with recorded_mission(bend.header) as loaded:
        states = [again.state for again in rerun(bend, loaded) if again.state is not None]
    seeking = next(each for each in states if each.robot.flight and each.robot.loops)
    content = json.loads(state_to_text(seeking))
    del content["robot"]["overtaken"]
    del content["robot"]["flight"]["since_s"]
    del content["robot"]["flight"]["before"]

    assert same(state_from_text(json.dumps(content)), seeking)


def test_the_checkpoint_before_a_time_is_found(tmp_path, often):
    recording = record(tmp_path / "run.mcap", Order("mitre_bend", seed=2))
    every = list(recording.checkpoints())

    assert recording.checkpoint(every[0].at_s - 0.001) is None
    assert recording.checkpoint(every[2].at_s) == every[2]
    assert recording.checkpoint(every[3].at_s - 0.001) == every[2]
    assert recording.checkpoint(1e9) == every[-1]


def test_a_state_that_has_changed_is_a_difference(tmp_path, often, monkeypatch):
    right, calls = piece_maker.state_to_text, 0

    def wrong(state):
        nonlocal calls
        calls += 1
        sensing = state.sensing._replace(loss=0.875)
        return right(state._replace(sensing=sensing) if calls == 3 else state)

    monkeypatch.setattr(piece_maker, "state_to_text", wrong)
    recording = record(tmp_path / "run.mcap", Order("mitre_bend", seed=2))
    third = list(recording.checkpoints())[2]

    with recorded_mission(recording.header) as loaded:
        result = replay(recording, loaded)

    assert result.difference is not None
    assert result.difference.step.number == third.step
    assert result.difference.remembers == ("sensing.loss",)


def test_another_version_does_not_take_checkpoints_for_its_own(tmp_path, often, monkeypatch):
    recording = record(tmp_path / "run.mcap", Order("mitre_bend", seed=2))
    monkeypatch.setattr(pieces, "__version__", "0.0.1")

    assert recording.checkpoint(1e9) is None
    assert list(recording.checkpoints()) == []
    with recorded_mission(recording.header) as loaded:
        assert replay(recording, loaded).difference is None


def test_a_replay_of_a_stretch_ends_where_it_shall(tmp_path, often):
    recording = record(tmp_path / "run.mcap", Order("mitre_bend", seed=2))
    checkpoint = recording.checkpoint(5.0)

    with recorded_mission(recording.header) as loaded:
        result = replay(recording, loaded, after=checkpoint, until_s=8.0)

    assert 4.0 < result.from_s <= 5.0
    assert 7.9 < result.until_s <= 8.0
    assert 0 < result.steps < 400
