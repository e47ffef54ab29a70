"""What somebody does who has never seen the robot, from the first key to the stop."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from textual.widgets import OptionList

from pirate_sm.views.console import availability
from pirate_sm.views.console.dialogs import Confirm
from pirate_sm.views.console.hand_back import not_passed
from pirate_sm.views.showing import panels

from .driving import by_hand, operator, played, with_mission
from .test_looks import text_of


@pytest.mark.thorough
def test_somebody_drives_in_by_hand_and_lets_the_bend_mission_take_over() -> None:
    async def story() -> None:
        prepared = by_hand()  # nothing to check yet; missions are
        prepared = replace(prepared, order=replace(prepared.order, check=True))
        async with operator(prepared) as me:
            assert me.latest.scene.mission == ""

            # The mission is chosen from the list; it begins paused, the robot is still theirs.
            await me.press("M")
            await me.look()
            await me.choose("mitre_bend")
            assert me.latest.scene.mission == "mitre_bend"
            assert me.latest.state.mission.paused

            # In by hand, until the detector sees the bend.
            for command in ("ClampFront", "ClampRear", "ToggleLighting", "DriveForward"):
                await me.command(command)
            assert me.states[2] == "DoubleClamped"
            assert not me.wheels_stand()
            me.until(lambda: me.latest.state.outside("detector") == "close")
            await me.command("Brake")  # who still chooses would drive into the bend unbent

            # Its beginning is greyed, with what the engine would say; a later phase is not.
            await me.look()
            go = availability.controls(me.latest, me.app.entries(me.latest))[0]
            assert "ClampFront" in go.reason
            assert "unneeded: it is so already" in go.reason
            await me.press("R")
            assert me.latest.state.mission.paused
            await me.press("H")
            for _ in range(3):
                await me.look()  # the commands that lead to each phase are looked for
            lines = {
                option.id: str(option.prompt)
                for option in me.app.screen.query_one(OptionList).options
            }
            assert lines["enter"].startswith("✕")
            assert not lines["prepare"].startswith("✕")
            await me.choose("prepare")
            assert isinstance(me.app.screen, Confirm)  # the wait of enter was not passed
            await me.press("y")
            me.until(lambda: me.latest.story.phase.phase.startswith("prepare"), 5)

            # Pause: the wheels stand, the clamps hold. Resume: it goes on.
            me.wait(2.0)
            await me.press("P")
            me.until(lambda: me.latest.state.mission.paused, 5)
            me.wait(1.0)
            assert me.wheels_stand()
            await me.press("R")
            me.wait(0.5)
            assert not me.latest.state.mission.paused

            # Taken over in the bend, by the light; handed back where it was.
            me.until(lambda: me.latest.story.phase.phase.startswith("pass"), 90)
            me.wait(1.0)
            await me.press("P")
            me.until(lambda: me.latest.state.mission.paused and not me.latest.state.robot.flight)
            assert me.latest.state.robot.motion is None or me.latest.state.mission.before_pause

            # The stop.
            await me.press("space")
            me.wait(0.5)
            assert me.wheels_stand()
            assert "ended interrupted: stopped by the operator" in me.told()
            assert me.latest.state.mission.paused
            assert not me.latest.over

    played(story)


@pytest.mark.thorough
def test_a_mission_that_was_taken_over_is_handed_back_where_it_fits() -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend")) as me:
            await me.look()
            await me.press("R")
            me.until(lambda: me.states[0] == "DrivingForward" and me.waits)
            await me.press("P")
            me.until(lambda: me.latest.state.mission.paused)
            me.wait(0.5)
            await me.command("Brake")  # taken over
            await me.press("R")
            assert me.latest.state.mission.paused
            assert "the configuration has been changed" in {
                each.reason for each in availability.controls(me.latest, me.app.entries(me.latest))
            }

            await me.command("DriveForward")
            me.until(lambda: me.latest.state.outside("detector") == "close")
            await me.command("Brake")  # who still chooses would drive into the bend unbent
            await me.look()
            await me.press("H")
            for _ in range(3):
                await me.look()  # the commands that lead to each phase are looked for
            await me.choose("prepare")
            await me.press("y")  # the wait of enter was not passed
            me.until(lambda: me.latest.story.phase.phase.startswith("pass"), 90)
            assert any("handed back at prepare" in each for each in me.told())

    played(story)


def test_a_question_is_answered_by_a_number(tmp_path: Path) -> None:
    mission = tmp_path / "asks.yaml"
    mission.write_text(ASKS)

    async def story() -> None:
        async with operator(with_mission(str(mission), backend="trace"), size=(80, 24)) as me:
            await me.look()
            await me.press("R")
            await me.look()
            assert panels.choices(me.latest) == ("Is it straight?", ("yes", "no"))
            await me.press("9")
            await me.press("2")
            assert "log answered 'no' (operator)" in me.told()
            me.until(lambda: any("ended" in each for each in me.told()))
            assert "ended failed: It is not" in me.told()
            assert not me.latest.over  # it can be begun again

    played(story)


@pytest.mark.thorough
def test_a_step_of_a_mission_that_was_stopped_needs_a_phase_first() -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace")) as me:
            await me.look()
            await me.press("R")
            me.until(lambda: me.latest.story.phase.phase == "enter" and me.waits)
            await me.press("K")
            me.until(lambda: me.latest.story.phase.phase == "prepare" and me.waits)
            await me.press("space")
            me.until(lambda: me.latest.story.stopped and me.latest.state.mission.paused)
            me.until(lambda: me.latest.state.look is None)
            await me.look()
            step = availability.controls(me.latest, me.app.starts(me.latest))[2]
            assert step.reason == "choose a phase first: r"

            await me.press("full_stop")
            me.wait(1.0)
            assert me.latest.state.mission.paused
            assert not me.latest.state.mission.begun
            assert me.latest.stopped_in == "prepare"

    played(story)


@pytest.mark.thorough
def test_a_wait_that_was_passed_before_the_stop_is_not_asked_about_as_its_phase_is_done() -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace")) as me:
            await me.look()
            await me.press("R")
            me.until(lambda: me.latest.story.phase.phase == "enter" and me.waits)
            await me.press("K")
            me.until(lambda: me.latest.story.phase.phase == "prepare" and me.waits)
            passed = me.latest.story.passed
            assert passed
            await me.press("space")
            me.until(lambda: me.latest.story.stopped and me.latest.state.mission.paused)
            await me.look()
            assert re.search(r"✓ enter +\d", text_of(me))
            program = me.latest.scene.loaded.program
            assert not_passed(program, "pass", me.latest.story.passed) == "its wait of prepare"

    played(story)


ASKS = """
format: 1
mission: asks
robot: pirate_ii
start: look
phases:
  look:
    do:
      - ask: Is it straight?
        choices: {"yes": good, "no": bad}
        timeout: 60 s
    go: good
ends:
  good: {succeed: It is}
  bad: {fail: It is not}
"""


@pytest.mark.thorough
def test_a_mission_that_was_stopped_says_where_and_is_handed_back_there() -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend")) as me:
            await me.look()
            assert availability.controls(me.latest, None)[0].label == "Run: start"
            await me.press("R")
            me.until(lambda: me.latest.story.phase.phase.startswith("prepare"))
            await me.press("space")
            me.until(lambda: me.latest.story.stopped and me.latest.state.mission.paused)
            assert me.latest.story.stopped_in_phase.startswith("prepare/prepare_bend.")
            await me.look()
            shown = text_of(me)
            left = me.latest.story.stopped_in_phase
            assert f"stopped in {left}" in shown
            assert re.search(rf"■ +{left.rpartition('/')[2]} +\d", shown)  # how long it was there
            assert re.search(r"✓ enter +\d", shown)

            await me.press("R")
            await me.look()
            listed = me.app.screen.query_one(OptionList)
            assert listed.border_title == f"Hand back at (it was stopped in {left})"
            assert listed.options[listed.highlighted].id == left
            await me.press("enter")
            await me.look()
            if isinstance(me.app.screen, Confirm):  # its waits, or the drive that was stopped
                await me.press("y")
            me.until(lambda: me.latest.story.phase.phase.startswith("pass"), 90)
            assert not me.latest.story.stopped_in_phase

    played(story)
