"""The check of the console answers from a process of its own."""

from __future__ import annotations

import os
import signal
import time
from asyncio import CancelledError
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest

from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.robot import RobotSpec, at_rest_in
from pirate_sm.running.wiring import Order, load
from pirate_sm.views.console.availability import HandBackSituation, look_at_entries
from pirate_sm.views.console.check_process import CheckProcess, ask_here
from pirate_sm.views.console.hand_back import look_for_ways


@pytest.fixture(scope="module")
def process() -> Iterator[CheckProcess]:
    with CheckProcess() as process:
        yield process


def _phases(loaded: LoadedMission) -> tuple[str, ...]:
    return tuple(loaded.program.phases)


def _kill() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.thorough
def test_it_answers_as_this_process_would_for_one_mission_after_the_other(
    process: CheckProcess,
) -> None:
    for name in ("enter_2d", "exp_3_drive", "enter_2d"):
        loaded = load(Order(name))
        body = at_rest_in(loaded.robot, loaded.program.start_configuration)
        entries = ask_here(look_at_entries, loaded, body)
        blocked = tuple(phase for phase, reason in entries.items() if reason)
        situation = HandBackSituation(1, body.configuration, ())
        what = loaded, situation, body, None, blocked, None

        assert process.ask(look_at_entries, loaded, body) == entries
        assert process.ask(look_for_ways, *what) == ask_here(look_for_ways, *what)


def test_it_is_another_process_which_signals_for_the_console_do_not_end(
    process: CheckProcess,
) -> None:
    number = process.ask(os.getpid)
    assert number != os.getpid()

    for meant_for_the_console in (signal.SIGINT, signal.SIGHUP, signal.SIGQUIT):
        os.kill(number, meant_for_the_console)

    assert process.ask(os.getpid) == number


def test_a_function_that_raises_is_a_fault_of_this_program_with_its_traceback(
    process: CheckProcess,
) -> None:
    with pytest.raises(RuntimeError, match=r"Traceback(.|\n)*invalid literal for int"):
        process.ask(int, "no number")
    assert process.ask(int, "7") == 7


def test_a_process_that_has_died_is_replaced_and_sent_the_mission_again(
    process: CheckProcess,
) -> None:
    loaded = load(Order("exp_3_drive"))
    assert process.ask(_phases, loaded) == _phases(loaded)
    os.kill(process.ask(os.getpid), signal.SIGKILL)

    assert process.ask(_phases, loaded) == _phases(loaded)


class _Worker(dict[str, str]):
    """A part of a robot; while it is pickled, another thread works something out of the robot."""

    robot: RobotSpec

    def __reduce__(self) -> tuple[Any, ...]:
        assert self.robot.fault_codes
        return dict, (dict(self),)


def test_a_mission_can_be_sent_while_another_thread_works_something_out_of_its_robot(
    process: CheckProcess,
) -> None:
    loaded = load(Order("exp_3_drive"))
    part = _Worker(loaded.robot.words_joint)
    part.robot = replace(loaded.robot, words_joint=part)
    assert "fault_codes" not in vars(part.robot)

    assert process.ask(_phases, replace(loaded, robot=part.robot)) == _phases(loaded)
    assert "fault_codes" in vars(part.robot)


def test_what_a_robot_has_worked_out_is_not_sent(process: CheckProcess) -> None:
    robot = load(Order("exp_3_drive")).robot
    assert robot.possible_owners
    assert "possible_owners" in vars(robot)

    assert "possible_owners" not in process.ask(vars, robot)


@pytest.mark.thorough
def test_a_question_that_kills_the_process_twice_is_an_error(process: CheckProcess) -> None:
    with pytest.raises(RuntimeError, match="ended by itself"):
        process.ask(_kill)
    assert process.ask(int, "7") == 7


def test_it_ends_with_the_console() -> None:
    with CheckProcess() as process:
        number = process.ask(os.getpid)

    with pytest.raises(ProcessLookupError):
        os.kill(number, 0)


def test_leaving_does_not_wait_for_an_answer() -> None:
    with CheckProcess(leaving=lambda: True) as process, pytest.raises(CancelledError):
        process.ask(time.sleep, 3600)


@pytest.mark.thorough
def test_whoever_asks_when_it_was_left_gets_no_answer_and_starts_no_process() -> None:
    """One was started again, which nobody ended."""
    with CheckProcess() as process:
        assert process.ask(os.getpid) != os.getpid()

    with pytest.raises(CancelledError):
        process.ask(os.getpid)
