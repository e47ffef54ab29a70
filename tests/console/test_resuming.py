"""The console takes over a run that was cut off."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.cli.commands.console import open_console
from pirate_sm.cli.commands.resume import resume_dialog
from pirate_sm.cli.options.running import ConsoleOptions, RunOptions
from pirate_sm.core.errors import UsageError
from pirate_sm.running.runtime.ending import StopRequests
from pirate_sm.running.wiring import Order
from tests.unit.running.recording.recording_runs import record_cut_off

from .driving import operator, played


def test_its_mission_is_paused_where_it_was_and_goes_on_when_the_operator_says_so(
    tmp_path: Path,
) -> None:
    path = tmp_path / "cut.mcap"
    record_cut_off(path, Order("mitre_bend"), 16.0)
    dialog = resume_dialog(RunOptions(resume=str(path), accept=True), StopRequests())
    chosen = dialog.decide()
    assert chosen is not None
    prepared, resuming = chosen

    async def story() -> None:
        async with operator(prepared, resuming=resuming, then=dialog.prepared.loaded) as me:
            assert me.latest.state.mission.paused
            assert me.wheels_stand()
            assert "DoubleClamped" in me.states

            await me.look()
            await me.press("R")
            me.until(lambda: not me.wheels_stand())

            await me.press("space")
            me.until(me.wheels_stand)
            me.until(lambda: me.latest.state.mission.paused)
            await me.look()
            assert not me.latest.scene.loaded.program.goes_on  # by now it is elsewhere
            await me.command("ToggleLighting")

    played(story)


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (ConsoleOptions(resume="x.mcap", mission="mitre_bend"), "leave out: a mission"),
        (ConsoleOptions(resume="x.mcap", written={"settings": ["a=1"]}), "leave out: --set"),
    ],
)
def test_options_that_the_recording_has_are_refused(options: ConsoleOptions, why: str) -> None:
    with pytest.raises(UsageError, match=why):
        resume_dialog(options, StopRequests())


def test_a_phase_to_go_on_with_needs_a_recording(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pirate_sm.cli.commands.console._check_terminal", lambda: None)
    with pytest.raises(UsageError, match="--at: only together with --resume"):
        open_console(ConsoleOptions(at="pass"))
