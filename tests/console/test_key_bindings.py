"""Keys that do what a hand expects: either case, arrows, and a banner that stays."""

from __future__ import annotations

import pytest

from pirate_sm.showing import panels
from pirate_sm.wiring import Order

from .driving import by_hand, operator, played, with_mission
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
            assert "STOPPED" not in text_of(me)

    played(story)


def test_a_banner_says_how_a_mission_ended() -> None:
    async def story() -> None:
        async with operator(with_mission("enter_2d"), size=(80, 24)) as me:
            await me.look()
            await me.press("R")
            me.until(lambda: me.latest.story.banner is not None)
            await me.look()
            assert "SUCCEEDED" in text_of(me)
            assert panels.shows_success(me.latest, 0)

    played(story)


def test_a_start_that_the_check_still_looks_at_is_remembered() -> None:
    async def story() -> None:
        async with operator(with_mission("enter_2d")) as me:
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
