"""A person types where the robot is and what is seen there."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from math import nan
from pathlib import Path

import pytest
from textual.events import Key

from pirate_sm.cli.run_recording import RecordingOptions, recorded
from pirate_sm.core.events import Observation, OperatorCommand
from pirate_sm.lab.mapping.mapper import mapped
from pirate_sm.lab.mapping.pipe_text import pipe_text
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.wiring import Order
from pirate_sm.views.console.dialogs import ObservationDialog
from pirate_sm.views.console.driving import place_m
from pirate_sm.views.console.terminal_driver import StopDriver
from pirate_sm.views.report.timeline import operator_action

from .driving import Operator, by_hand, operator, played, with_mission
from .test_looks import text_of

KEYS = {" ": "space", ".": "full_stop", ",": "comma", "'": "apostrophe"}


async def typed(me: Operator, place: str, seen: str) -> None:
    await me.press("at")
    assert isinstance(me.app.screen, ObservationDialog)
    await me.pilot.press(*(KEYS.get(each, each) for each in place), "tab")
    await me.pilot.press(*(KEYS.get(each, each) for each in seen), "enter")
    await me.look()
    me.wait(0.2)


@pytest.mark.thorough
def test_what_a_person_sees_is_in_the_recording_and_in_the_map(tmp_path: Path) -> None:
    path = tmp_path / "seen.mcap"

    async def story() -> None:
        def keep(prepared):  # type: ignore[no-untyped-def]
            if path.exists():
                return nullcontext()
            return recorded(prepared, RecordingOptions(str(path)), 1.0)

        async with operator(with_mission("enter_2d"), keep=keep) as me:
            for command in ("ClampFront", "ClampRear"):
                await me.command(command)
            await typed(me, "70 cm", "crack, 3 o'clock")
            assert not me.latest.story.ended  # the space bar has typed a space
            me.until(lambda: any("seen at 0.70 m: crack, 3 o'clock" in each for each in me.told()))
            await me.look()
            assert "wheel 1 at 0.70 m" in text_of(me)

            came_m = me.latest.odometry_m
            await me.press(me.app.letters["DriveForward"])
            me.wait(1.5)
            await me.press("left")
            me.until(lambda: me.latest.state.robot.motion is None)
            driven_m = me.latest.odometry_m - came_m
            assert driven_m > 0.02
            assert place_m(me.latest, me.session.driving.place) == pytest.approx(0.7 + driven_m)

    played(story)

    recording = read_recording(path)
    said = [step.event for step in recording.steps() if isinstance(step.event, Observation)]
    assert said == [Observation("crack, 3 o'clock", pytest.approx(0.7))]
    text = pipe_text(mapped(recording), "seen", path.name)
    assert "# A person says: seen at 0.70 m: crack, 3 o'clock." in text


def test_a_place_said_before_the_start_is_known_in_the_console() -> None:
    async def story() -> None:
        prepared = with_mission("enter_2d")
        placed = replace(prepared, order=replace(prepared.order, start_at_m=0.4))
        async with operator(placed) as me:
            await me.look()
            assert "wheel 1 at 0.40 m" in text_of(me)

    played(story)


def test_a_place_cannot_be_typed_while_anything_moves() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace")), size=(80, 24)) as me:
            await me.press(me.app.letters["ClampFront"])
            await me.press("at")
            assert not isinstance(me.app.screen, ObservationDialog)

            me.until(lambda: me.latest.state.robot.motion is None)
            await me.press("at")
            assert isinstance(me.app.screen, ObservationDialog)
            me.session.give_event(OperatorCommand("ClampRear"))  # as somebody at a panel would
            me.wait(0.1)
            await me.look()
            assert not isinstance(me.app.screen, ObservationDialog)
            StopDriver(me.app).process_message(Key("space", " "))
            assert me.session.quitting.run.stop is not None

    played(story)


@pytest.mark.thorough
def test_what_is_no_place_is_asked_for_again() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace")), size=(80, 24)) as me:
            await typed(me, "over there", "")
            assert isinstance(me.app.screen, ObservationDialog)
            assert any("over there" in each.message for each in me.app._notifications)
            await me.press("escape")
            assert not isinstance(me.app.screen, ObservationDialog)

    played(story)


@pytest.mark.parametrize(
    ("said", "words"),
    [
        (Observation("", 0.7), "says: wheel 1 is at 0.70 m"),
        (Observation("root", nan), "says: seen at an unknown place: root"),
    ],
)
def test_the_report_says_what_a_person_has_said(said: Observation, words: str) -> None:
    assert operator_action(said) == words
