"""Breakpoints pause a mission before an instruction, in the state in which any pause holds it."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from driving import Driver

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.mission.program import Do, Enter, Finish, Instruction, Question, Say
from pirate_sm.core._model import events as ev

MISSION = """
start: a
phases:
  a:
    do: [ClampFront, ClampRear, DriveForward, {log: driving}, Brake]
    go: b
  b: {do: [{repeat: {times: 3, do: [{log: round}]}}], go: c}
  c: {do: [{command: RelaxFront, retry: 2, on_failure: d}], go: e}
  d: {do: [{ask: Fine?, choices: {sure: e, not: e}, timeout: 1 min, on_failure: e}], go: e}
ends: {e: {succeed: ok}}
time_limit: 2 min
"""

Find = Callable[[Instruction], bool]


def place(driver: Driver, find: Find, nth: int = 0) -> str:
    """The place of an instruction."""
    found = [it.place for it in driver.engine.program.instructions if find(it)]
    return found[nth]


def does(driver: Driver, command: str) -> Find:
    return lambda it: isinstance(it, Do) and driver.robot.commands[it.command].name == command


def enters(phase: str) -> Find:
    return lambda it: isinstance(it, Enter) and it.phase == phase


def breaking(driver: Driver, *at: str) -> Driver:
    driver.give(ev.Breakpoints(at))
    return driver


def until_paused(driver: Driver) -> None:
    driver.until(lambda it: it.state.mission.paused)
    while driver.in_flight:
        driver.accept()


def hits(driver: Driver) -> list[str]:
    return [each for each in driver.messages if each.startswith("breakpoint")]


def resume(driver: Driver, event: ev.Event | None = None) -> None:
    driver.give(event or ev.Resume())
    if driver.in_flight:
        driver.accept()


def test_pauses_before_the_instruction_with_wheels_stopped_and_clamps_held(drive):
    driver = drive(MISSION)
    at = place(driver, lambda it: isinstance(it, Say))
    breaking(driver, at)

    until_paused(driver)

    assert hits(driver) == [f"breakpoint: a pauses before {at}"]
    assert "driving" not in driver.messages
    assert all(driver.array[f"wheel_{n}"] == 0 for n in range(1, 7))
    held = {name: value for name, value in driver.nonzero.items() if name.startswith("bend")}
    assert len(held) == 4

    driver.give(ev.Resume())
    assert driver.array["wheel_1"] != 0, "the mission's own actuation is restored"
    driver.accept()
    assert "driving" in driver.messages


def test_no_array_of_the_command_is_sent_before_it_is_resumed(drive):
    driver = drive(MISSION)
    breaking(driver, place(driver, does(driver, "Brake")))
    until_paused(driver)

    assert ("Brake", "sent") not in driver.statuses
    resume(driver)
    assert ("Brake", "sent") in driver.statuses


def test_pauses_before_the_first_instruction_when_known_before_the_start(drive):
    driver = drive(MISSION, nominal=True)
    at = ev.Breakpoints((place(driver, enters("a")),))

    driver.state, effects = driver.engine.start(0.0, [at])
    driver.effects = list(effects)

    assert driver.state.mission.paused
    assert driver.phases == []
    resume(driver)
    assert driver.phases == ["a"]


def test_pauses_before_an_end(drive):
    driver = drive(MISSION)
    breaking(driver, place(driver, lambda it: isinstance(it, Finish)))
    until_paused(driver)
    assert driver.ended is None

    resume(driver)
    driver.until(lambda it: it.state.mission.ended)
    assert driver.of(fx.Ended)[-1].outcome == "succeeded"


def test_pauses_in_each_round_of_a_repeat(drive):
    driver = drive(MISSION)
    breaking(driver, place(driver, lambda it: isinstance(it, Say), 1))
    for rounds in range(3):
        until_paused(driver)
        assert driver.messages.count("round") == rounds
        resume(driver)
    assert driver.messages.count("round") == 3


def test_until_pauses_once(drive):
    driver = drive(MISSION)
    at = place(driver, lambda it: isinstance(it, Say), 1)
    driver.give(ev.Pause())
    while driver.in_flight:
        driver.accept()

    resume(driver, ev.Resume(until=at))
    until_paused(driver)
    assert driver.messages.count("round") == 0

    resume(driver)
    assert driver.messages.count("round") == 3


def test_another_breakpoint_on_the_way_ends_a_run_to_a_place(drive):
    driver = drive(MISSION)
    breaking(driver, place(driver, does(driver, "ClampRear")))
    driver.give(ev.Pause())
    while driver.in_flight:
        driver.accept()
    resume(driver, ev.Resume(until=place(driver, does(driver, "Brake"))))
    until_paused(driver)
    assert ("ClampRear", "sent") not in driver.statuses

    breaking(driver)
    resume(driver)
    driver.until(lambda it: it.state.mission.ended)
    assert len(hits(driver)) == 1


def test_two_breakpoints_at_neighbouring_instructions_pause_twice(drive):
    driver = drive(MISSION)
    phase, step = place(driver, enters("c")), place(driver, does(driver, "RelaxFront"))
    breaking(driver, phase, step)

    until_paused(driver)
    assert driver.phases[-1] == "b"
    resume(driver)
    assert driver.state.mission.paused
    assert driver.phases[-1] == "c"
    assert len(hits(driver)) == 2


def test_a_step_that_ends_at_a_breakpoint_pauses_once(drive):
    driver = drive(MISSION)
    breaking(driver, place(driver, enters("c")))
    until_paused(driver)
    breaking(driver, place(driver, does(driver, "RelaxFront")))

    resume(driver, ev.Step())
    assert driver.state.mission.paused

    breaking(driver)
    resume(driver)
    assert not driver.state.mission.paused


def test_a_command_that_is_repeated_after_a_failure_is_not_paused_again(drive):
    driver = drive(MISSION)
    breaking(driver, place(driver, does(driver, "RelaxFront")))
    until_paused(driver)
    driver.give(ev.Resume())

    driver.accept("rejected", "so the test")

    assert driver.statuses.count(("RelaxFront", "sent")) == 2
    assert len(hits(driver)) == 1


def test_one_that_is_set_while_a_command_is_under_way_waits_for_its_next_time(drive):
    driver = drive(MISSION)
    driver.until_sent("RelaxFront")
    breaking(driver, place(driver, does(driver, "RelaxFront")))

    driver.accept("rejected", "so the test")

    assert hits(driver) == []
    assert driver.statuses.count(("RelaxFront", "sent")) == 2


def test_one_at_the_place_of_a_pause_does_not_pause_there_again(drive):
    driver = drive(MISSION)
    at = place(driver, does(driver, "Brake"))
    breaking(driver, at)
    until_paused(driver)
    breaking(driver, at, place(driver, enters("b")))

    resume(driver)

    assert not driver.state.mission.paused
    assert ("Brake", "sent") in driver.statuses


def test_a_stop_at_a_breakpoint_ends_the_run_in_the_safe_state(drive):
    driver = drive(MISSION)
    breaking(driver, place(driver, does(driver, "Brake")), place(driver, enters("b")))
    until_paused(driver)

    driver.give(ev.Abort("the operator"))
    driver.until(lambda it: it.state.mission.ended)

    assert driver.of(fx.Ended)[-1].outcome == "interrupted"
    assert all(driver.array[f"wheel_{n}"] == 0 for n in range(1, 7))
    assert driver.array["bend_1"] != 0


def test_a_stop_on_the_way_to_one_is_not_paused(drive):
    driver = drive(MISSION)
    driver.until_done("DriveForward")
    breaking(driver, place(driver, lambda it: isinstance(it, Finish)), place(driver, enters("b")))

    driver.give(ev.Abort("the operator"))
    driver.until(lambda it: it.state.mission.ended)

    assert hits(driver) == []


def test_a_fault_during_the_pause_leads_to_its_handler_which_waits_to_be_resumed(drive):
    driver = drive(
        MISSION.replace("time_limit", "on_fault: [{fault: sensor.silent, go: d}]\ntime_limit")
    )
    breaking(driver, place(driver, does(driver, "Brake")), place(driver, enters("d")))
    until_paused(driver)

    driver.give(ev.FaultReport("sensor.silent", "so the test", of=("imu",)))
    while driver.in_flight:
        driver.accept()

    assert driver.state.mission.paused
    assert "d" not in driver.phases
    assert all(driver.array[f"wheel_{n}"] == 0 for n in range(1, 7))
    resume(driver)
    assert driver.phases[-1] == "d"
    assert len(hits(driver)) == 1, "it was resumed there"


def test_a_fault_pauses_before_its_handler_with_the_wheels_stopped(drive):
    driver = drive(
        MISSION.replace("time_limit", "on_fault: [{fault: sensor.silent, go: d}]\ntime_limit")
    )
    breaking(driver, place(driver, enters("d")))
    driver.until_sent("DriveForward")

    driver.give(ev.FaultReport("sensor.silent", "so the test", of=("imu",)))
    until_paused(driver)

    assert hits(driver) == [f"breakpoint: d pauses before {place(driver, enters('d'))}"]
    assert all(driver.array[f"wheel_{n}"] == 0 for n in range(1, 7))


def test_a_hand_back_pauses_at_a_breakpoint_of_its_phase(drive):
    driver = drive(MISSION)
    breaking(driver, place(driver, enters("b")))
    driver.until_done("ClampRear")
    driver.give(ev.Pause())
    while driver.in_flight:
        driver.accept()
    change = driver.of(fx.StateChange)[-1]

    driver.give(ev.GoTo("b", change.states, change.unconfirmed))

    assert driver.state.mission.paused
    assert len(hits(driver)) == 1


def test_a_question_is_not_asked_before_it_is_resumed(drive):
    driver = drive(MISSION.replace("go: b", "go: d"))
    breaking(driver, place(driver, lambda it: isinstance(it, Question)))
    until_paused(driver)
    assert driver.of(fx.Ask) == []
    resume(driver)
    assert driver.of(fx.Ask)[-1].question == "Fine?"


@pytest.mark.parametrize("event", [ev.Breakpoints(("nowhere:1:1",)), ev.Resume(until="x:1:1")])
def test_a_place_that_the_mission_does_not_have_changes_nothing(drive, event):
    plain, driver = drive(MISSION), drive(MISSION)
    driver.give(event)
    for each in (plain, driver):
        each.until(lambda it: it.state.mission.ended)
    assert driver.messages == plain.messages


def test_a_run_to_a_place_can_be_asked_for_while_the_mission_runs(drive):
    driver = drive(MISSION)
    driver.until_sent("ClampRear")
    driver.give(ev.Resume(until=place(driver, does(driver, "Brake"))))
    until_paused(driver)
    assert ("DriveForward", "done") in driver.statuses
    assert ("Brake", "sent") not in driver.statuses


def test_deadlines_are_later_by_the_length_of_the_pause(drive):
    driver = drive(MISSION, nominal=True)
    breaking(driver, place(driver, does(driver, "ClampRear")))
    while not driver.state.mission.paused:
        driver.accept() if driver.in_flight else driver.tick(driver.wake_at)
    driver.tick(driver.now + 1000)
    assert driver.ended is None
    resume(driver)
    assert not driver.state.mission.paused
    assert driver.ended is None
