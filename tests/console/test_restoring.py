"""Handing back where the robot does not stand as the phase needs it: commands are offered."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import replace
from functools import partial
from threading import Event
from typing import Any

import pytest
from representative import thorough_but
from textual.widgets import OptionList, Static

from pirate_sm.core import effects as fx
from pirate_sm.core.events import GoTo, OperatorCommand
from pirate_sm.core.robot import at_rest_in
from pirate_sm.views.console import hand_back
from pirate_sm.views.console.app import Console
from pirate_sm.views.console.availability import UNHEARD, look_at_entries
from pirate_sm.views.console.dialogs import Confirm, Pick
from pirate_sm.views.console.driving import BY_OPERATOR, Giver
from pirate_sm.views.console.session import OperatorSession
from pirate_sm.views.showing.snapshot import scene_of

from .driving import WALL_S, Operator, ask_once, confirming, operator, played, with_mission
from .test_looks import PICTURES, picture_of, text_of


async def paused_and_braked(me: Operator) -> None:
    """The mission has driven in; then the operator takes over and brakes."""
    await me.look()
    await me.press("R")
    me.until(lambda: me.states[0] == "DrivingForward" and me.waits)
    await me.press("P")
    me.until(lambda: me.latest.state.mission.paused)
    me.wait(0.5)
    await me.command("Brake")


async def listed(me: Operator) -> dict[str, str]:
    """Every line of the list of phases; those that cannot be chosen begin with a cross."""
    await me.look()
    await me.press("H")
    for _ in range(3):
        await me.look()
    return lines_of(me)


def lines_of(me: Operator) -> dict[str, str]:
    options = me.app.screen.query_one(OptionList).options
    return {str(each.id): " ".join(str(each.prompt).split()) for each in options}


async def pick(me: Operator, phase: str) -> None:
    """The line of the phase is chosen."""
    options = [each.id for each in me.app.screen.query_one(OptionList).options]
    me.app.screen.query_one(OptionList).highlighted = options.index(phase)
    await me.press("enter")
    await me.look()


async def choose(me: Operator, phase: str) -> None:
    """The phase is chosen; the question is open."""
    await pick(me, phase)
    assert isinstance(me.app.screen, Confirm)


@asynccontextmanager
async def choosing(phase: str, **options: Any) -> AsyncIterator[Operator]:
    """Someone has paused the mission and braked, and chosen a phase; the question is open."""
    async with operator(with_mission("mitre_bend", backend="trace"), **options) as me:
        await paused_and_braked(me)
        await listed(me)
        await choose(me, phase)
        yield me


def asked(me: Operator) -> str:
    """What the open question says."""
    return str(me.app.screen.query_one(".question", Static).content)


def sent(me: Operator) -> list[str]:
    return [each for each in me.told() if each.startswith("command") and "sent" in each]


@pytest.mark.thorough
def test_the_list_says_which_commands_restore_a_phase_and_which_would_let_go() -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace")) as me:
            await paused_and_braked(me)
            lines = await listed(me)

            assert "first DriveForward" in lines["prepare"]
            assert "first RelaxFront, BendInto, DriveForward" in lines["pass"]
            assert lines["enter"].startswith("✕")
            assert "only Reset leads there: it lets go of front and rear" in lines["enter"]

    played(story)


@pytest.mark.thorough
def test_on_one_key_they_are_given_one_by_one_and_the_mission_goes_on() -> None:
    async def story() -> None:
        async with choosing("pass") as me:
            assert "Give RelaxFront, BendInto," in asked(me)
            assert me.latest.state.robot.motion is None  # nothing before a yes

            await me.press("y")
            await me.look()
            assert "RelaxFront …" in text_of(me)
            assert "Esc: no more" in text_of(me)
            me.until(lambda: me.latest.story.phase.phase.startswith("pass"))

            assert any("handed back at pass" in each for each in me.told())
            series = me.session.giver.series
            assert (series.done, series.handed_back, series.stopped) == (3, True, "")
            await me.look()
            assert "Esc: no more" not in text_of(me)

    played(story)


@pytest.mark.thorough
def test_nothing_is_handed_back_while_the_robot_is_not_heard(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace")) as me:
            await paused_and_braked(me)
            assert "first DriveForward" in (await listed(me))["prepare"]
            await choose(me, "prepare")
            before = sent(me)
            monkeypatch.setattr(
                OperatorSession,
                "latest",
                property(lambda it: replace(it._bridge.latest, held_s=5.0)),
            )
            await me.press("y")
            me.wait(1.0)
            assert [each.message for each in me.app._notifications] == [f"not given: {UNHEARD}"]

            me.app._choose_phase(me.latest)
            await me.look()
            assert {each.startswith("✕") for each in lines_of(me).values()} == {True}
            await pick(me, "prepare")
            assert not isinstance(me.app.screen, Confirm)
            me.wait(1.0)
            assert sent(me) == before

    played(story)


@pytest.mark.thorough
def test_a_hand_back_that_needs_no_commands_asks_where_waits_were_not_passed() -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace")) as me:
            await paused_and_braked(me)
            await me.command("RelaxFront")
            await me.command("BendInto")
            await me.command("DriveForward")
            await listed(me)
            await choose(me, "pass")
            assert "not seen the mission pass its waits of enter, prepare" in asked(me)
            assert "Give" not in asked(me)

            await me.press("enter")  # the careful answer
            me.wait(0.5)
            assert me.latest.state.mission.paused

            await listed(me)
            await choose(me, "pass")
            await me.press("y")
            me.until(lambda: me.latest.story.phase.phase.startswith("pass"))

    played(story)


@pytest.mark.thorough
def test_the_question_before_a_hand_back_is_as_in_the_documents() -> None:
    async def story() -> None:
        async with choosing("pass", size=(120, 36)) as me:
            await me.look()
            found, file = picture_of(me), PICTURES / "console_hand_back.svg"
            if os.environ.get("GOLDEN") == "write":
                file.write_text(found, encoding="utf-8")

            assert file.exists(), "there is no picture yet: make golden"
            assert found == file.read_text("utf-8")

    played(story)


@pytest.mark.thorough
@pytest.mark.parametrize("width", [80, 160])
def test_a_grey_phase_shows_its_whole_reason_and_no_path(width: int) -> None:
    async def story() -> None:
        mission = with_mission("mitre_bend", backend="trace")
        async with operator(mission, size=(width, 24)) as me:
            await paused_and_braked(me)
            lines = await listed(me)
            whole = "only Reset leads there: it lets go of front and rear"
            reason = "ClampFront (line 30) would be refused as unneeded: it is so already"
            assert reason in lines["enter"]
            assert ".yaml" not in "".join(lines.values())
            rows = [row.split("│") for row in text_of(me).splitlines() if row.count("│") > 1]
            shown = " ".join(" ".join(row[1] for row in rows).split())
            assert whole in shown
            assert reason in shown

            await pick(me, "enter")
            assert isinstance(me.app.screen, Pick)  # it is still open
            told = [each.message for each in me.app._notifications]
            assert [each for each in told if whole in each and reason in each]
            assert me.latest.state.mission.paused

    played(story)


@pytest.mark.thorough
def test_the_list_says_that_commands_are_still_being_looked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looked, look = Event(), hand_back.look_for_ways

    def waiting(*arguments: Any) -> hand_back.Ways:
        assert looked.wait(WALL_S)
        return look(*arguments)

    monkeypatch.setattr(hand_back, "look_for_ways", waiting)

    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace")) as me:
            try:
                await me.look()
                await me.press("H")
                me.app.show()
                before = lines_of(me)
                assert "✕ halt looking for commands that lead there …" in before["halt"]
                assert not before["enter"].startswith("✕")
            finally:
                looked.set()
            for _ in range(2):
                await me.look()
            after = lines_of(me)
            assert "first ToggleLighting, ClampFront" in after["halt"]
            assert after["regrip"] == "✕ regrip from there no path leads to an end that succeeds"

    played(story)


@pytest.mark.parametrize(
    "broken", thorough_but([look_at_entries], [look_at_entries, hand_back.look_for_ways])
)
def test_a_check_that_fails_costs_its_answer_and_not_the_console(
    broken: Callable[..., object],
) -> None:
    asked = []

    def ask(function: Callable[..., Any], *arguments: Any) -> Any:
        asked.append(function)
        if function is broken:
            raise RuntimeError("dictionary changed size")
        return ask_once(function, *arguments)

    async def story() -> None:
        console = partial(Console, ask_check=ask)
        async with operator(with_mission("mitre_bend", backend="trace"), console=console) as me:
            await me.look()
            found = await listed(me)
            assert found["prepare"].startswith("✕")
            assert "looking" not in found["prepare"]
            assert "an internal error" in found["prepare"]
            assert ("dictionary changed" in found["prepare"]) == (broken is look_at_entries)
            assert found["enter"].startswith("✕") == (broken is look_at_entries)
            await me.press("escape")

            await me.command("ClampFront")
            assert me.states[0] == "Fixed"
            assert len(me.app.faults) == 1  # however often it happens
            me.app.faults.clear()

            found, before = await listed(me), asked.count(broken)
            assert before > 1  # in another state of the robot it is asked again
            assert "looking" not in found["prepare"]
            me.app.faults.clear()

    played(story)


def test_a_step_of_a_called_mission_is_named_by_that_mission_and_its_line() -> None:
    mission = with_mission("mitre_bend", backend="trace")
    scene = scene_of(mission)
    body = at_rest_in(scene.robot, scene.loaded.program.start_configuration)

    found = look_at_entries(scene.loaded, body)

    assert "/" not in "".join(found.values())
    assert "Brake (line 18 of pass_bend) would be refused" in found["pass/pass_bend.pass"]


@pytest.mark.thorough
def test_the_question_begins_with_what_nobody_has_looked_at() -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace")) as me:
            await me.look()
            await listed(me)
            await choose(me, "halt")
            assert asked(me).startswith(
                "Only states are restored. Nothing checks where the robot is, and since its "
                "last start this console has not seen the mission pass its waits of enter, "
                "prepare, pass. halt needs "
            )

    played(story)


@pytest.mark.thorough
def test_a_wait_that_the_mission_has_passed_is_not_named() -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", backend="trace")) as me:
            await me.look()
            await me.press("R")
            me.until(lambda: me.latest.story.phase.phase == "enter" and me.waits)
            await me.press("K")
            me.until(lambda: me.latest.story.phase.phase == "prepare" and me.waits)
            await me.press("P")
            me.until(lambda: me.latest.state.mission.paused)
            me.wait(0.5)
            await me.command("Brake")
            lines = await listed(me)
            assert "first DriveForward" in lines["pass"]
            await choose(me, "pass")
            assert "not seen the mission pass its wait of prepare." in asked(me)

    played(story)


@pytest.mark.thorough
@pytest.mark.parametrize("key", thorough_but(["escape"], ["escape", "brake"]))
def test_the_operator_stops_them_by_any_other_wish(key: str) -> None:
    async def story() -> None:
        async with choosing("pass") as me:
            await me.press("y")
            me.until(lambda: me.session.giver.series.done == 1)
            await me.press(me.app.letters["Brake"] if key == "brake" else key)
            me.wait(4.0)
            await me.look()

            assert me.session.giver.series.stopped == BY_OPERATOR
            assert me.latest.state.mission.paused
            assert me.states[2] == "RearClampedFrontBending"  # that one was under way
            assert me.wheels_stand()
            notes = [each.message for each in me.app._notifications]
            assert any("not given: DriveForward" in each for each in notes)

    played(story)


def test_the_stop_stops_them_too() -> None:
    async def story() -> None:
        async with choosing("pass") as me:
            await me.press("y")
            me.until(lambda: me.session.giver.series.done == 1)
            await me.press("space")
            me.wait(4.0)

            assert me.session.giver.series.stopped
            assert me.latest.state.mission.paused
            assert me.wheels_stand()
            assert me.session.giver.series.done == 1

    played(story)


def test_nothing_is_given_after_a_stop_nor_in_the_run_that_follows() -> None:
    async def story() -> None:
        async with operator(with_mission("enter_2d", backend="trace")) as me:
            me.session.stop()
            me.session.give(("ClampFront",), THEN)
            assert me.session.giver.series is None
            me.session.giver.give(("ClampFront",), THEN)  # as if the stop had come between
            me.wait(3.0)
            assert me.session.giver.series.stopped
            assert me.states[2] == "Unclamped"

    played(story)


@pytest.mark.thorough
def test_a_no_gives_nothing() -> None:
    async def story() -> None:
        async with choosing("pass") as me:
            await me.press("n")
            me.wait(2.0)
            assert me.session.giver.series is None
            assert me.states[2] == "DoubleClamped"

    played(story)


@pytest.mark.thorough
def test_a_real_robot_is_asked_for_first_if_nothing_has_moved_yet() -> None:
    async def story() -> None:
        mission = confirming(with_mission("prepare_bend", backend="trace"), "It will move")
        async with operator(mission) as me:
            await me.look()
            assert me.latest.state.mission.paused
            me.session.give_event(
                OperatorCommand("Brake")
            )  # as nobody at the console has asked for it
            me.wait(2.0)
            await listed(me)
            await choose(me, "bend")
            await me.press("y")
            await me.look()
            assert "It will move. Is it free to?" in text_of(me)
            await me.press("n")
            me.wait(2.0)
            assert me.session.giver.series is None
            assert me.wheels_stand()

    played(story)


THEN = GoTo("there", ("A",))


class Watched:
    """A giver as the loop would have it, in a robot that is free or not."""

    def __init__(self) -> None:
        self.giver = Giver()
        self.giver.give(("One", "Two"), THEN)

    def asked(self, *, busy: bool = False) -> tuple[object, ...]:
        self.giver._busy = busy
        return tuple(self.giver.speak(0.0))

    def hears(self, *effects: fx.Effect) -> None:
        self.giver.react(effects, 0.0)


def test_a_command_follows_when_the_one_before_is_done() -> None:
    me = Watched()

    assert me.asked(busy=True) == ()
    assert me.asked() == (OperatorCommand("One"),)
    assert me.asked() == ()
    me.hears(fx.CommandStatus("One", "sent"), fx.CommandStatus("One", "accepted"))
    assert me.asked() == ()
    me.hears(fx.CommandStatus("One", "done"))
    assert me.asked() == (OperatorCommand("Two"),)
    me.hears(fx.CommandStatus("Two", "done"))
    assert me.asked(busy=True) == ()
    assert me.asked() == (THEN,)
    assert me.asked() == ()


@pytest.mark.parametrize(
    ("effect", "why"),
    [
        (fx.CommandStatus("One", "failed", "timed out"), "One failed: timed out"),
        (fx.CommandStatus("One", "refused", "impossible: so"), "One refused: impossible: so"),
        (fx.CommandStatus("One", "skipped"), "One skipped"),
        (fx.Fault("robot.stuck", "it does not move", "continue"), "robot.stuck: it does not move"),
        (fx.Ended("interrupted", "stopped"), "the run has ended"),
    ],
)
def test_whatever_goes_wrong_stops_them(effect: fx.Effect, why: str) -> None:
    me = Watched()
    me.asked()
    me.hears(effect)

    assert me.giver.series.stopped == why
    assert me.asked() == ()


def test_what_the_mission_itself_has_given_does_not_count() -> None:
    """A command that the pause had suspended fails when the first of the series takes over."""
    me = Watched()
    me.asked()
    me.hears(fx.CommandStatus("One", "failed", "the operator took over", "mission.yaml:3:5"))

    assert me.giver.series.active
