"""What the operator can say: commands, answers, skip."""

from __future__ import annotations

import math

import pytest
from driving import BOTH_CLAMPED, IDLE, command

from pirate_sm.core import effects as fx
from pirate_sm.core._model import events as ev

ASKING = """
start: a
phases:
  a:
    do:
      - {ask: "Which way?", choices: {left: continue, right: other, nowhere: fail}, timeout: 10 s}
      - {log: left}
    go: e
  other: {do: [{log: right}], go: e}
ends: {e: {succeed: "After {cause}"}}
"""
MISSION = """
start: a
phases:
  a:
    do: [ClampFront, ToggleLighting]
    wait: [{name: one, when: detector == close, go: b}, {name: two, when: detector == in, go: c}]
    within: {time: 1 h, go: c}
  b: {do: [{log: b}], go: e}
  c: {do: [{log: c}], go: e}
ends: {e: {succeed: ok}}
"""


# --- answers


def test_a_question_is_asked_with_its_choices(drive):
    driver = drive(ASKING)

    assert driver.of(fx.Ask) == [fx.Ask("Which way?", ("left", "right", "nowhere"))]
    assert driver.wake_at == 0.25
    assert driver.ended is None


@pytest.mark.parametrize(("answer", "said"), [("left", "left"), ("right", "right")])
def test_an_answer_leads_where_its_choice_says(drive, answer, said):
    driver = drive(ASKING)

    driver.give(ev.Answer(answer), 0.5)

    assert driver.messages == [said]
    assert driver.of(fx.Ask)[-1] == fx.Ask("", ())
    assert driver.ended.message.startswith(f"After the operator answered '{answer}' (")


def test_fail_is_a_failure_of_the_step(drive):
    driver = drive(ASKING)

    driver.give(ev.Answer("nowhere"), 0.5)

    assert driver.ended.outcome == "failed"
    assert driver.ended.message.startswith("the operator answered 'nowhere' to 'Which way?' (")


def test_something_else_is_no_answer(drive):
    driver = drive(ASKING)

    driver.give(ev.Answer("up"), 0.5)

    assert driver.messages == ["'up' is no answer to 'Which way?'"]
    assert driver.ended is None


def test_no_answer_in_time_is_a_failure(drive):
    driver = drive(ASKING, nominal=True)
    driver.tick(9.9)
    assert driver.ended is None

    driver.tick(10.0)

    assert driver.ended.outcome == "failed"
    assert "was not answered within 10 s" in driver.ended.message
    assert driver.of(fx.Ask)[1:] == [fx.Ask("", ())]


def test_an_answer_that_nobody_asked_for_is_forgotten(drive):
    driver = drive(MISSION)
    driver.give(ev.Answer("yes"), 0.1)

    assert driver.state.mission.answer is None


# --- skip


def test_skip_takes_the_first_trigger_or_the_one_that_is_named(drive):
    for name, phase in (("", "b"), ("one", "b"), ("two", "c")):
        driver = drive(MISSION)
        driver.until_waiting("a")

        driver.give(ev.Skip(name))

        assert driver.phases == ["a", phase]
        assert driver.of(fx.TriggerFired)[0].reason == "taken by the operator"


def test_skip_of_a_trigger_that_is_not_there_is_said(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")

    driver.give(ev.Skip("three"))

    assert driver.messages == ["a does not wait for 'three'"]
    assert driver.fired == []


def test_skip_answers_a_question_as_expected(drive):
    driver = drive(ASKING)

    driver.give(ev.Skip(), 0.1)

    assert driver.messages == ["left"]


def test_skip_passes_over_a_command_and_leaves_it_unconfirmed(drive):
    driver = drive(MISSION)
    driver.accept()

    driver.give(ev.Skip(), 0.1)

    assert driver.statuses[2:] == [("ClampFront", "skipped"), ("ToggleLighting", "sent")]
    assert driver.unconfirmed == {"FrontWheelsState", "BendingState"}


def test_skip_waits_until_it_is_known_whether_the_chart_has_moved(drive):
    driver = drive(MISSION)

    driver.give(ev.Skip(), 0.1)
    assert driver.statuses == [("ClampFront", "sent")]
    driver.give(ev.DetectorWord("in", 9.0), 0.2)
    driver.accept()

    assert driver.states["BendingState"] == "FrontClampedRearRelaxed"
    assert driver.statuses[1:4] == [
        ("ClampFront", "accepted"),
        ("ClampFront", "skipped"),
        ("ToggleLighting", "sent"),
    ]


def test_skip_of_a_command_that_is_then_rejected_passes_over_it_too(drive):
    driver = drive(MISSION.replace("ClampFront,", "{command: ClampFront, retry: 1},"))
    driver.give(ev.Skip(), 0.1)

    driver.accept("rejected")

    assert driver.statuses == [
        ("ClampFront", "sent"),
        ("ClampFront", "failed"),
        ("ToggleLighting", "sent"),
    ]


def test_skip_of_a_bend_stops_its_loops(drive):
    driver = drive(
        """
starts_in: {BendingState: FrontClampedRearRelaxed, FrontWheelsState: Fixed}
start: a
phases: {a: {do: [BendBack], wait: [{operator: x, go: e}], within: {time: 1 h, go: e}}}
ends: {e: {succeed: ok}}
"""
    )
    driver.report_all(0.1)
    driver.accept()
    driver.report_all(0.2)
    driver.accept()
    assert driver.nonzero.keys() == {"bend_1", "bend_2", "bend_3", "bend_4"}

    driver.give(ev.Skip())

    assert driver.nonzero.keys() == {"bend_1", "bend_2"}


# --- commands


def test_the_operators_command_does_not_end_a_wait(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")

    command(driver, "ToggleLighting")
    driver.obey()
    driver.obey()

    assert driver.statuses[-1] == ("ToggleLighting", "done")
    assert driver.last_status.place == ""
    assert driver.ended is None
    assert driver.phases == ["a"]


def test_the_missions_next_command_waits_for_the_operators(drive):
    driver = drive(MISSION.replace("{log: b}", "ClampRear"))
    driver.until_waiting("a")
    command(driver, "ToggleLighting")

    driver.give(ev.Skip("one"))
    assert driver.statuses[-1] == ("ToggleLighting", "sent")
    driver.accept()

    assert driver.statuses[-1] == ("ClampRear", "sent")


def test_a_failure_of_the_operators_command_is_not_one_of_the_mission(drive):
    driver = drive(MISSION)
    driver.until_waiting("a")
    command(driver, "AlignLeft")
    driver.accept()
    driver.signals["phi"] = 0.0

    give_up = driver.now + 42
    while driver.now < give_up:
        driver.run(driver.now + 0.1)
        if driver.in_flight:
            driver.accept()

    assert driver.statuses[-1] == ("AlignLeft", "failed")
    assert driver.ended is None


def test_no_command_is_taken_while_the_mission_ends(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.give(ev.Abort("enough"), 0.1)
    driver.accept("unknown")

    command(driver, "RelaxRear")

    assert driver.last_status.reason == "impossible: the mission is ending"


# --- the end


@pytest.mark.parametrize("status", ["accepted", "rejected", "superseded", "unknown"])
def test_an_end_awaits_the_fate_of_the_safe_array(drive, status):
    driver = drive(IDLE, states=BOTH_CLAMPED, nominal=True)
    driver.give(ev.Abort("enough"), 1.0)
    assert driver.ended is None

    driver.accept(status, "because")
    for _ in range(30):
        if not driver.ended:
            driver.tick(driver.wake_at)

    note = {
        "accepted": "",
        "unknown": " (the safe setpoints were not confirmed)",
    }.get(status, f" (the backend has {status} setpoints: because)")
    assert driver.ended == fx.Ended("interrupted", f"enough{note}")
    assert driver.now <= 3.0


def test_an_end_does_not_wait_for_ever_for_a_backend_that_says_nothing(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED, nominal=True)
    driver.give(ev.Abort("enough"), 1.0)
    assert driver.wake_at == 3.0

    driver.tick(3.0)

    assert driver.ended.message == "enough (the safe setpoints were not confirmed)"


def test_after_the_end_nothing_has_any_effect(drive):
    driver = drive(IDLE)
    driver.give(ev.Abort("enough"), 1.0)
    assert driver.ended is not None
    state = driver.state

    for event in (
        ev.Tick(),
        ev.Resume(),
        ev.OperatorCommand("ClampFront"),
        ev.Abort("again"),
        ev.SubmitResult(1, "accepted"),
        ev.FaultReport("link.lost", ""),
        ev.Skip(),
        ev.Answer("x"),
        ev.DetectorWord("close", 1.0),
        ev.SensorFrame(22, (math.nan,) * 9),
    ):
        assert driver.give(event, 2.0) == []
    assert driver.state is state


def test_nothing_is_sent_when_nothing_ever_was(drive):
    driver = drive(IDLE)

    assert driver.give(ev.Abort("enough"), 1.0) == [fx.Ended("interrupted", "enough")]


def test_an_abort_with_a_reset_in_flight_keeps_the_clamps(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.show(0.1, gamma_1=-1.0, gamma_2=1.0, gamma_3=-1.0, gamma_4=1.0)
    command(driver, "Reset")

    driver.give(ev.Abort("no!"))

    assert driver.nonzero == pytest.approx(
        {"bend_1": -0.7, "bend_2": 0.7, "bend_3": -0.7, "bend_4": 0.7}
    )
    assert ("Reset", "failed") in driver.statuses


def test_an_abort_before_the_first_array_keeps_the_angle_that_is_measured(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.show(0.1, phi=0.8)

    driver.give(ev.Abort("no!"))

    assert driver.array["rotate"] == pytest.approx(0.8, abs=1e-3)
    assert driver.engine.safe_values(driver.state)[10] == pytest.approx(0.8, abs=1e-3)


def test_phases_that_go_round_without_waiting_are_found_out(drive):
    driver = drive(
        "start: a\nphases: {a: {go: b}, b: {go: a}}\nends: {e: {succeed: ok}}\n",
    )
    assert driver.ended.outcome == "failed"
    assert driver.ended.message == "the phases repeat without ever waiting"


def test_failures_that_go_round_are_found_out(drive):
    driver = drive(
        """
start: a
phases:
  a: {do: [Brake], on_failure: b, go: e}
  b: {do: [Brake], on_failure: a, go: e}
ends: {e: {succeed: ok}}
"""
    )
    assert driver.ended.message == "the phases repeat without ever waiting"


@pytest.mark.parametrize("accepted", [False, True])
def test_the_mission_gives_no_command_while_one_of_the_operator_is_under_way(drive, accepted):
    driver = drive(
        "start: a\nphases: {a: {wait: [{after: 1 s, go: b}]}, b: {do: [ToggleLighting], go: e}}\n"
        "ends: {e: {succeed: ok}}\n",
        states=BOTH_CLAMPED,
    )
    driver.report_all(0.1)
    command(driver, "DriveForward")
    if accepted:
        driver.accept()

    driver.run(1.1)
    assert driver.phases == ["a", "b"]
    assert ("ToggleLighting", "sent") not in driver.statuses

    driver.until_sent("ToggleLighting")
    assert ("DriveForward", "done") in driver.statuses


def test_a_command_that_the_end_interrupts_has_failed_for_that_reason(drive):
    driver = drive(MISSION)
    driver.accept()
    driver.give(ev.Abort("enough"))

    assert driver.last_status.status == "failed"
    assert driver.last_status.reason.startswith("the mission ended; it was not done yet: ")


def test_a_failure_that_is_passed_over_is_not_the_cause(drive):
    driver = drive(
        "start: a\nphases:\n  a: {do: [Brake], on_failure: h, go: e}\n"
        "  h: {do: [{command: DriveForward, on_failure: continue}], go: e}\n"
        'ends: {e: {fail: "After {cause}"}}\n'
    )

    assert driver.ended.message.startswith("After Brake (")
    assert "DriveForward" not in driver.ended.message
