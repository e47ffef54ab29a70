"""The stop, and every way out: the safe array has been sent."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from signal import SIGHUP, SIGINT, SIGTERM
from threading import Event as Flag
from threading import Thread
from typing import Any

import pytest
from representative import thorough_but
from textual.drivers._writer_thread import WriterThread
from textual.events import Key
from textual.widget import Widget

from pirate_sm.cli.commands.console import _conclude
from pirate_sm.core.effects import Ended
from pirate_sm.core.events import Event, FaultReport
from pirate_sm.running.runtime.ending import BY_SIGNAL, Result, Stop
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.wiring import Order, Prepared
from pirate_sm.views.console.app import Console
from pirate_sm.views.console.dialogs import Confirm, Pick
from pirate_sm.views.console.session import (
    LEAVE_WITHIN_S,
    LEFT,
    SAFE_WITHIN_S,
    OperatorSession,
    Quitting,
    Watchdog,
)
from pirate_sm.views.console.terminal_driver import Lossy, StopDriver

from .driving import HandClock, Operator, by_hand, confirming, operator, played, with_mission

SMALL = (80, 24)


def trace() -> Prepared:
    return by_hand(Order("by_hand", backend="trace"))


async def drive(me: Operator) -> None:
    for command in ("ClampFront", "ClampRear", "DriveForward"):
        await me.command(command)
    assert not me.wheels_stand()


def test_after_the_stop_driving_is_taken_at_once() -> None:
    async def story() -> None:
        async with operator(trace(), size=SMALL) as me:
            await drive(me)
            await me.press("space")
            me.wait(0.5)
            assert me.wheels_stand()

            await me.command("DriveForward")

            assert not me.wheels_stand()

    played(story)


def test_a_command_that_a_pause_has_suspended_is_taken_over() -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", "trace"), size=SMALL) as me:
            await me.look()
            await me.press("R")
            me.wait(0.5)
            await me.press("P")
            me.until(lambda: me.latest.state.mission.suspended, 5)

            await me.command("ClampRear")

            assert me.states[2] == "DoubleClamped"
            assert any("the operator took over" in each for each in me.told())
            me.until(lambda: me.latest.state.robot.flight is None)
            program = me.latest.scene.loaded.program
            assert me.latest.state.why_not_go_to(program, "regrip") == ""

    played(story)


def test_the_stop_works_over_a_dialog() -> None:
    async def story() -> None:
        async with operator(trace(), size=SMALL) as me:
            await drive(me)
            await me.press("M")
            await me.look()
            assert isinstance(me.app.screen, Pick)
            await me.press("space")
            me.wait(0.5)

            assert me.wheels_stand()
            assert me.states[2] == "DoubleClamped"

    played(story)


Stops = Callable[[Operator], Any]


async def by_key(me: Operator) -> None:
    await me.press("space")


async def by_the_key_of_a_terminal(me: Operator) -> None:
    StopDriver(me.app).process_message(Key("space", " "))


async def by_a_panel(me: Operator) -> None:
    me.session.stop()


async def by_a_fault(me: Operator) -> None:
    me.session.give_event(FaultReport("link.lost", "the port is gone"))
    me.until(lambda: any("ended fault: link.lost" in each for each in me.told()))
    me.until(lambda: me.latest.state and me.latest.state.mission.paused)


STOPS: list[Stops] = [by_key, by_the_key_of_a_terminal, by_a_panel, by_a_fault]


SOON_AND_LATER = list(product(STOPS, [False, True]))


@pytest.mark.parametrize(
    ("stops", "looks"),
    thorough_but(list(product([by_key, by_a_panel, by_a_fault], [False])), SOON_AND_LATER),
)
def test_a_question_about_a_motion_is_not_open_after_the_stop(stops: Stops, looks: bool) -> None:
    async def story() -> None:
        async with operator(confirming(trace(), "a robot is about to move"), size=SMALL) as me:
            await me.press(me.app.letters["ClampFront"])
            assert isinstance(me.app.screen, Confirm)
            await stops(me)
            if looks:
                await me.look()
                assert not isinstance(me.app.screen, Confirm)
            else:  # sooner than the console has shown anything
                await me.press("y")
            me.wait(1.0)

            assert not isinstance(me.app.screen, Confirm)
            assert me.states[2] == "Unclamped"
            await me.press(me.app.letters["ClampFront"])
            assert isinstance(me.app.screen, Confirm)  # nobody has agreed
            await me.press("y")
            me.until(lambda: me.states[2] == "FrontClampedRearRelaxed")

    played(story)


@pytest.mark.parametrize(
    ("stops", "looks"),
    thorough_but([(by_a_fault, True)], SOON_AND_LATER[2:]),
)
def test_the_list_of_phases_is_not_open_after_the_stop(stops: Stops, looks: bool) -> None:
    async def story() -> None:
        async with operator(with_mission("mitre_bend", "trace"), size=SMALL) as me:
            await me.look()
            await me.press("H")
            await me.look()
            assert isinstance(me.app.screen, Pick)
            await stops(me)
            if looks:
                await me.look()
            else:
                await me.press("enter")
            me.wait(1.0)

            assert not isinstance(me.app.screen, Pick)
            assert me.states[2] == "Unclamped"
            assert me.latest.state.mission.paused
            await me.look()
            await me.press("H")
            assert isinstance(me.app.screen, Pick)

    played(story)


def test_the_key_is_heard_by_the_thread_that_reads_the_terminal_while_the_rest_is_busy() -> None:
    async def story() -> None:
        async with operator(trace(), size=SMALL) as me:
            await drive(me)
            driver = StopDriver(me.app)
            driver.process_message(Key("space", " "))  # nothing else of the console has run
            me.clock.run(0.5, lambda: me.latest.over)

            assert me.wheels_stand()

    played(story)


def test_the_end_of_input_is_the_operator_gone() -> None:
    async def story() -> None:
        async with operator(trace(), size=SMALL) as me:
            await drive(me)
            driver = StopDriver(me.app)
            driver.fileno, typed = os.pipe()
            os.write(typed, b" ")
            os.close(typed)
            driver.run_input_thread()  # returns, and does not read the end again and again
            os.close(driver.fileno)
            me.until(lambda: me.latest.over)

            assert me.session.quitting.gone == BY_SIGNAL[SIGHUP]
            assert me.wheels_stand()

    played(story)


def watched(quitting: Quitting, clock: HandClock, codes: list[int]) -> Thread:
    dog = Thread(target=Watchdog(quitting, codes.append, clock).watch, daemon=True)
    dog.start()
    return dog


@pytest.mark.parametrize("unreachable", [False, True])
def test_a_slow_safe_stop_is_waited_for_unless_only_the_guardian_can_make_it(
    unreachable: bool,
) -> None:
    clock, quitting, found = HandClock(), Quitting(lambda: unreachable), []
    dog = watched(quitting, clock, found)
    quitting.ask(BY_SIGNAL[SIGTERM])
    clock.run(LEAVE_WITHIN_S + 0.3, lambda: not dog.is_alive())
    assert found == ([143] if unreachable else [])
    if not unreachable:
        quitting.stopped = True
        clock.run(LEAVE_WITHIN_S - 0.1, lambda: not dog.is_alive())
        assert found == []
        clock.run(0.3, lambda: not dog.is_alive())
    assert found == [143]


def test_a_safe_stop_that_never_ends_does_not_keep_the_process() -> None:
    clock, found = HandClock(), []
    quitting = Quitting()
    dog = watched(quitting, clock, found)
    quitting.ask(BY_SIGNAL[SIGTERM])
    clock.run(SAFE_WITHIN_S + LEAVE_WITHIN_S + 0.3, lambda: not dog.is_alive())
    assert found == [143]


def test_the_session_says_when_the_robot_stands() -> None:
    async def story() -> None:
        async with operator(trace(), size=SMALL) as me:
            await drive(me)
            await me.press("space")
            me.until(lambda: me.session.result)
            assert not me.session.quitting.safe  # another run follows

            me.session.quit()
            me.until(lambda: me.latest.over)
            assert me.session.quitting.safe

    played(story)


def test_nothing_waits_for_a_terminal_that_takes_no_output() -> None:
    class Stuck(io.StringIO):
        takes = Flag()

        def write(self, text: str) -> int:
            assert self.takes.wait(30.0)
            return super().write(text)

    async def story() -> None:
        async with operator(trace(), size=SMALL) as me:
            driver, file = StopDriver(me.app), Stuck()
            driver._writer_thread = writer = WriterThread(file)
            writer.start()
            for number in range(100):
                driver.write(f"{number} ")
            file.takes.set()
            while not driver._waiting.empty():
                await me.pilot.pause()
            driver.write("all")
            writer.stop()

            *some, last = file.getvalue().split()
            assert some == [str(each) for each in range(len(some))]
            assert 0 < len(some) < 100
            assert last == "all"
            assert me.app.screen._layout_required  # what was dropped is drawn again

    played(story)


@pytest.mark.parametrize(
    ("requests", "codes"),
    [
        ([LEFT], []),
        ([BY_SIGNAL[SIGINT]], []),
        ([BY_SIGNAL[SIGTERM]], [143]),
        ([BY_SIGNAL[SIGTERM], BY_SIGNAL[SIGHUP]], [143]),
        ([LEFT, BY_SIGNAL[SIGHUP]], [129]),
    ],
)
def test_the_process_ends_when_leaving_takes_long_and_nobody_is_there(
    requests: list[Stop], codes: list[int]
) -> None:
    clock, quitting, found = HandClock(), Quitting(), []
    quitting.stopped = True
    dog = watched(quitting, clock, found)
    for request in requests:
        quitting.ask(request)
    clock.run(LEAVE_WITHIN_S - 0.1, lambda: not dog.is_alive())
    assert found == []
    clock.run(0.3, lambda: not dog.is_alive())
    assert found == codes


def test_the_last_sentence_says_whether_anything_is_clamped(
    capsys: pytest.CaptureFixture[str],
) -> None:
    async def story(*commands: str) -> None:
        async with operator(trace(), size=SMALL) as me:
            for each in commands:
                await me.command(each)
        assert _conclude(me.app, me.session, debug=False) == 0

    played(story)
    assert capsys.readouterr().err.endswith("left: nothing was sent: the robot is as it was\n")
    played(partial(story, "ToggleLighting"))
    assert capsys.readouterr().err.endswith("left: wheels set to zero; no part is clamped\n")
    played(partial(story, "ClampFront"))
    left = "left: wheels set to zero; front clamped (without sensors)\n"
    assert capsys.readouterr().err.endswith(left)


def test_a_stop_before_anything_is_under_way_harms_nothing() -> None:
    async def story() -> None:
        async with operator(trace(), size=SMALL) as me:
            await me.press("space")
            await me.press("space")
            me.wait(0.5)
            await me.command("ClampFront")

            assert not me.latest.over

    played(story)


class Breaking(Console):
    """A console in which a widget fails when it is told to."""

    broken = False

    def show_words(self, snapshot) -> None:  # type: ignore[no-untyped-def]
        if self.broken:
            raise RuntimeError("a widget broke")
        super().show_words(snapshot)


def test_a_crash_in_a_widget_ends_in_the_safe_state() -> None:
    sent: list[Any] = []

    async def story() -> None:
        prepared = trace()
        submit = prepared.backend.submit
        prepared.backend.submit = lambda number, values: (  # type: ignore[method-assign]
            sent.append(values),
            submit(number, values),
        )
        async with operator(prepared, console=Breaking, size=SMALL) as me:
            await drive(me)
            assert any(sent[-1][slot] for slot in me.latest.scene.robot.safe_zero)
            me.app.broken = True  # type: ignore[attr-defined]
            try:
                me.app.show_words(me.latest)
            except RuntimeError as error:
                me.app._handle_exception(error)
            me.clock.free()
            assert me.session.join(10.0)

            assert all(sent[-1][slot] == 0 for slot in me.latest.scene.robot.safe_zero)
            assert sum(value != 0 for value in sent[-1]) >= 4  # the clamps hold
            assert isinstance(me.app.failure, RuntimeError)

    with pytest.raises(RuntimeError, match="a widget broke"):
        played(story)
    assert sent


@pytest.mark.parametrize(
    "number", thorough_but([SIGTERM, SIGHUP], BY_SIGNAL), ids=lambda number: number.name
)
def test_a_signal_ends_the_session_in_the_safe_state(number) -> None:
    async def story() -> None:
        async with operator(trace(), size=SMALL) as me:
            await drive(me)
            me.session.quitting.ask(BY_SIGNAL[number])
            me.clock.free()
            assert me.session.join(10.0)

            assert me.wheels_stand()
            assert me.session.result.ended.outcome == "interrupted"
            assert me.session.result.ended.message == BY_SIGNAL[number].reason
            assert me.latest.over

    played(story)


class Closing(Console):
    """A console whose timer fires once more when the first of its widgets has been removed."""

    async def _close_all(self) -> None:
        await self.query_one("#header").remove()
        self.show()
        await super()._close_all()


def test_a_frame_that_is_due_while_the_widgets_are_removed_is_left_out() -> None:
    async def story() -> None:
        async with operator(trace(), console=Closing, size=SMALL) as me:
            await me.command("ClampFront")

    played(story)


class Opening(Console):
    """A console whose timer fires whenever some more of its widgets have been added."""

    def _register(self, *args: Any, **options: Any) -> list[Widget]:
        added = super()._register(*args, **options)
        for _ in range(3):  # words are shown in every third frame
            self.show()
        return added


def test_a_frame_that_is_due_while_the_widgets_are_added_is_left_out() -> None:
    async def story() -> None:
        async with operator(trace(), console=Opening, size=SMALL) as me:
            await me.command("ClampFront")

    played(story)


def test_a_frame_that_is_due_when_any_widget_has_gone_is_left_out() -> None:
    async def story() -> None:
        async with operator(trace(), size=SMALL) as me:
            for name in sorted(each.id for each in me.app.screen.walk_children() if each.id):
                for found in me.app.screen.query(f"#{name}"):
                    await found.remove()
                for _ in range(3):
                    me.app.show()
            assert not me.app.screen.query("#header")

    played(story)


def test_what_lets_go_of_the_pipe_is_asked_for_twice() -> None:
    async def story() -> None:
        async with operator(trace(), size=SMALL) as me:
            await me.command("ClampFront")
            await me.press(me.app.letters["Reset"])
            assert isinstance(me.app.screen, Confirm)
            await me.press("enter")  # the careful answer
            assert me.states[2] == "FrontClampedRearRelaxed"
            await me.press(me.app.letters["Reset"])
            await me.press("y")
            me.until(lambda: me.states[2] == "Unclamped")

    played(story)


def test_the_first_motion_of_a_real_robot_is_agreed_to() -> None:
    async def story() -> None:
        async with operator(confirming(trace(), "it is about to move"), size=SMALL) as me:
            await me.press(me.app.letters["ClampFront"])
            assert isinstance(me.app.screen, Confirm)
            await me.press("n")
            me.wait(0.5)
            assert me.latest.state.robot.motion is None
            await me.press(me.app.letters["ClampFront"])
            await me.press("y")
            me.until(lambda: me.states[2] == "FrontClampedRearRelaxed")
            me.until(lambda: me.latest.state.robot.motion is None)
            await me.command("ClampRear")  # nobody asks again
            assert me.states[2] == "DoubleClamped"

    played(story)


def test_a_backend_that_fails_is_told_and_the_console_stays_to_be_read() -> None:
    prepared = trace()
    advance, cut = prepared.backend.advance, []

    def failing(until_s: float) -> tuple[float, Sequence[Event]]:
        if cut:
            raise OSError("the cable is out")
        return advance(until_s)

    prepared.backend.advance = failing  # type: ignore[method-assign]

    async def story() -> None:
        async with operator(prepared, size=SMALL) as me:
            await drive(me)
            cut.append(True)
            me.until(lambda: me.latest.over)
            await me.look()

            assert "the cable is out" in me.session.result.ended.message
            assert me.session.result.exit_code == 3
            assert me.app.is_running
            await me.pilot.press("q")

    played(story)


def test_a_robot_that_fails_again_and_again_is_not_run_for_ever(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    prepared, begun = trace(), []

    def execute(run: MissionRun) -> Result:
        begun.append(run)
        run._pump.start(paused=True)
        return Result(Ended("fault", "it fell"), 1, run.now_s)

    monkeypatch.setattr(MissionRun, "execute", execute)
    session = OperatorSession(prepared)
    session.start()

    assert session.join(10.0)
    assert len(begun) == 3
    assert session.latest.over


def test_a_terminal_that_has_gone_is_told_once_and_nobody_waits_for_it() -> None:
    class Closed(io.StringIO):
        def write(self, text: str) -> int:
            raise OSError("the other end has gone")

    told: list[bool] = []
    file = Lossy(Closed(), lambda: told.append(True))

    assert file.write("one") == 3
    assert file.write("two") == 3
    file.flush()
    assert told == [True]
