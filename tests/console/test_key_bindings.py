"""Keys that do what a hand expects: either case, arrows, and a banner that stays."""

from __future__ import annotations

from math import inf
from pathlib import Path

import pytest
from textual.widgets import Static

from pirate_sm.core.events import OperatorCommand
from pirate_sm.core.loading import load_robot
from pirate_sm.running.wiring import Order
from pirate_sm.views.console.app import Console
from pirate_sm.views.console.availability import (
    ANSWERS,
    CONTROLS,
    LEAVE,
    RESERVED,
    arrows_for,
    letters_for,
)
from pirate_sm.views.console.dialogs import Confirm
from pirate_sm.views.showing import panels
from pirate_sm.views.showing.alarms import shows_success

from .driving import ROOT, by_hand, confirming, operator, played, with_mission
from .test_looks import text_of


@pytest.mark.parametrize("upper", [False, True])
def test_caps_lock_changes_nothing(upper: bool) -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            letter = me.app.letters["ClampFront"]
            await me.press(letter.upper() if upper else letter)
            me.until(lambda: me.states[2] == "FrontClampedRearRelaxed")
            assert me.latest.scene.mission == ""

    played(story)


def test_arrows_drive_and_brake() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            for command in ("ClampFront", "ClampRear"):
                await me.command(command)
            robot = me.latest.scene.robot
            for key, way in (("up", 1), ("left", 0), ("down", -1), ("right", 0)):
                await me.press(key)
                me.until(lambda way=way: robot.travel(me.values) == way)
                me.until(lambda: me.latest.state.robot.motion is None)

    played(story)


def test_it_is_said_that_the_robot_drives_while_no_command_is_under_way() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            assert "nothing is under way" in _now(me)
            for command in ("ClampFront", "ClampRear", "DriveForward"):
                await me.command(command)
            assert "driving forward" in _now(me)
            await me.command("DriveBackward")
            assert "driving backward" in _now(me)

    played(story)


def _now(me) -> str:  # type: ignore[no-untyped-def]
    return "\n".join(line.plain for line in panels.now(me.latest, 60))


def test_a_banner_says_that_the_robot_was_stopped_until_it_has_been_seen() -> None:
    async def story() -> None:
        async with operator(with_mission("enter_2d"), size=(80, 24)) as me:
            await me.press("space")
            me.wait(1.0)
            await me.look()
            assert "STOPPED: stopped by the operator" in text_of(me)
            me.wait(30.0)
            await me.look()
            assert "STOPPED" in text_of(me)
            await me.press("escape")
            await me.look()
            assert "STOPPED: stopped by the operator" not in text_of(me)
            assert "■ STOPPED, PAUSED" in text_of(me)  # until something is asked for

    played(story)


def test_a_banner_says_how_a_mission_ended() -> None:
    async def story() -> None:
        async with operator(with_mission("enter_2d"), size=(80, 24)) as me:
            await me.look()
            await me.press("R")
            me.until(lambda: me.latest.story.banner is not None)
            await me.look()
            assert "SUCCEEDED" in text_of(me)
            assert shows_success(me.latest, ())

    played(story)


def test_a_start_that_the_check_still_looks_at_is_remembered() -> None:
    async def story() -> None:
        async with operator(with_mission("enter_2d", check=True)) as me:
            me.wait(1.0)
            await me.look()
            me.app._entries = None  # as long as the check has not looked
            await me.press("r")
            assert me.latest.state.mission.paused
            me.app._situation = None  # it looks now
            await me.look()
            me.wait(0.5)
            assert not me.latest.state.mission.paused

    played(story)


def test_a_reason_that_all_commands_share_is_said_once_and_how_far_it_drove_is_shown() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace")), size=(80, 24)) as me:
            await me.press(me.app.letters["ClampFront"])
            me.wait(0.5)
            await me.look()
            assert text_of(me).count("another command is under way") == 1
            assert "odometry" in text_of(me)
            assert "speed" in text_of(me)

    played(story)


def test_what_the_robot_has_come_is_not_forgotten_after_a_stop() -> None:
    async def story() -> None:
        async with operator(with_mission("enter_2d"), size=(80, 24)) as me:
            await me.look()
            await me.press("r")
            me.until(lambda: me.latest.odometry_m > 0.05)
            await me.press("space")
            me.until(lambda: me.latest.before_m > 0.05)
            me.wait(1.0)
            await me.look()
            assert f"odometry {me.latest.before_m:.2f}+0.0" in text_of(me)

    played(story)


ROBOTS = [*sorted((ROOT / "hardware_profiles").glob("*/profile.yaml"))]
ROBOTS += [*sorted((ROOT / "tests" / "robots").glob("*/profile.yaml"))]


@pytest.mark.parametrize("profile", ROBOTS, ids=[each.parent.name for each in ROBOTS])
def test_no_key_that_moves_the_robot_or_is_a_word_answers_a_question(profile: Path) -> None:
    robot = load_robot(profile.parent).normal
    names = [*(command.name for command in robot.commands), *robot.detector_words]
    letters = letters_for(names)

    assert list(letters) == names
    moving = [*letters.values(), *arrows_for(robot), *CONTROLS.values()]
    assert not ANSWERS & set(moving)
    assert len(moving) == len(set(moving))
    assert not RESERVED & set(letters.values())


def test_each_key_of_the_console_has_one_meaning() -> None:
    keys = [key for binding in Console.BINDINGS for key in binding.key.split(",")]

    assert len(keys) == len(set(keys))
    assert LEAVE in keys


def test_a_dialog_ignores_keys_that_were_pressed_before_it_could_be_read() -> None:
    async def story() -> None:
        prepared = confirming(by_hand(Order("by_hand", backend="trace")), "The robot may move")
        async with operator(prepared, size=(80, 24)) as me:
            me.app.read_after_s = inf
            await me.press(me.app.letters["ClampFront"])
            for key in ("y", "enter", "escape", "q"):
                await me.press(key)
                assert isinstance(me.app.screen, Confirm), key
            assert me.session.quitting.stop is None

            me.app.read_after_s = 0.0
            await me.press("y")
            me.until(lambda: me.states[2] == "FrontClampedRearRelaxed")

    played(story)


def test_the_stop_key_stops_in_a_dialog_that_nobody_has_read() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace")), size=(80, 24)) as me:
            for command in ("ClampFront", "ClampRear", "DriveForward"):
                await me.command(command)
            me.app.read_after_s = inf
            await me.press("question_mark")
            await me.press("space")
            me.wait(0.5)
            assert me.wheels_stand()

    played(story)


@pytest.mark.thorough
def test_the_help_page_says_what_cannot_be_done_now_and_not_what_could_not_when_it_opened() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace")), size=(80, 90)) as me:
            await me.press("question_mark")
            await me.look()

            def page() -> str:
                return " ".join(str(me.app.screen.query_one(Static).content).split())

            commands = me.latest.scene.loaded.loaded_robot.profile.commands
            about = " ".join(f"ClampFront {commands['ClampFront'].description}".split())
            refused = f"{about}. Not now: unneeded: it is so already"
            assert about in page()
            assert refused not in page()
            me.session.give_event(OperatorCommand("ClampFront"))  # as from a panel
            me.until(lambda: me.states[2] == "FrontClampedRearRelaxed")
            me.until(lambda: me.latest.state.robot.motion is None)
            await me.look()
            assert refused in page()

    played(story)


@pytest.mark.thorough
def test_a_step_and_a_word_have_signs_where_there_are_no_letters() -> None:
    async def story() -> None:
        prepared = with_mission("mitre_bend", "trace", robot="pirate_ii_imu")
        async with operator(prepared, size=(80, 24)) as me:
            await me.look()
            await me.press("full_stop")
            me.until(lambda: not me.latest.state.mission.paused or me.latest.state.robot.motion)
            words = me.latest.scene.robot.detector_words
            assert any(not me.app.letters[word].isalpha() for word in words)

    played(story)
