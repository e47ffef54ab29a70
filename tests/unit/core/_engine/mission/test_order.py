"""What comes first when several things happen at one moment (rule 6)."""

from __future__ import annotations

import pytest
from driving import BOTH_CLAMPED

from pirate_sm.core import effects as fx
from pirate_sm.core._model import events as ev

WAITING = """
start: a
phases:
  a:
    wait:
      - {name: first, when: detector == close, go: b}
      - {name: second, when: "detector in (close, in)", go: c}
      - {name: timed, after: 500 ms, go: c}
    within: {time: 500 ms, go: late}
  b: {do: [{log: b}], go: e}
  c: {do: [{log: c}], go: e}
ends: {e: {succeed: ok}, late: {fail: late}}
"""


def test_triggers_in_listed_order(drive):
    driver = drive(WAITING)

    driver.give(ev.DetectorWord("close", 5.0), 0.1)

    assert driver.fired == ["first"]


def test_a_trigger_before_the_time_of_the_wait(drive):
    driver = drive(WAITING)

    driver.give(ev.DetectorWord("close", 5.0), 0.5)

    assert driver.fired == ["first"]


def test_a_listed_time_before_within(drive):
    driver = drive(WAITING)

    driver.tick(0.5)

    assert driver.fired == ["timed"]


def test_a_fault_before_a_trigger(drive):
    driver = drive("on_fault: [{fault: robot.stuck, go: c}]\n" + WAITING)
    driver.give(ev.DetectorWord("past", 5.0), 0.1)

    driver.give(ev.FaultReport("robot.stuck", "stuck"), 0.5)
    driver.accept()

    assert driver.fired == []
    assert driver.phases == ["a", "c"]


def test_a_fault_that_a_frame_tells_before_the_trigger_that_it_makes_true(drive):
    driver = drive("""
on_fault: [{fault: sensor.silent, go: c}]
start: a
phases:
  a: {wait: [{when: not known(gamma_1), go: b}], within: {time: 1 min, go: b}}
  b: {go: e}
  c: {go: e}
ends: {e: {succeed: ok}}
""")
    # Unknown at the start, so `known` is false at once: the wait is over before any frame.
    assert driver.phases == ["a", "b"]

    driver = drive("""
on_fault: [{fault: sensor.silent, go: c}]
start: a
phases:
  a: {do: [ClampFront], wait: [{when: not known(gamma_1), go: b}], within: {time: 1 min, go: b}}
  b: {go: e}
  c: {go: e}
ends: {e: {succeed: ok}}
""")
    driver.until_waiting("a")
    driver.signals["gamma_1"] = float("nan")
    driver.report(22, driver.now + 0.1)
    driver.accept()

    assert driver.phases == ["a", "c"]


def test_an_abort_before_everything(drive):
    driver = drive(WAITING)

    effects = driver.give(ev.Abort("by hand"), 0.5)

    assert effects == [fx.Ended("interrupted", "by hand")]


COMMANDING = """
time_limit: 5500 ms
start: a
phases:
  a: {do: [{command: ClampFront, timeout: 5 s}, ToggleLighting], go: e}
ends: {e: {succeed: ok}}
"""


def test_completion_before_the_commands_own_deadline(drive):
    driver = drive(COMMANDING)
    driver.accept()
    driver.run(4.7)
    driver.signals |= {"bend_torque_1": -0.6, "bend_torque_2": 0.6}
    driver.report_all(4.8)
    driver.report_all(4.9)

    driver.tick(5.0)

    assert ("ClampFront", "done") in driver.statuses
    assert driver.statuses[-1] == ("ToggleLighting", "sent")


def test_time_last_of_all_the_missions_limit(drive):
    driver = drive("""
time_limit: 500 ms
start: a
phases: {a: {wait: [{after: 500 ms, go: e}]}}
ends: {e: {succeed: ok}}
""")
    driver.tick(0.5)

    assert driver.ended.outcome == "succeeded"


def test_no_command_begins_when_the_time_is_up(drive):
    driver = drive("""
time_limit: 500 ms
start: a
phases: {a: {wait: [{after: 500 ms, go: b}]}, b: {do: [ClampFront], go: e}}
ends: {e: {succeed: ok}}
""")
    driver.tick(0.5)

    assert driver.statuses == []
    assert driver.ended.message == "the mission's time limit of 0.5 s has passed"


def test_completion_at_the_missions_limit_counts_but_nothing_follows(drive):
    driver = drive(COMMANDING)
    driver.tick(0.5)
    driver.accept()
    driver.run(5.2)
    driver.signals |= {"bend_torque_1": -0.6, "bend_torque_2": 0.6}
    driver.report_all(5.3)
    driver.report_all(5.4)

    driver.tick(5.5)

    assert driver.statuses[-1] == ("ClampFront", "done")
    driver.accept()
    assert "time limit" in driver.ended.message


@pytest.mark.parametrize("nominal", [True, False])
def test_the_same_moment_in_two_events_is_the_same_as_in_one(drive, nominal):
    driver = drive(WAITING, states=BOTH_CLAMPED, nominal=nominal)
    driver.tick(0.5)

    again = driver.tick(0.5)

    assert [effect for effect in again if not isinstance(effect, fx.WakeAt)] == []
