"""What is on the screen, at every size; the pictures are those of the documents."""

from __future__ import annotations

import os
import re
from pathlib import Path
from string import ascii_lowercase

import pytest

from pirate_sm.core.effects import CommandStatus
from pirate_sm.core.events import OperatorCommand
from pirate_sm.running.wiring import Order
from pirate_sm.views.console import availability
from pirate_sm.views.console.availability import RESERVED, letters_for
from pirate_sm.views.showing.body_panel import sparkline
from pirate_sm.views.showing.picture import draw

from .driving import ROOT, Operator, by_hand, operator, played, with_mission

PICTURES = ROOT / "docs" / "pictures"
_FONT_FACE = re.compile(r"\s*@font-face \{.*?\}", re.DOTALL)


def picture_of(me: Operator) -> str:
    """The screen as an SVG that needs nothing from elsewhere."""
    return _FONT_FACE.sub("", me.app.export_screenshot()).replace("Fira Code", "monospace")


def text_of(me: Operator) -> str:
    return "\n".join(
        "".join(segment.text for segment in line)
        for line in me.app.screen._compositor.render_strips()
    )


@pytest.mark.parametrize(
    "size",
    [
        (160, 48),
        pytest.param((120, 36), marks=pytest.mark.thorough),
        (80, 24),
    ],
    ids=lambda size: f"{size[0]}x{size[1]}",
)
def test_the_screen_is_as_in_the_documents(size: tuple[int, int]) -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend"), size=size) as me:
            await me.look()
            await me.press("R")
            me.until(lambda: me.latest.story.phase.phase.startswith("prepare"))
            me.wait(4.0)
            await me.look()
            found, file = picture_of(me), PICTURES / f"console_{size[0]}x{size[1]}.svg"
            if os.environ.get("GOLDEN") == "write":
                file.write_text(found, encoding="utf-8")

            assert file.exists(), "there is no picture yet: make golden"
            assert found == file.read_text("utf-8")

    played(story)


@pytest.mark.parametrize(
    "size",
    [(120, 36), pytest.param((160, 48), marks=pytest.mark.thorough)],
    ids=lambda size: f"{size[0]}x{size[1]}",
)
def test_from_this_size_on_everything_is_visible_at_once(size: tuple[int, int]) -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend"), size=size) as me:
            await me.look()
            await me.press("space")  # a banner takes a line
            me.wait(1.0)
            await me.look()
            text, scene = text_of(me), me.latest.scene
            motors = [motor.name for motor in scene.anatomy.motors]
            readings = [reading.label for reading in scene.anatomy.readings]
            commands = list(scene.loaded.loaded_robot.profile.commands)
            assert "STOPPED" in text
            for name in (*motors, *readings, *commands, "Mission control", "heat", "trend", "Log"):
                assert name in text, name

    played(story)


def test_what_is_greyed_is_what_the_engine_refuses_and_with_its_words() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            for leading in ("", "ClampFront", "DriveForward", "ClampRear"):
                if leading:
                    await me.command(leading)
                snapshot = me.latest
                for name in me.app._rows:
                    _, effects = snapshot.scene.engine.step(
                        snapshot.state, OperatorCommand(name), snapshot.now_s
                    )
                    refused = [
                        each.reason
                        for each in effects
                        if isinstance(each, CommandStatus) and each.status == "refused"
                    ]
                    shown = availability.command_reason(snapshot, name)
                    words = "".join(refused).partition(": ")
                    assert shown.startswith(words[0])
                    assert words[2] in shown
                    assert bool(shown) == bool(refused)

    played(story)


def test_a_key_that_is_greyed_says_why_and_asks_for_nothing() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            reason = availability.command_reason(me.latest, "DriveForward")
            await me.press(me.app.letters["DriveForward"])
            await me.look()

            shown = [each.message for each in me.app._notifications]
            assert reason.startswith("impossible: ClampFront or ClampRear first (it needs ")
            assert shown == [f"DriveForward: {reason}"]
            assert not any("DriveForward" in each for each in me.told())

    played(story)


@pytest.mark.thorough
def test_every_page_is_reached_where_there_is_not_room_for_all() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace")), size=(80, 24)) as me:
            seen = []
            for _ in range(4):
                await me.look()
                seen.append(text_of(me))
                await me.pilot.press("tab")
            drive, mission, body, log = seen
            assert "ClampFront" in drive
            assert "FrontWheels" in drive
            assert "Mission control" in mission
            assert "gamma_1" in body
            assert "paused: wheels stopped" in log
            assert all("BY HAND" in each and "STOP" in each for each in seen)

    played(story)


@pytest.mark.thorough
def test_it_takes_the_room_that_it_is_given() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            await me.look()
            assert "gamma_1" in text_of(me)
            await me.pilot.resize_terminal(80, 24)
            await me.look()
            assert "gamma_1" not in text_of(me)
            await me.pilot.resize_terminal(40, 12)
            await me.look()
            await me.pilot.resize_terminal(200, 60)
            await me.look()
            assert "gamma_1" in text_of(me)
            assert "ClampFront" in text_of(me)

    played(story)


@pytest.mark.thorough
@pytest.mark.parametrize("theme", ["light", "contrast"])
def test_themes_are_reached_by_a_key_and_the_help_page_is_there(theme: str) -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace"))) as me:
            while me.app.theme != theme:
                await me.pilot.press("ctrl+t")
            await me.pilot.press("question_mark")
            await me.look()
            text = text_of(me)
            assert "STOP: wheels stop, clamps hold" in text

    played(story)


@pytest.mark.thorough
def test_the_last_line_shows_the_keys_of_a_dialog_while_it_is_open() -> None:
    async def story() -> None:
        async with operator(by_hand(Order("by_hand", backend="trace")), size=(80, 24)) as me:
            await me.command("ClampFront")
            opened = {"m": "esc Cancel", "question_mark": "esc Close"}
            opened[me.app.letters["Reset"]] = "y Yes n No"
            for key, shown in opened.items():
                await me.press(key)
                await me.look()
                last = text_of(me).splitlines()[-1]
                assert len(me.app.screen_stack) == 2
                assert "space STOP" in last
                assert shown in last
                assert "Quit" not in last

                await me.press("Q")  # closes what is open, and nothing else
                await me.look()
                assert len(me.app.screen_stack) == 1
                assert "q Quit" in text_of(me).splitlines()[-1]
            assert me.session.quitting.stop is None
            assert me.states[2] == "FrontClampedRearRelaxed"

    played(story)


def test_a_robot_of_four_wheels_has_its_own_keys_and_is_drawn(tmp_path: Path) -> None:
    newt = ROOT / "tests" / "robots" / "newt"

    async def story() -> None:
        prepared = with_mission(str(newt / "patrol.yaml"))
        async with operator(prepared) as me:
            await me.look()
            text = text_of(me)
            assert all(name in text for name in prepared.loaded.loaded_robot.profile.commands)
            drawn = "\n".join(row.plain for row in draw(me.latest, 60, 20).rows())
            assert "4" in drawn
            assert "5" not in drawn

    played(story)


def test_letters_come_from_the_names() -> None:
    found = letters_for(["OpenGate", "OpenDoor", "quit", "Go"])

    assert found == {"OpenGate": "o", "OpenDoor": "d", "quit": "u", "Go": "g"}
    many = letters_for([f"n{number}" for number in range(40)])
    assert set(many.values()) == (set(ascii_lowercase) - RESERVED) | set(",;'[]")


def test_a_trend_is_as_high_as_its_share() -> None:
    assert sparkline([0.0, 0.5, 1.0], 1.0) == "▁▄█"
    assert sparkline([0.0, 0.0], 0.0) == "▁▁"
