from __future__ import annotations

import re
import sys
from bisect import bisect_left
from concurrent.futures import ProcessPoolExecutor
from math import isnan
from multiprocessing import get_context
from pathlib import Path
from pickle import HIGHEST_PROTOCOL, dumps, loads
from types import ModuleType

import pytest
from late import late
from representative import thorough_but

import pirate_sm
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.read.repair import repair

from .conftest import PATROL

pd = late("pandas")

BOUNDS = ("least", "force", "greatest")


@pytest.fixture(scope="module")
def recorded(
    patrol: pirate_sm.LoadedMission, tmp_path_factory: pytest.TempPathFactory
) -> tuple[pirate_sm.Run, pirate_sm.Run]:
    """A run as it has just ended, and as its recording has it."""
    file = tmp_path_factory.mktemp("runs") / "patrol.mcap"
    run = pirate_sm.run(patrol, seed=2, record=file)
    return run, pirate_sm.read(file)


def test_tables_are_columns_of_one_length_with_units(patrolled: pirate_sm.Run) -> None:
    for name in patrolled.tables:
        assert len({len(column) for column in patrolled.table(name).values()}) == 1
    assert {"time_s", "way_m"} <= patrolled.signals.keys()
    assert patrolled.states["Grip"][-1]
    assert "questions" not in patrolled.tables


def test_frames_of_a_glide_stay_together_until_somebody_asks() -> None:
    run = pirate_sm.run("mitre_bend")
    kept, steps = run.steps.kept, list(run.steps())  # type: ignore[attr-defined]

    assert 4 * len(kept) < len(steps)
    assert [step.number for step in steps] == list(range(len(steps)))
    assert run.duration_s == steps[-1].at_s


def test_pandas_takes_every_table(patrolled: pirate_sm.Run) -> None:
    signals = pd.DataFrame(patrolled.signals)
    commands = pd.DataFrame(patrolled.commands)

    assert signals["time_s"].is_monotonic_increasing
    assert signals["way_m"].max() > 0.05
    done = commands[commands.status == "done"].name.tolist()
    assert done[:3] == ["HoldNose", "HoldTail", "GoAhead"]


def test_tables_in_which_nothing_stands_have_their_columns(tmp_path: Path) -> None:
    nothing = (
        "format: 1\nmission: nothing\nrobot: pirate_ii\nstart: go\nphases:\n  go: {go: there}\n"
    )
    file = tmp_path / "nothing.yaml"
    file.write_text(f"{nothing}ends:\n  there: {{succeed: There}}\n")
    run = pirate_sm.run(file, "trace")

    assert run.faults["code"] == run.commands["name"] == run.signals["odometry_m"] == []
    assert run.table("questions")["choices"] == []
    assert run.states["BendingState"] == ["Unclamped"]
    for table in (run.faults, run.commands, run.signals):
        assert pd.DataFrame(table).empty
    assert {"faults", "commands", "signals"}.isdisjoint(run.tables)


def test_an_empty_table_has_the_columns_of_a_full_one(patrolled: pirate_sm.Run) -> None:
    empty = pirate_sm.run(PATROL, "trace").signals

    assert list(empty) == list(patrolled.signals)
    assert set(map(len, empty.values())) == {0}
    columns = ("time_s", "code", "message", "handling", "of")
    assert patrolled.faults == {name: [] for name in columns}


@pytest.mark.parametrize(
    "protocol", thorough_but([HIGHEST_PROTOCOL], range(2, HIGHEST_PROTOCOL + 1))
)
def test_a_run_can_be_pickled(recorded: tuple[pirate_sm.Run, pirate_sm.Run], protocol: int) -> None:
    for run in recorded:
        sent = loads(dumps(run, protocol))

        assert (repr(sent), sent.ended, sent.notices) == (repr(run), run.ended, run.notices)
        for name in run.tables:
            assert repr(sent.table(name)) == repr(run.table(name)), name
        assert sent.report().html == run.report().html


@pytest.mark.thorough
def test_a_run_reaches_another_process_and_comes_back(patrol: pirate_sm.LoadedMission) -> None:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        sent = pool.submit(pirate_sm.run, patrol, "trace").result()

    assert sent.commands == pirate_sm.run(patrol, "trace").commands


def test_errors_can_be_pickled_with_what_they_hold(faulty: Path, tmp_path: Path) -> None:
    (tmp_path / "empty.yaml").write_text("")
    with pytest.raises(pirate_sm.CheckError) as refused:
        pirate_sm.run(faulty)
    with pytest.raises(pirate_sm.LoadError) as unusable:
        pirate_sm.load(tmp_path / "empty.yaml")
    with pytest.raises(pirate_sm.UsageError) as usage:
        pirate_sm.run(PATROL, "serial")

    for error in (refused.value, unusable.value, usage.value):
        sent = loads(dumps(error))
        assert (type(sent), str(sent), sent.for_terminal) == (
            type(error),
            str(error),
            error.for_terminal,
        )
    assert loads(dumps(refused.value)).findings == refused.value.findings
    assert loads(dumps(unusable.value)).problems == unusable.value.problems


def test_whatever_a_notebook_prints_is_one_short_line(
    patrolled: pirate_sm.Run, faulty: Path
) -> None:
    session = pirate_sm.session(PATROL, "trace")
    before = repr(session)
    with session:
        during = repr(session)

    assert before == "<Session of patrol on trace: not entered>"
    assert during == "<Session of patrol on trace: going on at 0.00 s>"
    assert repr(session) == "<Session of patrol on trace: interrupted at 0.00 s>"
    assert repr(patrolled.loaded) == "<LoadedMission patrol: robot newt, in pipe elbow>"
    assert repr(pirate_sm.load(faulty)).endswith("robot pirate_ii, in pipe straight_113>")
    assert repr(pirate_sm.check(faulty)[0]).startswith(f"<Finding {faulty}:7:")
    assert repr(patrolled.report()).startswith("<Page of HTML: ")
    for each in (session, patrolled, patrolled.loaded, *pirate_sm.check(faulty)):
        assert "\n" not in repr(each)
        assert len(repr(each)) < 300


def test_a_recording_says_the_same_as_the_run(
    recorded: tuple[pirate_sm.Run, pirate_sm.Run],
) -> None:
    run, read = recorded

    assert (read.ended, read.duration_s) == (run.ended, run.duration_s)
    assert read.tables == run.tables
    for name in run.tables:
        assert repr(read.table(name)) == repr(run.table(name)), name


def test_the_mission_is_not_executed_across_the_gap_of_a_repaired_recording(tmp_path: Path) -> None:
    file = tmp_path / "patrol.mcap"
    pirate_sm.run(PATROL, seed=2, record=file)
    pieces = read_recording(file).content.pieces
    hit = pieces[len(pieces) // 2]
    data = bytearray(file.read_bytes())
    data[hit.at + hit.size // 2] ^= 1
    file.write_bytes(data)
    repaired = tmp_path / "repaired.mcap"
    repair(read_recording(file, damaged=True), repaired)
    (gap,) = read_recording(repaired).gaps

    signals = pirate_sm.read(repaired).signals
    after = bisect_left(signals["time_s"], gap.until_s)

    assert not any(map(isnan, signals["way_m"][:after]))
    assert all(map(isnan, signals["way_m"][after:]))
    assert "othing is known" in pirate_sm.read(repaired).report().html


def test_a_recording_of_a_run_from_another_phase_begins_there_too(tmp_path: Path) -> None:
    states = {"Grip": "BothHeld"}
    file = tmp_path / "look.mcap"
    run = pirate_sm.run(PATROL, "trace", start_phase="home", states=states, record=file)

    assert run.table("phases")["phase"][0] == "home"
    assert pirate_sm.read(file).table("phases") == run.table("phases")


def test_a_report_is_a_page_with_or_without_a_recording(
    recorded: tuple[pirate_sm.Run, pirate_sm.Run], tmp_path: Path
) -> None:
    run, read = recorded
    run.report().write(tmp_path / "run.html")

    assert "Back where it began" in (tmp_path / "run.html").read_text("utf-8")
    assert read.sha256 in read.report().html
    with pytest.raises(pirate_sm.UsageError, match="cannot be written"):
        run.report().write(tmp_path)


def test_a_report_replaces_a_report_and_nothing_else(
    patrolled: pirate_sm.Run, tmp_path: Path
) -> None:
    page, mission = tmp_path / "run.html", tmp_path / "first.yaml"
    mission.write_text("format: 1\n", "utf-8")
    patrolled.report().write(page)
    patrolled.report().write(page)

    with pytest.raises(pirate_sm.UsageError, match=r"first.yaml exists and is not a report"):
        patrolled.report().write(mission)
    assert mission.read_text("utf-8") == "format: 1\n"


def test_a_notebook_shows_a_summary_and_the_report(
    patrolled: pirate_sm.Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[pirate_sm.Page] = []
    module = ModuleType("IPython.display")
    module.display = shown.append  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "IPython", ModuleType("IPython"))
    monkeypatch.setitem(sys.modules, "IPython.display", module)

    patrolled.show()

    assert "<td>succeeded</td>" in patrolled._repr_html_()
    assert shown[0]._repr_html_().startswith("<iframe")
    assert "&lt;html" in shown[0]._repr_html_(), "the page is escaped inside the frame"


def test_show_without_a_notebook_says_what_to_do(
    patrolled: pirate_sm.Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "IPython.display", None)

    with pytest.raises(pirate_sm.UsageError, match="for notebooks"):
        patrolled.show()


def test_what_is_no_recording_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.mcap").write_text("mine")

    with pytest.raises(pirate_sm.RecordingError, match="not a recording"):
        pirate_sm.read(tmp_path / "notes.mcap")


@pytest.mark.thorough
def test_a_run_says_how_hard_the_robot_presses_and_between_which_bounds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "run.mcap"
    with pirate_sm.session("mitre_bend", record=file) as session:
        for command in ("ClampFront", "ClampRear"):
            session.submit(command)
            session.advance()
        clamped_s = session.now_s
        session.submit("DriveForward")
        session.advance(clamped_s + 2.0)
        driven_s = session.now_s
    found = pirate_sm.read(file).normal_forces(clamped_s)

    assert found == session.run.normal_forces(clamped_s)
    assert found["wheel"] == [*(f"wheel_{number}" for number in range(1, 7)), "sum"]
    assert sum(found["force_N"][:6]) == pytest.approx(found["force_N"][6])
    for least, force, greatest in zip(*(found[f"{name}_N"] for name in BOUNDS), strict=True):
        assert 0 < least < force < greatest
    driving = session.run.normal_forces(driven_s)
    assert driving["greatest_N"][6] / driving["least_N"][6] < 1.5  # currents show what wheels bear
    assert found["greatest_N"][6] / found["least_N"][6] > 5
    assert session.run.normal_forces(0.0)["wheel"] == []
    shown = session.run.report().html
    assert re.search(r"At \d+\.\d\d s: wheel_1 \d+ N \(\d+ to \d+ N\), .*, sum \d+ N \(\d", shown)
    monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    assert "pip install 'pirate-sm[fit]'" in session.run.report().html
    with pytest.raises(pirate_sm.UsageError, match="at_s"):
        session.run.normal_forces("now")  # type: ignore[arg-type]


@pytest.mark.thorough
def test_normal_forces_are_of_the_robot_that_ran() -> None:
    intervals = {}
    for hold in ("300 mNm", "40 mNm"):
        numbers = {"motors.wheel.hold_torque": hold}
        with pirate_sm.session("mitre_bend", numbers=numbers) as session:
            for command in ("ClampFront", "ClampRear"):
                session.submit(command)
                session.advance()
            found = session.run.normal_forces(session.now_s)
        intervals[hold] = found["greatest_N"][-1] - found["least_N"][-1]
    assert intervals["40 mNm"] < intervals["300 mNm"] / 3


@pytest.mark.thorough
def test_nothing_is_said_of_normal_forces_in_a_bend() -> None:
    run = pirate_sm.run("take_bend", seed=1)

    assert [bool(run.normal_forces(at_s)["wheel"]) for at_s in (6.0, 15.0, 30.0, 52.0)] == [
        *(True, False, False, True)
    ]
