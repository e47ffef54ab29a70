from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import pandas as pd
import pytest

import pirate_sm

from .conftest import PATROL


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
    assert patrolled.table("questions") == {}


def test_pandas_takes_every_table(patrolled: pirate_sm.Run) -> None:
    signals = pd.DataFrame(patrolled.signals)
    commands = pd.DataFrame(patrolled.commands)

    assert signals["time_s"].is_monotonic_increasing
    assert signals["way_m"].max() > 0.05
    done = commands[commands.status == "done"].name.tolist()
    assert done[:3] == ["HoldNose", "HoldTail", "GoAhead"]
    assert pd.DataFrame(patrolled.faults).empty


def test_a_recording_says_the_same_as_the_run(
    recorded: tuple[pirate_sm.Run, pirate_sm.Run],
) -> None:
    run, read = recorded

    assert (read.ended, read.duration_s) == (run.ended, run.duration_s)
    assert read.tables == run.tables
    for name in run.tables:
        assert repr(read.table(name)) == repr(run.table(name)), name


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
