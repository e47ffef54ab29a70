"""Breakpoints in the console: the list, running to a line, and what a stop leaves of them."""

from __future__ import annotations

from textual.widgets import OptionList

from pirate_sm.running.runtime.breakpoints import breakables
from pirate_sm.running.wiring import Prepared
from pirate_sm.views.console.stepping import BreakpointList

from .driving import Operator, by_hand, mission, operator, played, with_mission


def traced(*breakpoints: str) -> Prepared:
    return with_mission("mitre_bend", backend="trace", breakpoints=breakpoints, check=False)


def paused_before(me: Operator) -> str:
    """The line of the file before which the mission is paused."""
    state, program = me.latest.state, me.latest.scene.loaded.program
    assert state is not None
    assert state.mission.paused
    file, line, _ = program.instructions[state.mission.pc].place.rsplit(":", 2)
    assert file == me.latest.scene.loaded.documents[0].name
    return me.latest.scene.loaded.documents[0].lines[int(line) - 1].strip()


def is_paused(me: Operator) -> bool:
    return bool(me.latest.state and me.latest.state.mission.paused)


async def mark(me: Operator, text: str) -> None:
    """The line with this text is marked in the open list."""
    listed = me.app.screen.query_one(OptionList)
    found = [n for n, each in enumerate(listed.options) if text in str(each.prompt)]
    listed.highlighted = found[0]
    await me.look()


def test_a_line_of_the_list_is_set_and_the_mission_pauses_before_it() -> None:
    async def story() -> None:
        async with operator(traced()) as me:
            await me.look()
            await me.press("asterisk")
            await me.look()
            assert isinstance(me.app.screen, BreakpointList)
            await mark(me, "enter:")
            await mark(me, "ClampRear")
            await me.press("enter")
            await me.look()
            assert isinstance(me.app.screen, BreakpointList), "more of them can be set"
            line = str(me.app.screen.query_one(OptionList).options[2].prompt)
            assert "●" in line, line
            await me.press("escape")

            await me.press("r")
            me.until(lambda: not is_paused(me))
            me.until(lambda: is_paused(me))

            assert "ClampRear" in paused_before(me)
            assert me.wheels_stand()
            assert any("breakpoint: enter pauses before" in each for each in me.told())

            await me.press("full_stop")
            me.until(lambda: not is_paused(me))
            me.until(lambda: is_paused(me))
            assert "ClampRear" not in paused_before(me)

    played(story)


def test_run_to_here_starts_a_mission_that_pauses_there_once() -> None:
    async def story() -> None:
        async with operator(traced()) as me:
            await me.look()
            await me.press("asterisk")
            await me.look()
            await mark(me, "ClampRear")
            await me.press("greater_than_sign")
            await me.look()
            me.until(lambda: not is_paused(me))
            me.until(lambda: is_paused(me))

            assert "ClampRear" in paused_before(me)
            assert me.latest.state is not None
            assert me.latest.state.mission.breakpoints == ()
            assert me.latest.state.mission.until == ""

    played(story)


def test_breakpoints_of_the_command_line_hold_from_the_start_and_after_a_stop() -> None:
    async def story() -> None:
        places = breakables(mission("mitre_bend"))
        rear = next(str(each.line) for each in places if "ClampRear" in each.text)
        async with operator(traced(rear, "prepare")) as me:
            await me.look()
            await me.press("r")
            me.until(lambda: any("breakpoint: enter" in each for each in me.told()))
            me.until(lambda: is_paused(me))
            assert "ClampRear" in paused_before(me)

            await me.press("space")
            me.until(lambda: me.latest.stopped_in == "enter")

            assert me.latest.state is not None
            assert len(me.latest.state.mission.breakpoints) == 2

    played(story)


def test_without_a_mission_there_are_none() -> None:
    async def story() -> None:
        async with operator(by_hand()) as me:
            await me.press("asterisk")
            await me.look()
            assert not isinstance(me.app.screen, BreakpointList)

    played(story)
