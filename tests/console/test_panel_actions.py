"""A control panel beside the console: its buttons do what the keys do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from threading import Event
from typing import Any

import pytest

from pirate_sm.core import library
from pirate_sm.core.events import GoTo, Pause
from pirate_sm.core.loading import load_robot
from pirate_sm.robot.control_panel.panel_file import load_panel
from pirate_sm.robot.control_panel.panel_reader import Connection, Happening, PanelReader
from pirate_sm.robot.control_panel.presses import LinePress, Press
from pirate_sm.robot.detectors.registry import Detecting
from pirate_sm.running.wiring import Order, Prepared
from pirate_sm.views.console.app import Console
from pirate_sm.views.console.dialogs import Confirm, Pick
from pirate_sm.views.console.session import OperatorSession
from pirate_sm.views.report.page_process import page_buttons

from .driving import WALL_S, Operator, by_hand, confirming, operator, played, with_mission

SMALL = (80, 24)
PANEL = load_panel(
    library.find_panel("nanokontrol2", library.shipped()), load_robot(library.robots()[0])
)


class Desk:
    """A panel on which the test presses."""

    panel = PANEL

    def __init__(self) -> None:
        self.waiting: list[Happening] = []
        self.notices: list[str] = []

    def taken(self) -> list[Happening]:
        waiting, self.waiting = self.waiting, []
        return waiting

    async def press(self, me: Operator, *names: str) -> None:
        self.waiting += [Press(name, PANEL.buttons[name]) for name in names]
        me.app.heed_panel()
        await me.look()
        me.wait(0.1)
        await me.look()

    def console(self) -> Callable[[OperatorSession], Console]:
        reader: Any = self
        notices = self.notices

        class Telling(Console):
            def notify(self, message: str, **how: Any) -> None:
                notices.append(message)  # those on the screen vanish with the wall's time

        return lambda session, **how: Telling(session, reader, **how)


def trace() -> Prepared:
    return by_hand(Order("by_hand", backend="trace"))


def test_commands_are_given_and_what_is_impossible_is_refused_with_the_reason() -> None:
    async def story() -> None:
        desk = Desk()
        async with operator(trace(), size=SMALL, console=desk.console()) as me:
            await desk.press(me, "S1")
            me.until(lambda: me.latest.state and me.latest.state.robot.motion is None)
            assert "FrontClampedRearRelaxed" in me.states

            await desk.press(me, "S1")
            assert [each.partition(":")[0] for each in desk.notices] == ["ClampFront"]

    played(story)


@pytest.mark.thorough
def test_the_mission_is_started_paused_and_led_by_steps() -> None:
    async def story() -> None:
        desk = Desk()
        prepared = with_mission("mitre_bend", "trace")
        async with operator(prepared, size=SMALL, console=desk.console()) as me:
            await me.look()
            await desk.press(me, "PLAY")
            me.until(lambda: me.latest.state and not me.latest.state.mission.paused)

            await desk.press(me, "REC")
            me.until(lambda: me.latest.state and me.latest.state.mission.paused)

            await desk.press(me, "FF")
            me.until(lambda: any("resumed" in each for each in me.told()))
            me.until(lambda: me.latest.state and me.latest.state.mission.paused)

    played(story)


@pytest.mark.thorough
def test_a_mission_that_was_stopped_is_not_begun_by_the_panel_which_stays_usable() -> None:
    async def story() -> None:
        desk = Desk()
        prepared = with_mission("mitre_bend", "trace")
        async with operator(prepared, size=SMALL, console=desk.console()) as me:
            await me.look()
            await desk.press(me, "PLAY")
            me.until(lambda: me.latest.story.phase.phase == "enter" and me.waits)
            me.session.stop()
            me.until(lambda: me.latest.story.stopped and me.latest.state.mission.paused)
            me.until(lambda: me.latest.state.look is None)
            await desk.press(me, "PLAY")
            asked = "it was stopped: choose the phase with r at the keyboard"
            assert desk.notices == [f"go: {asked}"]
            assert len(me.app.screen_stack) == 1

            await desk.press(me, "S2")
            assert desk.notices[1:] == ["ClampRear: unneeded: it is so already"]
            await me.press("R")
            await me.look()
            assert isinstance(me.app.screen, Pick)

    played(story)


def test_letting_go_is_asked_and_answered_on_the_panel() -> None:
    async def story() -> None:
        desk = Desk()
        async with operator(trace(), size=SMALL, console=desk.console()) as me:
            await me.command("ClampFront")
            await desk.press(me, "SET+R8")
            assert isinstance(me.app.screen, Confirm)
            await desk.press(me, "S1")
            assert any("a dialog is open" in each for each in desk.notices)

            await desk.press(me, "MARKER_RIGHT")
            assert not isinstance(me.app.screen, Confirm)
            assert "FrontClampedRearRelaxed" in me.states

            await desk.press(me, "SET+R8")
            await desk.press(me, "MARKER_LEFT")
            me.until(lambda: "Unclamped" in me.states)

    played(story)


def test_the_first_motion_of_a_real_robot_is_confirmed_on_the_panel_too() -> None:
    async def story() -> None:
        desk = Desk()
        prepared = confirming(trace(), "The robot will move")
        async with operator(prepared, size=SMALL, console=desk.console()) as me:
            await desk.press(me, "S1")
            assert isinstance(me.app.screen, Confirm)
            await desk.press(me, "MARKER_LEFT")
            me.until(lambda: "FrontClampedRearRelaxed" in me.states)

    played(story)


def test_words_are_said_where_no_detector_speaks() -> None:
    async def story() -> None:
        desk = Desk()
        async with operator(trace(), size=SMALL, console=desk.console()) as me:
            await desk.press(me, "R2")
            me.until(lambda: any("in" in each.split() for each in me.told()))

            me.session.prepared = replace(me.session.prepared, detecting=Detecting("odometry"))
            await desk.press(me, "R2")
            assert desk.notices == ["in: the detector speaks for itself (odometry)"]

    played(story)


def test_a_question_before_the_second_press_and_a_loss_are_reported() -> None:
    async def story() -> None:
        desk = Desk()
        async with operator(trace(), size=SMALL, console=desk.console()) as me:
            desk.waiting = [
                Press("SET+R8", PANEL.buttons["SET+R8"], asks=True),
                Connection("lost", "the panel is disconnected: unplugged"),
                Connection("back", "the panel is back"),
            ]
            me.app.heed_panel()
            await me.look()
            assert "Reset: press SET+R8 again within 3 s" in desk.notices
            assert "the panel is disconnected: unplugged" in desk.notices
            assert "the panel is back" in desk.notices
            assert not me.latest.over

    played(story)


def test_the_stop_of_the_panel_reaches_the_robot_while_the_console_is_busy(midi: Any) -> None:
    async def story() -> None:
        sessions: list[OperatorSession] = []
        asked = Event()

        def stop(reason: str) -> None:
            sessions[0].stop()
            asked.set()

        reader = PanelReader(PANEL, midi.path, stop)

        def console(session: OperatorSession, **how: Any) -> Console:
            sessions.append(session)
            return Console(session, reader, **how)

        with reader:
            async with operator(trace(), size=SMALL, console=console) as me:
                for command in ("ClampFront", "ClampRear", "DriveForward"):
                    await me.command(command)
                assert not me.wheels_stand()

                midi.press(PANEL.controls["STOP"])
                # The console's own loop does not run here: nothing is awaited.
                assert asked.wait(WALL_S)
                me.until(me.wheels_stand)

    played(story)


def test_what_is_pressed_on_the_page_does_what_the_keys_do_and_says_where_it_was_pressed() -> None:
    async def story() -> None:
        desk, buttons, given = Desk(), page_buttons([]), list[Any]()
        mission = with_mission("mitre_bend", backend="trace")
        async with operator(mission, size=SMALL, console=desk.console()) as me:
            give = me.session.give_event

            def note(event: Any) -> None:
                given.append(event)
                give(event)

            me.session.give_event = note  # type: ignore[method-assign]
            for button in ("continue", "pause"):
                desk.waiting = [Press("page", buttons[button], by="page")]
                me.app.heed_panel()
                await me.look()
                me.wait(0.1)
                await me.look()
            assert [type(each) for each in given] == [GoTo, Pause]
            assert [each.by for each in given] == ["page", "page"]
            assert me.latest.state is not None
            assert me.latest.state.mission.paused

    played(story)


def test_lines_of_the_page_are_breakpoints_and_runs_to_them() -> None:
    async def story() -> None:
        desk = Desk()
        prepared = with_mission("mitre_bend", backend="trace", check=False)
        lines = prepared.loaded.documents[0].lines
        rear = 1 + next(n for n, each in enumerate(lines) if "ClampRear" in each)
        async with operator(prepared, console=desk.console()) as me:
            await me.look()

            async def press(do: Any, line: str) -> None:
                desk.waiting.append(LinePress(do, line, "page"))
                me.app.heed_panel()
                await me.look()
                me.wait(0.1)

            await press("break", f"mitre_bend.yaml:{rear}")
            assert me.latest.state is not None
            (place,) = me.latest.state.mission.breakpoints
            assert f":{rear}:" in place
            await press("break", "mitre_bend.yaml:1")
            await press("break", "other.yaml:3")
            assert [each.split(": ")[0] for each in desk.notices] == [
                "breakpoint at mitre_bend.yaml:1",
                "breakpoint at other.yaml:3",
            ]
            await press("break", f"mitre_bend.yaml:{rear}")
            assert me.latest.state.mission.breakpoints == ()

            await press("until", f"mitre_bend.yaml:{rear}")
            me.until(lambda: any("pauses before" in each for each in me.told()))
            me.until(lambda: me.latest.state and me.latest.state.mission.paused)
            assert me.wheels_stand()

    played(story)
