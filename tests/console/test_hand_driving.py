"""Driving by hand: as long as a key is held, as fast and as far as chosen."""

from __future__ import annotations

from math import inf, isnan, nan
from types import SimpleNamespace

import pytest
from representative import thorough_but
from textual.events import AppBlur
from textual.widgets import Static

from pirate_sm.core.engine import EngineState
from pirate_sm.running.wiring import Order
from pirate_sm.views.console import availability
from pirate_sm.views.console.dialogs import Confirm
from pirate_sm.views.console.driving import (
    FIRST_REPEAT_S,
    JOINT_CLEARANCE_M,
    LIMITS_M,
    NEXT_REPEAT_S,
    HandDriving,
    SaidPlace,
    came_m,
    joint_ahead_m,
    on_stops,
)
from pirate_sm.views.showing.snapshot import Snapshot

from .driving import Operator, by_hand, confirming, operator, played
from .test_looks import text_of


async def clamped(me: Operator) -> None:
    for command in ("ClampFront", "ClampRear"):
        await me.command(command)


def state(me: Operator) -> EngineState:
    assert me.latest.state is not None
    return me.latest.state


def test_a_robot_drives_for_as_long_as_the_key_is_held() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand"))) as me:
            await clamped(me)
            for _ in range(20):  # repeats every 0.2 s of its time
                await me.press("up")
                me.wait(0.1)
            assert not me.wheels_stand()
            me.wait(NEXT_REPEAT_S + 0.3)
            assert me.wheels_stand()
            me.until(lambda: state(me).robot.motion is None)
            assert "Fixed" in me.states

    played(story)


def test_a_key_that_is_pressed_once_drives_no_longer_than_until_its_first_repeat() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            await clamped(me)
            await me.press("down")
            assert not me.wheels_stand()
            me.wait(FIRST_REPEAT_S)
            me.wait(0.2)
            assert me.wheels_stand()

    played(story)


def test_a_drive_whose_repeats_are_lost_brakes_and_the_next_repeat_drives_again() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            await clamped(me)
            await me.press("up")
            me.wait(FIRST_REPEAT_S - 0.2)
            await me.press("up")
            assert not me.wheels_stand()
            me.wait(NEXT_REPEAT_S + 0.3)  # longer than between repeats
            assert me.wheels_stand()
            me.until(lambda: state(me).robot.motion is None)
            await me.press("up")
            assert not me.wheels_stand()

    played(story)


@pytest.mark.parametrize("stop", thorough_but(["space"], ["left", "space"]))
def test_a_drive_that_was_stopped_otherwise_can_be_driven_again_by_its_key(stop: str) -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            await clamped(me)
            await me.press("up")
            await me.press(stop)
            me.wait(FIRST_REPEAT_S + 0.3)
            assert me.wheels_stand()
            await me.press("up")
            assert not me.wheels_stand()

    played(story)


def test_a_key_that_is_heard_late_does_not_drive() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            await clamped(me)
            me.app.late_after_s = -inf  # as behind a terminal that takes no output
            await me.press("up")
            me.wait(0.2)
            assert me.wheels_stand()

    played(story)


def test_no_repeat_of_a_key_begins_a_drive_that_the_key_itself_could_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            await clamped(me)
            monkeypatch.setattr(availability, "command_reason", lambda *_: "no word from the robot")
            for _ in range(3):
                await me.press("up")
                me.wait(0.1)
            assert me.wheels_stand()

    played(story)


def test_what_drives_by_a_held_key_brakes_when_the_terminal_loses_the_focus() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            await clamped(me)
            await me.press("up")
            assert not me.wheels_stand()
            me.app.post_message(AppBlur())
            await me.pilot.pause()
            me.wait(0.2)
            assert me.wheels_stand()

    played(story)


def test_a_drive_has_the_speed_that_is_chosen_and_shown() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand"))) as me:
            await clamped(me)
            await me.press("minus")
            await me.press("minus")
            await me.look()
            assert "↑↓ drive 60% (+ -), no limit (=)" in text_of(me)
            await me.press(me.app.letters["DriveForward"])
            me.wait(0.5)
            robot = me.latest.scene.robot
            duties = [abs(me.values[slot]) for slot in robot.safe_zero]
            assert duties == pytest.approx([0.6] * len(duties))
            held = [v for slot, v in enumerate(me.values) if v and slot not in robot.safe_zero]
            assert max(map(abs, held)) > 0.6  # clamps keep what they had

    played(story)


def test_a_drive_stops_at_its_limit_and_a_key_that_is_still_held_does_not_begin_another() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand"))) as me:
            await clamped(me)
            while me.session.driving.limit_m != 0.1:
                await me.press("equals_sign")
            began_m = me.latest.odometry_m
            for _ in range(30):
                await me.press("up")
                me.wait(0.1)
            assert me.wheels_stand()
            assert me.latest.odometry_m - began_m == pytest.approx(0.1, abs=0.02)
            assert "log the drive stops: it has come 10" in "\n".join(me.told())
            assert not me.latest.story.alarms, "the operator has chosen it"

            me.wait(FIRST_REPEAT_S + 0.1)  # released
            await me.press("up")
            assert not me.wheels_stand()

    played(story)


def test_a_drive_that_is_to_stop_before_the_joint_does_not_begin_where_its_place_is_unknown() -> (
    None
):
    async def story() -> None:
        async with operator(by_hand(Order("by_hand"))) as me:
            await clamped(me)
            while not isnan(me.session.driving.limit_m):
                await me.press("equals_sign")
            for key in ("up", "down", me.app.letters["DriveForward"]):
                me.app._drove_s = -inf
                await me.press(key)
                me.wait(0.2)
                assert me.wheels_stand()

    played(story)


def test_the_answer_that_a_real_robot_may_move_begins_no_drive() -> None:
    async def story() -> None:
        prepared = confirming(by_hand(Order("by_hand", backend="trace")), "it may move")
        async with operator(prepared) as me:
            await me.press("up")  # it cannot drive: nothing is asked
            assert not isinstance(me.app.screen, Confirm)
            await me.press(me.app.letters["ClampFront"])
            await me.press("y")
            await clamped(me)
            me.app._agreed = False
            await me.press("up")
            await me.press("y")
            me.wait(1.0)
            assert me.wheels_stand()

    played(story)


def test_a_drive_that_a_fault_makes_doubtful_is_asked_about_and_no_arrow_begins_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def doubt(snapshot: Snapshot, name: str) -> str:
        return "wheel.dead: it does not turn" if name.startswith("Drive") else ""

    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            monkeypatch.setattr(availability, "drive_doubt", doubt)
            await clamped(me)  # what does not drive is not asked about
            letter = me.app.letters["DriveForward"]
            await me.press("up")
            me.wait(0.2)
            assert me.wheels_stand()
            assert not isinstance(me.app.screen, Confirm)
            refused = [each.message for each in me.app._notifications]
            assert (
                f"DriveForward: wheel.dead: it does not turn ({letter} asks and drives)" in refused
            )

            await me.press(letter)
            assert isinstance(me.app.screen, Confirm)
            asked = str(me.app.screen.query_one(".question", Static).content)
            assert asked == "wheel.dead: it does not turn. Give DriveForward anyway?"
            await me.press("n")
            me.wait(0.2)
            assert me.wheels_stand()
            await me.press(letter)
            await me.press("y")
            me.wait(0.2)
            assert not me.wheels_stand()

    played(story)


def test_limits_come_round() -> None:
    driving = HandDriving(lambda: pytest.fail("no snapshot is needed"))
    for _ in LIMITS_M:
        driving.other_limit()
    assert driving.limit_m == inf
    driving.faster(-9)
    assert driving.speed == 0.2


def test_a_drive_stops_before_the_joint_of_the_pipe_which_is_a_warning_before() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand"))) as me:
            await clamped(me)
            driving, route = me.session.driving, me.latest.scene.route
            assert route is not None
            begins_m = route.joints[0].arc_m - route.joints[0].before_m
            driving.place = SaidPlace(begins_m - 0.2, came_m(me.latest))
            driving.limit_m = nan
            assert joint_ahead_m(me.latest, driving.place) == pytest.approx(0.2)
            await me.press(me.app.letters["DriveForward"])
            me.until(me.wheels_stand, 10)

            ahead_m = joint_ahead_m(me.latest, driving.place)
            assert 0.03 < ahead_m <= JOINT_CLEARANCE_M
            told = "\n".join(me.told())
            assert told.count("a joint of the pipe is ") == 1
            assert told.count("warning the drive stops: the joint is ") == 1

    played(story)


def test_a_joint_of_the_robot_on_its_end_stop_is_found() -> None:
    joints = [SimpleNamespace(name=name, value=name, limit=2.0) for name in ("low", "high", "dark")]
    scene = SimpleNamespace(anatomy=SimpleNamespace(joints=joints))
    signals = {"low": 1.9, "high": -1.97, "dark": nan}

    snapshot = SimpleNamespace(scene=scene, signals=signals)
    found = list(on_stops(snapshot))  # type: ignore[arg-type]
    assert found == [("high", "-113°")]
    found = list(on_stops(snapshot, {"low"}))  # type: ignore[arg-type]
    assert found == [("low", "109°"), ("high", "-113°")], "the noise of a sensor is no way off it"


def test_a_joint_of_the_pipe_that_is_passed_is_not_ahead() -> None:
    reported = SimpleNamespace(reported=SimpleNamespace(distance_m=-0.007))
    scene = SimpleNamespace(route=None)
    snapshot = SimpleNamespace(state=SimpleNamespace(surveyed=reported), scene=scene)
    assert isnan(joint_ahead_m(snapshot, SaidPlace()))  # type: ignore[arg-type]
