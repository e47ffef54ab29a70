"""Faults: who raises them, who may handle them, and what happens until the handler begins."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import pytest
from driving import (
    BOTH_CLAMPED,
    IDLE,
    NEWT,
    REAR_CLAMPED,
    Driver,
    changed_newt,
    command,
    write_mission,
)

from pirate_sm.core import effects as fx
from pirate_sm.core._engine import safety
from pirate_sm.core._engine.mission.program import HandlerSpec
from pirate_sm.core._engine.safety import FoundFault, silent_limit_s
from pirate_sm.core._engine.sensing.odometry import unheard
from pirate_sm.core._engine.state import OUTSIDE, FaultState
from pirate_sm.core._model import events as ev
from pirate_sm.core._model.faults import BuiltInFault

ROLLING = {f"theta_{n}": 3.0 if n % 2 else -3.0 for n in range(1, 7)}
STUCK = ev.FaultReport("robot.stuck", "it does not move")
HANDLED = """
on_fault:
  - {fault: [sensor.silent, wheel.dead], then: continue}
  - {fault: robot.stuck, go: rescue}
  - {fault: motor.hot, go: cool}
start: a
phases:
  a: {do: [ClampFront, ClampRear, DriveForward], wait: [{operator: x, go: e}], within: {time: 1 h, go: e}}
  rescue: {do: [{command: Brake, unneeded: skip}, {log: "rescued after {cause}"}], go: after}
  cool: {wait: [{after: 10 s, go: e}]}
  after: {wait: [{operator: x, go: e}], within: {time: 1 h, go: e}}
ends: {e: {succeed: "After {cause}"}}
"""  # noqa: E501


def test_continue_only_logs(drive):
    driver = drive(HANDLED)
    driver.until_waiting("a")

    driver.give(ev.FaultReport("wheel.dead", "wheel 3"))

    assert driver.of(fx.Fault) == [fx.Fault("wheel.dead", "wheel 3", "continue")]
    assert driver.nonzero["wheel_1"] == 1
    assert driver.phases == ["a"]


def test_a_fault_that_nobody_handles_ends_in_the_safe_stop(drive):
    driver = drive(HANDLED)
    driver.until_waiting("a")

    driver.give(ev.FaultReport("firmware.reset", "the boards started again"))
    driver.accept()

    assert driver.ended.outcome == "fault"
    assert driver.ended.message == "firmware.reset: the boards started again"
    assert driver.nonzero == pytest.approx(
        {"bend_1": -0.7, "bend_2": 0.7, "bend_3": -0.7, "bend_4": 0.7}
    )


def test_a_second_fault_while_the_mission_ends_is_told_with_its_own_code_and_message(drive):
    driver = drive(HANDLED)
    driver.until_waiting("a")
    driver.give(ev.FaultReport("firmware.reset", "the boards started again"))

    driver.give(ev.FaultReport("motor.hot", "the motor of wheel 1 is hot"))
    driver.accept()

    assert driver.of(fx.Fault) == [
        fx.Fault("firmware.reset", "the boards started again", "stop"),
        fx.Fault("motor.hot", "the motor of wheel 1 is hot", "stop"),
    ]
    assert driver.ended.message == "firmware.reset: the boards started again"


@pytest.mark.parametrize(
    "code", ["robot.fallen", "link.lost", "link.silent", "link.no_echo", "backend.failed"]
)
def test_what_cannot_be_caught_is_not(drive, code):
    driver = drive(HANDLED)
    driver.until_waiting("a")

    driver.give(ev.FaultReport(code, "bad"))

    assert driver.faults == [(code, "stop")]
    driver.accept()
    assert driver.ended.outcome == "fault"


def test_what_cannot_be_caught_is_not_even_when_a_program_says_so(drive):
    driver = drive(HANDLED)
    program = driver.engine.program
    handlers = tuple((HandlerSpec("link.lost", None, ""),) for _ in program.handlers)
    again = Driver(driver.robot, replace(program, handlers=handlers))

    again.give(ev.FaultReport("link.lost", "gone"), 0.1)

    assert again.faults == [("link.lost", "stop")]


def test_a_command_under_way_is_interrupted_and_stays_unconfirmed(drive):
    driver = drive(HANDLED)
    driver.until_sent("ClampRear")
    driver.accept()

    driver.give(STUCK)
    assert driver.statuses[-1] == ("ClampRear", "failed")
    assert driver.last_status.reason.startswith("interrupted by robot.stuck: it does not move; ")
    assert driver.phases == ["a"]
    driver.accept()
    driver.until_done("Brake")  # the clamp that was to fix the rear wheels is not confirmed

    assert driver.phases == ["a", "rescue", "after"]
    assert driver.unconfirmed == {"BendingState"}
    messages = [log.message for log in driver.of(fx.Log)]
    assert messages == ["rescued after robot.stuck: it does not move"]


def test_the_array_in_flight_is_resolved_first(drive):
    driver = drive(HANDLED)
    driver.until_sent("ClampRear")
    sent = driver.setpoints

    driver.give(STUCK)
    assert driver.setpoints == sent
    driver.accept()

    assert driver.states["BendingState"] == "DoubleClamped", "the chart has moved"
    assert driver.setpoints.setpoint_id == sent.setpoint_id + 1
    assert driver.nonzero == pytest.approx(
        {"bend_1": -0.7, "bend_2": 0.7, "bend_3": -0.7, "bend_4": 0.7}
    )


def test_a_wait_does_not_go_on_while_the_wheels_are_being_stopped(drive):
    driver = drive(HANDLED)
    driver.until_waiting("a")
    driver.give(STUCK)

    driver.give(ev.Answer("x"))
    driver.tick(driver.now + 0.1)

    assert driver.fired == []
    assert driver.phases == ["a"]


def test_no_deadline_wakes_for_ever_while_the_wheels_are_being_stopped(drive):
    driver = drive(
        """
on_fault: [{fault: robot.stuck, go: b}]
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
start: a
phases:
  a: {do: [DriveForward], wait: [{operator: x, go: e}], within: {time: 100 ms, go: e}}
  b: {go: e}
ends: {e: {succeed: ok}}
""",
        nominal=True,
    )
    driver.accept()
    driver.tick(0.5)
    driver.give(STUCK, 0.55)

    driver.tick(0.6)  # `within` is due, and the array is in flight

    assert driver.state.wake_at_s == math.inf
    assert driver.fired == []


@pytest.mark.parametrize("event", [STUCK, ev.Pause()])
def test_no_deadline_wakes_for_ever_while_a_command_is_in_flight(drive, event):
    driver = drive(
        """
on_fault: [{fault: robot.stuck, go: b}]
start: a
phases:
  a: {wait: [{operator: x, go: e}], within: {time: 1 s, go: e}}
  b: {go: e}
ends: {e: {succeed: ok}}
""",
        nominal=True,
    )
    command(driver, "ToggleLighting")
    driver.give(event, 0.5)

    driver.tick(1.0)  # `within` is due, and the array is in flight

    assert driver.state.wake_at_s == math.inf
    assert driver.fired == []


def test_a_fault_in_a_mission_that_the_handler_calls_is_a_second_one(drive, tmp_path):
    write_mission(
        tmp_path,
        "start: x\nphases: {x: {go: y}, y: {wait: [{after: 9 s, go: e}]}}\n"
        "ends: {e: {succeed: x}}\n",
        name="called.yaml",
    )
    driver = drive(
        """
on_fault: [{fault: robot.stuck, go: rescue}]
start: a
phases:
  a: {wait: [{operator: x, go: e}], within: {time: 1 h, go: e}}
  rescue: {do: [{call: called}], go: e}
ends: {e: {succeed: ok}}
"""
    )
    driver.give(STUCK, 0.1)
    driver.accept()
    assert driver.phases == ["a", "rescue", "rescue/called.x", "rescue/called.y"]

    driver.give(STUCK, 0.2)

    assert driver.faults == [("robot.stuck", "rescue"), ("robot.stuck", "stop")]


def test_stopped_wheels_are_not_what_the_chart_says(drive):
    driver = drive(HANDLED)
    driver.until_waiting("a")

    driver.give(STUCK)

    assert driver.states["FrontWheelsState"] == "DrivingForward"
    assert driver.unconfirmed == {"FrontWheelsState", "RearWheelsState"}


def test_wheels_that_a_fault_has_stopped_are_not_stuck(drive):
    driver = drive(HANDLED)
    driver.until_waiting("a")
    driver.give(ev.FaultReport("motor.hot", "hot"))
    driver.accept()
    assert driver.phases[-1] == "cool"

    driver.run(driver.now + 9)

    assert driver.faults == [("motor.hot", "cool")]


@pytest.mark.parametrize("second", ["robot.stuck", "motor.hot", "firmware.reset"])
def test_a_fault_while_one_is_handled_ends_in_the_safe_stop(drive, second):
    driver = drive(HANDLED)
    driver.until_waiting("a")
    driver.give(STUCK)
    driver.accept()
    assert driver.statuses[-1] == ("Brake", "sent")

    driver.give(ev.FaultReport(second, "and then this"))

    assert driver.faults[-1] == (second, "stop")
    driver.accept()
    assert driver.ended.message == f"{second}: and then this"


def test_a_fault_before_the_handler_has_begun_ends_in_the_safe_stop_too(drive):
    driver = drive(HANDLED)
    driver.until_waiting("a")
    driver.give(STUCK)

    driver.give(ev.FaultReport("motor.hot", "hot"))

    assert driver.faults == [("robot.stuck", "rescue"), ("motor.hot", "stop")]


def test_continue_only_logs_while_a_fault_is_handled(drive):
    driver = drive(HANDLED)
    driver.until_waiting("a")
    driver.give(STUCK)
    driver.accept()

    driver.give(ev.FaultReport("wheel.dead", "wheel 3"))

    assert driver.faults[-1] == ("wheel.dead", "continue")
    assert driver.ended is None


def test_handling_is_over_when_the_handler_has_gone_on(drive):
    driver = drive(HANDLED)
    driver.until_waiting("a")
    driver.give(STUCK)
    driver.accept()
    driver.until_waiting("after")

    driver.give(STUCK)
    driver.until(lambda d: d.phases.count("rescue") == 2)

    assert driver.faults == [("robot.stuck", "rescue")] * 2


def test_two_faults_of_one_frame_and_nothing_after_the_end(drive):
    driver = drive(IDLE)
    for name in ("gamma_1", "bend_torque_1", "theta_1"):
        driver.signals[name] = math.nan

    effects = driver.report(22, 0.1)

    assert driver.faults == [("sensor.silent", "stop")]
    assert isinstance(effects[-1], fx.Ended)


def test_an_open_question_is_withdrawn(drive):
    driver = drive("""
on_fault: [{fault: robot.stuck, go: b}]
start: a
phases: {a: {do: [{ask: Go on?}], go: b}, b: {wait: [{after: 1 s, go: e}]}}
ends: {e: {succeed: ok}}
""")
    driver.give(STUCK, 0.1)

    assert driver.of(fx.Ask) == [fx.Ask("Go on?", ("yes", "no")), fx.Ask("", ())]


def test_a_stop_that_the_backend_refuses_is_not_taken_for_one(drive):
    driver = drive(HANDLED)
    driver.until_waiting("a")
    driver.give(STUCK)

    driver.accept("rejected", "queue full")

    assert driver.phases == ["a"]
    assert driver.faults[-1] == ("backend.failed", "stop")
    driver.accept()
    assert driver.ended.outcome == "fault"
    assert driver.nonzero.keys() == {"bend_1", "bend_2", "bend_3", "bend_4"}


# --- rules of the profile


def driving(drive):
    driver = drive(
        "on_fault: [{fault: [robot.stuck, wheel.dead, motor.hot, sensor.silent], then: continue}]\n"
        + IDLE,
        states=BOTH_CLAMPED,
    )
    driver.report_all(0.1)
    command(driver, "DriveForward")
    driver.accept()
    return driver


def test_stuck_is_told_once_its_condition_has_held(drive):
    driver = driving(drive)
    driver.run(1.0, **ROLLING)
    assert driver.statuses[-1] == ("DriveForward", "done")

    driver.run(7.0)
    assert driver.faults == []
    driver.run(8.0)
    assert driver.faults == [("robot.stuck", "continue")]
    driver.run(15.0)
    assert driver.faults == [("robot.stuck", "continue")]


def test_a_fault_is_told_again_after_it_was_over(drive):
    driver = driving(drive)
    driver.run(1.0, **ROLLING)
    driver.run(8.0)

    driver.run(9.0, **ROLLING)
    driver.run(16.0)

    assert driver.faults == [("robot.stuck", "continue")] * 2


def test_a_silence_breaks_what_has_held(drive):
    driver = driving(drive)
    driver.signals["bend_current_1"] = 0.3
    driver.run(15.0, **ROLLING)
    others = [board for board in driver.robot.boards if board != 22]
    while driver.now < 16.0:
        driver.now += 0.1
        for board in others:
            driver.report(board)
    driver.run(25.0, **ROLLING)
    assert ("motor.hot", "continue") not in driver.faults, "not 20 s without a break"

    driver.run(37.0, **ROLLING)
    assert driver.faults[-1] == ("motor.hot", "continue")


def test_one_dead_wheel_is_a_fault_and_no_failed_command(drive):
    driver = driving(drive)
    turning = {f"theta_{n}": 3.0 if n % 2 else -3.0 for n in (1, 2, 4, 5, 6)}

    driver.run(2.5, **turning)

    assert driver.statuses[-1] == ("DriveForward", "done")
    assert driver.faults == [("wheel.dead", "continue")]
    assert driver.of(fx.Fault)[0].message == "wheel 3 is driven and does not turn"


@pytest.mark.parametrize(
    ("states", "rad_s", "seen"),
    [({"Grip": "Loose"}, 3.0, "rolls"), ({"Grip": "BothHeld"}, 12.0, "falling")],
)
def test_belief_in_a_hold_ends_where_only_the_wheels_show_the_fall(drive, states, rad_s, seen):
    """The newt has no accelerometer."""
    driver = drive(IDLE, NEWT, states=states)
    driver.run(0.5)
    ways = {"roll_a": rad_s, "roll_b": -rad_s, "roll_c": rad_s, "roll_d": -rad_s}
    driver.run(1.0, every=0.05, **ways)
    assert driver.faults[0] == ("robot.fallen", "stop")
    assert seen in driver.of(fx.Fault)[0].message


def test_free_fall_cannot_be_caught(drive):
    driver = drive(
        f"on_fault: [{{fault: robot.stuck, then: continue}}]\n{IDLE}", states=REAR_CLAMPED
    )
    driver.run(0.5)
    driver.signals["acc_z"] = 0.5

    driver.run(0.8)
    assert driver.faults == [("robot.fallen", "stop")]

    driver.run(1.5)
    assert set(driver.faults) == {("robot.fallen", "stop")}, "by a second rule too"


@pytest.mark.parametrize("code", ["firmware.reset", "link.interrupted"])
def test_after_a_reset_nothing_is_known_and_counters_that_begin_at_zero_are_no_motion(drive, code):
    driver = drive(HANDLED.replace("wheel.dead]", "wheel.dead, firmware.reset, link.interrupted]"))
    driver.until_waiting("a")
    driver.run(driver.now + 3.0, **ROLLING)
    before_m = driver.engine.signals(driver.state)["odometry"]

    driver.give(ev.FaultReport(code, "it is back"))
    known = driver.engine.signals(driver.state)
    assert math.isnan(known["theta_1"])
    assert known["odometry"] == before_m

    for number in range(1, 7):
        driver.signals[f"theta_{number}"] = 0.0
    driver.run(driver.now + 0.9)

    assert driver.faults == [(code, "continue")]
    assert driver.engine.signals(driver.state)["odometry"] == pytest.approx(before_m)
    assert before_m > 0.1


# --- silent boards ------------------------------------------------------------------------------

ALL_LIKE_IT = f"on_fault: [{{fault: sensor.silent, then: continue}}]\n{IDLE}"


def report_all_but(driver, board: int, seconds: float, *, one_in: int = 1) -> None:
    """Time passes in which every other board's reports come, one in so many."""
    end = driver.now + seconds
    period_s = driver.robot.link.period_s * one_in
    while driver.now < end and not driver.ended:
        driver.now += period_s
        for each in driver.robot.boards:
            if each != board:
                driver.report(each)
        driver.tick(driver.now)


@pytest.mark.parametrize(("one_in", "found_after_s"), [(1, 1.0), (2, 1.9), (4, 4.5)])
def test_a_silent_board_is_found_later_where_reports_are_lost(drive, one_in, found_after_s):
    driver = drive(ALL_LIKE_IT, doubting=True)
    silent = next(iter(driver.robot.boards))
    report_all_but(driver, -1, 30.0, one_in=one_in)
    assert driver.faults == []
    last_s = driver.now

    report_all_but(driver, silent, found_after_s - 0.8, one_in=one_in)
    assert driver.faults == []
    while not driver.faults:
        report_all_but(driver, silent, 0.1, one_in=one_in)

    assert driver.faults == [("sensor.silent", "continue")]
    assert driver.now - last_s < found_after_s + 0.8


def test_where_all_boards_stop_the_first_of_them_is_not_blamed(drive):
    driver = drive(ALL_LIKE_IT, doubting=True)
    boards = list(driver.robot.boards)
    report_all_but(driver, -1, 1.0)
    driver.now += 0.4
    for board in boards[1:]:  # the first one's last report is older
        driver.report(board)
    while not driver.ended and not driver.faults:
        driver.tick(driver.now + 0.1)

    assert driver.faults == [("link.silent", "stop")]


def without_board(driver, board: int, until: float) -> None:
    """Every other board reports, ten times a second."""
    others = [each for each in driver.robot.boards if each != board]
    while driver.now < until - 1e-9:
        driver.now += 0.1
        for each in others:
            driver.report(each)
        if driver.wake_at <= driver.now:
            driver.tick(driver.now)


def test_a_board_that_is_silent_again_is_reported_again(drive):
    handled = "on_fault: [{fault: sensor.silent, then: continue}]\n"
    driver = drive(handled + IDLE, states=BOTH_CLAMPED)
    driver.report_all(0.1)
    without_board(driver, 22, 2.0)
    assert driver.faults == [("sensor.silent", "continue")]

    driver.report_all()
    without_board(driver, 22, driver.now + 2.0)

    assert driver.faults == [("sensor.silent", "continue")] * 2


@pytest.mark.parametrize("code", ["firmware.reset", "link.interrupted"])
def test_each_board_has_its_full_time_to_report_after_a_silence_that_ended(drive, code):
    driver = drive(f"on_fault: [{{fault: {code}, then: continue}}]\n" + IDLE, doubting=True)
    report_all_but(driver, -1, 1.0)
    silent_after_s = driver.robot.link.silent_after_s
    back_s = driver.now + 3.0 * silent_after_s
    driver.give(ev.FaultReport(code, "it is back"), back_s)

    driver.tick(back_s + 0.8 * silent_after_s)
    assert driver.faults == [(code, "continue")]

    while len(driver.faults) < 2:
        driver.tick(driver.now + 0.1 * silent_after_s)
    assert driver.faults[-1] == ("link.silent", "stop")
    assert driver.now < back_s + 1.3 * silent_after_s


def test_a_fault_rule_still_sees_the_detector_while_a_pause_has_stopped_the_wheels(drive, tmp_path):
    rule = ("when: amps_a > 280 mA\n    held: 10 s", "when: detector == near\n    held: 0.1 s")
    driven = {"Grip": "BothHeld", "Crawl": "Ahead", "Lamp": "Dark"}
    driver = drive(IDLE, changed_newt(tmp_path, rule), states=driven)
    driver.give(ev.Pause())
    driver.accept()
    driver.give(ev.DetectorWord("near", 1.0))

    driver.run(driver.now + 0.5)

    assert driver.faults == [("motor.hot", "stop")]


def test_a_fault_rule_still_sees_the_states_that_drive_no_wheel(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.give(ev.Pause())
    driver.signals |= {"gamma_1": math.radians(148), "acc_z": 9.81}

    driver.run(3.0)

    assert driver.faults == [("clamp.lost", "stop")], "the clamp is commanded during a pause too"


OPENED = math.radians(119)
"""Of gamma_1: nearer to its end stop than a clamp in a pipe can be."""

FRONT_LOST = "the front has opened nearly to its end stop, there is no wall"
LOSING = f"on_fault: [{{fault: clamp.lost, then: continue}}]\n{IDLE}"


def test_a_clamp_that_a_fault_denies_is_confirmed_no_more(drive):
    driver = drive(LOSING, states=BOTH_CLAMPED)
    driver.show(gamma_1=math.radians(-100), gamma_4=math.radians(-100))
    assert driver.unconfirmed == set()

    driver.signals["gamma_1"] = -OPENED
    driver.run(driver.now + 1.5)

    assert driver.faults == [("clamp.lost", "continue")]
    assert "BendingState" in driver.unconfirmed
    command(driver, "RelaxRear")
    assert driver.last_status.status == "refused"
    assert "the last confirmed clamp (rear)" in driver.last_status.reason


@pytest.mark.parametrize(
    ("message", "denied"),
    [
        (FRONT_LOST, True),
        ("somebody says so", False),  # no rule says which part it is
    ],
)
def test_a_report_in_the_words_of_a_rule_denies_what_that_rule_denies(drive, message, denied):
    driver = drive(LOSING, states=BOTH_CLAMPED)
    driver.show(gamma_1=math.radians(-100), gamma_4=math.radians(-100))

    driver.give(ev.FaultReport("clamp.lost", message))

    of = ("front",) if denied else ()
    assert driver.of(fx.Fault) == [fx.Fault("clamp.lost", message, "continue", of)]
    command(driver, "RelaxRear")
    assert (driver.last_status.status == "refused") == denied


def test_a_clamp_is_not_confirmed_while_the_fault_that_denies_it_lasts(drive):
    driver = drive(LOSING, states=BOTH_CLAMPED)
    driver.show(gamma_1=-OPENED, gamma_4=math.radians(-100))
    driver.run(driver.now + 1.5)

    command(driver, "ClampFront")
    for _ in range(30):
        driver.obey()
    assert ("ClampFront", "accepted") in driver.statuses
    assert ("ClampFront", "done") not in driver.statuses

    driver.signals["gamma_1"] = math.radians(-100)
    driver.until_done("ClampFront")

    assert driver.unconfirmed == set()


CAUGHT = """
on_fault: [{fault: clamp.lost, go: rescue}]
start: a
phases:
  a: {do: [DriveForward], wait: [{operator: x, go: e}], within: {time: 1 h, go: e}}
  rescue: {do: [{command: Brake, unneeded: skip}, ClampRear], go: e}
ends: {e: {succeed: "After {cause}"}}
"""


def test_a_fault_that_denies_the_only_clamp_before_driving_is_accepted_is_handled(drive):
    """The rule was asked before the array was sent, and the wheels stop before the handler."""
    states = {"BendingState": "FrontClampedRearBending", "FrontWheelsState": "Fixed"}
    driver = drive(CAUGHT, states=states)
    while ("DriveForward", "sent") not in driver.statuses:
        driver.obey()

    driver.give(ev.FaultReport("clamp.lost", FRONT_LOST))
    driver.accept()
    driver.until_done("ClampRear")

    assert driver.faults == [("clamp.lost", "rescue")]


def test_a_fault_that_denies_the_only_clamp_while_wheels_are_driven_is_handled(drive):
    """The rule against driving without a clamp ended the mission before the wheels were stopped."""
    states = {"BendingState": "FrontClampedRearBending", "FrontWheelsState": "Fixed"}
    driver = drive(CAUGHT, states=states)
    driver.until_waiting("a")

    driver.signals["gamma_1"] = -OPENED
    driver.until(lambda seen: seen.faults)
    assert driver.faults == [("clamp.lost", "rescue")]
    driver.until_done("ClampRear")

    assert driver.faults == [("clamp.lost", "rescue")]
    assert driver.statuses.count(("Brake", "done")) == 1


def test_what_lasts_is_told_again_only_if_it_was_not_seen_for_a_while(drive):
    def silent(board: int) -> None:
        until = driver.now + 1.5
        while driver.now < until:
            driver.now += 0.1
            for each in driver.robot.boards:
                if each != board:
                    driver.report(each)

    driver = driving(drive)
    driver.signals["bend_current_1"] = 0.3
    driver.run(25.0, **ROLLING)
    hot = ("motor.hot", "continue")
    assert driver.faults.count(hot) == 1

    silent(next(board for board in driver.robot.boards if board != 22))
    driver.run(50.0, **ROLLING)
    assert driver.faults.count(hot) == 1

    silent(22)
    driver.run(80.0, **ROLLING)
    assert driver.faults.count(hot) == 2


class TestLooking:
    """What one frame, or a silence, shows, without an engine around it."""

    @pytest.fixture
    def driver(self, drive):
        driver = drive(IDLE, states=BOTH_CLAMPED)
        driver.run(1.0)
        return driver

    @staticmethod
    def words(driver) -> tuple[str | None, ...]:
        return (*driver.states.values(), *(None for _ in OUTSIDE))

    def seen(self, driver, known: FaultState, now: float, doubted: bool = False, **signals: float):
        """Look at the board of wheel 1, whose signals show this."""
        names = driver.robot.vocabulary.numbers
        board = next(
            each
            for each in driver.robot.boards.values()
            if names.index("theta_1") in each.number_set
        )
        numbers = list(driver.state.sensing.numbers)
        for name, value in signals.items():
            numbers[names.index(name)] = value
        sensing = driver.state.sensing._replace(numbers=tuple(numbers))
        if doubted:
            records = list(sensing.records)
            of_it = frozenset(names.index(name) for name in signals)
            records[board.position] = records[board.position]._replace(doubted=of_it)
            sensing = sensing._replace(records=tuple(records))
        found = safety.look(driver.robot, known, board, sensing, self.words(driver), now)
        return (*found, board)

    def test_a_channel_that_loses_its_value_again_is_reported_again(self, driver):
        known = safety.no_faults(driver.robot)
        told = []
        for turn, theta in enumerate((0.0, math.nan, math.nan, 0.0, math.nan)):
            known, found, _ = self.seen(driver, known, float(turn), theta_1=theta)
            told.append([each.message for each in found])

        assert told == [[], ["theta_1 has no value"], [], [], ["theta_1 has no value"]]

    def test_a_value_that_is_doubted_is_not_missing(self, driver):
        known = safety.no_faults(driver.robot)

        assert self.seen(driver, known, 1.0, theta_1=math.nan)[1]
        assert self.seen(driver, known, 1.0, doubted=True, theta_1=math.nan)[1] == ()

    def test_a_board_that_reports_is_silent_no_more(self, driver):
        known = safety.no_faults(driver.robot)
        *_, board = self.seen(driver, known, 1.0)
        silent = known._replace(silent=frozenset({board.position, 99}))

        assert self.seen(driver, silent, 1.0)[:2] == (known._replace(silent=frozenset({99})), ())
        assert self.seen(driver, known, 1.0)[0] is known
        blind, _, _ = self.seen(driver, silent, 1.0, theta_1=math.nan)
        assert blind.silent == {99}

    def test_where_no_board_reports_that_is_said_once(self, driver):
        sensing, known = driver.state.sensing, safety.no_faults(driver.robot)
        now = max(sensing.heard_s) + driver.robot.link.silent_after_s

        known, found = safety.listen(driver.robot, known, sensing, now)
        assert [each.code for each in found] == ["link.silent"]
        assert safety.listen(driver.robot, known, sensing, now + 1.0) == (known, ())

    @staticmethod
    def ruled(driver, *answers: bool | None):
        """The robot with rules whose conditions are true, false or unknown, and its words."""
        words, numbers = TestLooking.words(driver), driver.state.sensing.numbers

        def rule(answer: bool | None) -> SimpleNamespace:
            def evaluate(*given: object) -> bool | None:
                assert given == (numbers, words)
                return answer

            return SimpleNamespace(when=SimpleNamespace(evaluate=evaluate))

        return replace(driver.robot, faults=tuple(map(rule, answers))), words

    def test_a_rule_that_holds_keeps_its_time_and_one_that_nobody_sees_begins_again(self, driver):
        robot, words = self.ruled(driver, True, None, False, True)
        known = FaultState((3.0, 3.0, 3.0, math.nan), frozenset({0, 1, 2}))

        after = safety.unsettle(robot, known, driver.state.sensing, words)

        assert after.since[0] == 3.0
        assert all(map(math.isnan, after.since[1:]))
        assert after.raised == {0}

    def test_a_rule_is_over_when_its_condition_is_not_seen_any_more(self, driver):
        robot, words = self.ruled(driver, False, None)
        board = replace(next(iter(robot.boards.values())), faults=(0, 1))
        known = FaultState((3.0, 3.0), frozenset({0, 1}))

        after, found = safety.look(robot, known, board, driver.state.sensing, words, 9.0)

        assert found == ()
        assert all(map(math.isnan, after.since))
        assert after.raised == frozenset()

    def listened(self, driver, known: FaultState, now: float, heard_s: float, others_s: float):
        """Listen at this time: board 0 was heard last at one time and the others at another."""
        robot = replace(driver.robot, link=replace(driver.robot.link, silent_after_s=1.0))
        times = [others_s] * len(driver.state.sensing.heard_s)
        times[0] = heard_s
        sensing = driver.state.sensing._replace(heard_s=tuple(times), loss=0.0)
        return safety.listen(robot, known, sensing, now)

    @pytest.mark.parametrize("begun_s", [0.0, 60.0])
    def test_belief_in_a_line_needs_reports_also_where_a_run_begins_late(self, driver, begun_s):
        robot = replace(driver.robot, link=replace(driver.robot.link, period_s=0.1))
        now, others = begun_s + 1.3, len(robot.boards) - 1
        sensing = driver.state.sensing._replace(heard_s=(begun_s, *(now,) * others), loss=0.3)

        begun = driver.engine.start(begun_s)[0].faults
        assert safety.no_faults(robot).listening_s == 0.0
        for known, silent in ((begun, 0), (safety.no_faults(robot, begun_s - 60.0), 1)):
            assert len(safety.listen(robot, known, sensing, now)[1]) == silent

    @pytest.mark.parametrize(("now", "silent"), [(11.0, True), (10.99, False)])
    def test_the_link_is_silent_once_no_board_has_reported_for_its_time(self, driver, now, silent):
        known = safety.no_faults(driver.robot)

        after, found = self.listened(driver, known, now, 10.0, 10.0)

        assert [each.code for each in found] == ["link.silent"] * silent
        assert bool(after.silent) == silent

    @pytest.mark.parametrize(("now", "silent"), [(10.4, True), (10.5, False), (10.9, False)])
    def test_a_single_board_is_judged_only_while_others_report(self, driver, now, silent):
        known = safety.no_faults(driver.robot)

        after, found = self.listened(driver, known, now, 5.0, 10.0)

        board = next(each for each in driver.robot.boards.values() if each.position == 0)
        assert [each.of for each in found] == [(board.name,)] * silent
        assert all(each.message.startswith(f"board {board.id} (") for each in found)
        assert after.silent == ({0} if silent else set())
        if silent:
            assert self.listened(driver, after, now, 5.0, 10.0) == (after, ())

    def test_a_single_board_is_silent_from_its_limit_on(self, driver):
        known = safety.no_faults(driver.robot)
        limit_s = silent_limit_s(replace(driver.robot.link, silent_after_s=1.0), 0.0)
        heard_s = 10.0 - limit_s

        assert self.listened(driver, known, 10.0, heard_s, 10.0)[1]
        assert self.listened(driver, known, 10.0, heard_s + 0.01, 10.0)[1] == ()

    @pytest.mark.parametrize(("alphabet", "silent"), [(10, False), (9, True)])
    def test_a_single_board_may_be_silent_for_longer_before_the_line_is_known(
        self, driver, alphabet, silent
    ):
        robot = replace(driver.robot, link=replace(driver.robot.link, period_s=0.1))
        times = [0.6] * len(driver.state.sensing.heard_s)
        times[0] = 0.0
        sensing = driver.state.sensing._replace(heard_s=tuple(times), loss=0.2)
        known = safety.no_faults(driver.robot)

        _, found = safety.listen(robot, known, sensing, 1.0, alphabet)

        assert [each.code for each in found] == ["sensor.silent"] * silent

    def test_a_report_may_say_what_it_is_a_fault_of(self, driver):
        report = ev.FaultReport("something.else", "said", of=("wheel_3",))

        assert FoundFault.reported(driver.robot, report).of == ("wheel_3",)

    @pytest.mark.parametrize("odometry", [0, 1])
    def test_a_new_connection_keeps_the_odometry_and_nothing_else(self, driver, odometry):
        robot = replace(driver.robot, odometry=odometry)
        sensing = driver.state.sensing
        numbers = list(sensing.numbers)
        numbers[odometry] = 0.7
        distance = sensing.distance._replace(running=True)
        sensing = sensing._replace(numbers=tuple(numbers), connection=4, distance=distance)

        after = safety.start_again(robot, sensing, 20.0, 2.0)

        assert after.numbers[odometry] == 0.7
        assert all(math.isnan(value) for at, value in enumerate(after.numbers) if at != odometry)
        assert after.connection == 5
        assert set(after.heard_s) == {20.0}
        assert after.checked_s == 20.0
        assert after.distance == unheard(robot, sensing, 20.0, 2.0)

    def test_a_robot_without_odometry_keeps_nothing(self, driver):
        robot = replace(driver.robot, odometry=-1)

        after = safety.start_again(robot, driver.state.sensing, 20.0, 2.0)

        assert all(map(math.isnan, after.numbers))

    def test_a_report_that_no_rule_of_the_robot_knows_can_be_caught(self, driver):
        report = ev.FaultReport("something.else", "said")

        assert FoundFault.reported(driver.robot, report) == FoundFault(
            "something.else", "said", True
        )

    def test_a_built_in_fault_has_its_code_its_message_and_its_owner(self):
        found = FoundFault.built_in(BuiltInFault.SENSOR_SILENT, "it is silent", "wheel_3")

        assert found == FoundFault("sensor.silent", "it is silent", True, frozenset(), ("wheel_3",))
