"""Which recordings a session leaves behind."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from pirate_sm.cli.new_recording import RUNS_VARIABLE
from pirate_sm.cli.run_recording import RecordingOptions, recorded
from pirate_sm.console.session import Keeping
from pirate_sm.model.events import GoTo, OperatorCommand
from pirate_sm.recording.reader import read_recording
from pirate_sm.report.listing import listed
from pirate_sm.wiring import Prepared

from .driving import Operator, operator, played, with_mission


@pytest.fixture
def runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(RUNS_VARIABLE, str(tmp_path))
    return tmp_path


def keep(prepared: Prepared) -> AbstractContextManager[Keeping]:
    return recorded(prepared, RecordingOptions(), 1.0)


async def leave(me: Operator) -> None:
    me.clock.free()
    me.session.quit()
    assert me.session.join(10.0)


def test_a_run_in_which_nothing_was_asked_for_leaves_no_recording(runs: Path) -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace"), keep=keep) as me:
            me.wait(1.0)
            assert list(runs.glob("*.mcap"))
            await leave(me)

    played(story)
    assert not list(runs.iterdir())


def test_after_a_stop_the_run_that_was_begun_is_left_and_not_the_one_that_waits(
    runs: Path,
) -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace"), keep=keep) as me:
            await me.look()
            await me.press("R")
            me.until(lambda: me.states[2] == "DoubleClamped")
            await me.press("space")
            me.until(lambda: any("ended interrupted: stopped" in each for each in me.told()))
            me.until(lambda: me.latest.state.mission.paused)
            await leave(me)

    played(story)
    (left,) = runs.glob("*.mcap")
    assert read_recording(left).complete


def test_the_duration_of_a_later_run_is_its_own(runs: Path) -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace"), keep=keep) as me:
            me.wait(20.0)
            me.session.stop()
            me.wait(1.0)
            me.until(lambda: me.latest.state is not None and me.latest.state.look is None)
            me.session.tell(OperatorCommand("ClampFront"))
            me.until(lambda: me.states[2] == "FrontClampedRearRelaxed")
            await leave(me)

    played(story)
    (left,) = runs.glob("*.mcap")
    recording = read_recording(left)
    (*_, last) = recording.steps()
    assert last.at_s > 20.0
    assert 0.0 < listed(recording, "").duration_s < 10.0


def test_a_series_of_commands_is_something_that_was_asked_for(runs: Path) -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace"), keep=keep) as me:
            me.session.give(("ClampFront",), GoTo("prepare", ()))
            me.until(lambda: me.states[2] == "FrontClampedRearRelaxed")
            await leave(me)

    played(story)
    assert len(list(runs.glob("*.mcap"))) == 1
