"""Loops that a state owns: when they run, what stops them, and what becomes of their arrays."""

from __future__ import annotations

from dataclasses import replace

import pytest
from driving import IDLE, Driver, command
from rolling_newt import DRIVE, HELD

from pirate_sm.core import effects as fx
from pirate_sm.core._loading.problems import LoadError
from pirate_sm.core._model import events as ev
from pirate_sm.running.recording.format.json_values import state_from_text, state_to_text

WHEELS = ("drive_a", "drive_b", "drive_c", "drive_d")
SLOW = {"roll_a": 2.0, "roll_b": -2.0, "roll_c": 2.0, "roll_d": -2.0}
"""The tracks turn with 2 rad/s, and shall with 3."""
BACK = {name: -rate for name, rate in SLOW.items()}


def accept_all(driver: Driver) -> None:
    while driver.in_flight:
        driver.accept()


def driving(driver: Driver) -> Driver:
    """The mission waits while its tracks are driven, and the newest array is in force."""
    driver.report_all(0.1)
    driver.report_all(0.2)
    assert driver.last_status == fx.CommandStatus("GoAhead", "sent", "", driver.last_status.place)
    driver.accept()
    driver.run(0.5, **SLOW)
    assert driver.last_status.status == "done"
    accept_all(driver)
    return driver


def sent_during(driver: Driver, seconds: float, **turning: float) -> list[fx.Setpoints]:
    """What is sent while boards report and every array is accepted at once."""
    before = len(driver.of(fx.Setpoints))
    until = driver.now + seconds
    while driver.now < until - 1e-9:
        driver.run(driver.now + 0.1, **turning)
        accept_all(driver)
    return driver.of(fx.Setpoints)[before:]


def duties(driver: Driver) -> tuple[float, ...]:
    return tuple(driver.array[name] for name in WHEELS)


def test_tracks_driven_by_hand_at_half_speed_keep_to_half_speed(newt):
    driver = newt()
    driver.give(ev.OperatorCommand("GoAhead", share=0.5))
    assert duties(driver) == pytest.approx((0.3, -0.3, 0.3, -0.3))
    accept_all(driver)

    half = {name: rate * 0.75 for name, rate in SLOW.items()}  # 1.5 of 3 rad/s
    sent_during(driver, 2.0, **half)

    assert duties(driver) == pytest.approx((0.3, -0.3, 0.3, -0.3), abs=0.02)


@pytest.mark.parametrize("share", [float("nan"), -0.1, 1.01])
def test_a_drive_at_an_impossible_speed_is_refused(newt, share):
    driver = newt()
    driver.give(ev.OperatorCommand("GoAhead", share=share))
    assert driver.last_status.status == "refused"
    assert driver.last_status.reason == "impossible: the speed must be 0 to 100 %"


def test_the_first_array_has_the_duty_of_tracks_without_load(newt):
    driver = newt()

    command(driver, "GoAhead")

    assert duties(driver) == pytest.approx((0.6, -0.6, 0.6, -0.6))


def test_in_mirrored_polarity_the_speeds_change_sign(newt):
    driver = newt(f"polarity: mirrored\n{DRIVE}")

    assert duties(driver) == pytest.approx((-0.6, 0.6, -0.6, 0.6))


def test_they_run_during_a_wait(newt):
    driver = driving(newt(DRIVE))
    waiting = driver.of(fx.WaitArmed)

    sent = sent_during(driver, 0.5, **SLOW)

    assert waiting
    assert driver.phases[-1] == "drive"
    sizes = [abs(each.values[0]) for each in sent]
    assert len(sizes) >= 5
    assert sizes == sorted(sizes), "the tracks stay too slow, so they get more and more"
    assert duties(driver)[0] > 0.6


def test_what_nobody_can_hear_is_driven_as_before(newt):
    driver = driving(newt(DRIVE))
    before = duties(driver)
    driver.signals |= dict.fromkeys(SLOW, float("nan"))

    assert sent_during(driver, 0.5) == []
    assert duties(driver) == before


def test_a_command_that_does_not_write_their_slots_lets_them_run(newt):
    driver = driving(newt(DRIVE))
    driver.give(ev.Answer("light"))
    assert driver.array["lamp"] == pytest.approx(0.6)
    accept_all(driver)
    before = duties(driver)

    sent_during(driver, 0.3, **SLOW)

    assert driver.states["Lamp"] == "Lit"
    assert driver.array["lamp"] == pytest.approx(0.6)
    assert duties(driver)[0] > before[0]


def test_they_end_when_another_state_writes_their_slots(newt):
    driver = driving(newt(DRIVE))
    driver.give(ev.Answer("on"))
    assert duties(driver) == (0, 0, 0, 0)
    driver.accept()

    assert sent_during(driver, 1.0, **BACK) == []
    assert driver.states["Crawl"] == "Resting"


def test_nothing_is_streamed_while_the_gate_is_pending(newt):
    driver = newt()
    driver.report_all(0.1)
    command(driver, "GoAhead")
    gate = driver.setpoints

    driver.run(0.6, **BACK)

    assert driver.setpoints == gate
    driver.accept()
    assert driver.state.robot.loops[0].integral == 0, "it has not run before"


def test_a_command_overtakes_the_stream(newt):
    driver = driving(newt(DRIVE))
    driver.run(driver.now + 0.1, **SLOW)
    streamed = driver.setpoints
    assert driver.in_flight

    driver.give(ev.Answer("on"))

    gate = driver.setpoints
    assert gate.setpoint_id == streamed.setpoint_id + 1
    driver.give(ev.SubmitResult(streamed.setpoint_id, "superseded", "newer"))
    assert driver.states["Crawl"] == "Ahead"
    driver.give(ev.SubmitResult(gate.setpoint_id, "accepted"))
    assert driver.states["Crawl"] == "Resting"


def test_a_refused_command_leaves_them_running(newt):
    driver = driving(newt(DRIVE.replace("do: [Rest]", "do: [{command: Rest, retry: 1}]")))
    loops = driver.state.robot.loops
    driver.give(ev.Answer("on"))

    driver.give(ev.SubmitResult(driver.setpoints.setpoint_id, "rejected", "not now"))

    assert [status for _, status in driver.statuses[-2:]] == ["failed", "sent"]
    assert driver.state.robot.flight.before == loops


def test_the_newest_array_wins(newt):
    driver = driving(newt(DRIVE))

    driver.run(driver.now + 0.3, **SLOW)

    numbers = [each.setpoint_id for each in driver.of(fx.Setpoints)]
    assert len(driver.state.robot.overtaken) >= 3, "nobody has waited for a result"
    assert numbers == list(range(1, len(numbers) + 1))
    driver.accept()
    assert driver.state.robot.values == driver.setpoints.values
    assert driver.state.robot.overtaken == ()


def test_what_was_accepted_before_it_was_overtaken_is_in_force(newt):
    driver = driving(newt(DRIVE))
    driver.run(driver.now + 0.2, **SLOW)
    first, *_ = driver.state.robot.overtaken

    driver.give(ev.SubmitResult(first.setpoint_id, "accepted"))

    assert driver.state.robot.values == first.values
    assert driver.state.robot.flight.values == driver.setpoints.values


def test_belief_in_newer_values_outlasts_a_late_result_of_an_older_array(newt):
    driver = driving(newt(DRIVE))
    driver.run(driver.now + 0.3, **SLOW)
    older, newer, newest, *_ = driver.state.robot.overtaken
    driver.give(ev.SubmitResult(newer.setpoint_id, "accepted"))

    driver.give(ev.SubmitResult(older.setpoint_id, "accepted"))

    assert older.values != newer.values
    assert driver.state.robot.values == newer.values
    assert driver.state.robot.overtaken[0] == newest


def test_an_overtaken_array_that_is_refused_leaves_the_others_awaited(newt):
    driver = driving(newt(DRIVE))
    driver.run(driver.now + 0.3, **SLOW)
    older, newer, *others = driver.state.robot.overtaken

    driver.give(ev.SubmitResult(newer.setpoint_id, "rejected", "not now"))

    assert driver.state.robot.overtaken == (older, *others)


def test_an_array_of_unknown_fate_is_followed_by_the_newest(newt):
    driver = driving(newt(DRIVE))
    driver.run(driver.now + 0.1, **SLOW)
    old = driver.setpoints
    driver.accept("unknown")

    driver.run(driver.now + 0.5, **SLOW)

    later = driver.of(fx.Setpoints)[driver.of(fx.Setpoints).index(old) + 1 :]
    assert later
    assert old.setpoint_id not in {each.setpoint_id for each in later}


def test_an_array_of_unknown_fate_is_repeated_where_there_is_none_newer(newt):
    driver = driving(newt(DRIVE))
    driver.report(40)
    driver.run(driver.now + 0.1, **SLOW)
    old = driver.setpoints
    driver.accept("unknown")

    driver.tick(driver.wake_at)

    assert driver.setpoints == old


def test_a_stream_that_is_never_confirmed_is_a_broken_link(newt):
    driver = driving(newt(DRIVE))

    for _ in range(20):
        driver.run(driver.now + 0.1, **SLOW)
        if not driver.ended and not driver.faults:
            driver.accept("unknown")

    assert driver.faults[0] == ("link.no_echo", "stop")


def test_single_arrays_that_are_not_confirmed_are_no_fault(newt):
    driver = driving(newt(DRIVE))

    for number in range(40):
        driver.run(driver.now + 0.1, **SLOW)
        if driver.in_flight:
            driver.accept("accepted" if number % 3 == 0 else "unknown")

    assert driver.faults == []


def test_a_pause_stops_them_and_they_go_on_after_it(newt):
    driver = driving(newt(DRIVE))
    sent_during(driver, 0.3, **SLOW)
    learned, loops = duties(driver), driver.state.robot.loops
    driver.give(ev.Pause())
    assert duties(driver) == (0, 0, 0, 0)
    accept_all(driver)
    assert sent_during(driver, 1.0) == []

    driver.give(ev.Resume())

    assert duties(driver) == learned
    assert driver.state.robot.loops == loops
    accept_all(driver)
    assert sent_during(driver, 0.5, **SLOW), "they run again"


def test_an_operator_who_drives_during_a_pause_drives_with_them(newt):
    driver = newt(DRIVE.replace("start: drive", "start: handle"))
    driver.report_all(0.1)
    driver.give(ev.Pause())
    accept_all(driver)
    command(driver, "GoAhead")
    driver.accept()

    assert sent_during(driver, 0.5, **SLOW)
    assert driver.state.mission.paused


def test_a_fault_that_leads_elsewhere_stops_them_until_a_command_begins_them_anew(newt):
    driver = driving(newt(DRIVE))
    sent_during(driver, 0.3, **SLOW)
    driver.give(ev.FaultReport("motor.hot", "said"))
    assert duties(driver) == (0, 0, 0, 0)
    accept_all(driver)
    assert sent_during(driver, 0.5, **SLOW) == []

    driver.give(ev.Answer("on"))

    assert driver.last_status.name == "GoAhead"
    assert duties(driver) == pytest.approx((0.6, -0.6, 0.6, -0.6)), "without what it had learned"


@pytest.mark.parametrize("event", [ev.Abort("enough"), ev.FaultReport("robot.stuck", "said")])
def test_an_end_stops_them(newt, event):
    driver = driving(newt(DRIVE))
    driver.run(driver.now + 0.1, **SLOW)
    driver.give(event)
    safe = driver.setpoints
    driver.run(driver.now + 0.5, **SLOW)

    assert driver.setpoints == safe
    assert duties(driver) == (0, 0, 0, 0)
    driver.accept()
    assert driver.ended


REST_SOON = "{rule: rest_soon, after: command == GoAhead, expect: command == Rest, within_steps: 1}"


def test_a_command_that_would_break_a_rule_stops_them(newt):
    driver = driving(newt(DRIVE, ("rules:\n", f"rules:\n  - {REST_SOON}\n")))

    driver.give(ev.Answer("light"))

    assert driver.faults == [("rule.violated", "stop")]
    assert duties(driver) == (0, 0, 0, 0)
    safe = driver.setpoints
    driver.run(driver.now + 0.3, **SLOW)
    assert driver.setpoints == safe


def test_in_the_safe_state_a_worm_gets_zero_and_another_motor_its_last_duty(newt):
    engine = newt(DRIVE).engine
    drive_c, drive_d = (
        next(n for n, slot in enumerate(engine.robot.slots) if slot.name == name)
        for name in ("drive_c", "drive_d")
    )
    slots = list(engine.robot.slots)
    slots[drive_c] = replace(slots[drive_c], self_locking=True)
    zero = tuple(slot for slot in engine.robot.safe_zero if slot not in (drive_c, drive_d))
    robot = replace(engine.robot, slots=tuple(slots), safe_zero=zero)
    driver = driving(Driver(robot, engine.program))
    sent_during(driver, 0.3, **SLOW)
    held = duties(driver)[3]

    driver.give(ev.Abort("enough"))

    assert held < -0.6
    assert duties(driver) == (0, 0, 0, held)


SEEKING = (
    ("BothHeld: {fold_neck: -50 %", "BothHeld: {fold_neck: -0.5 rad"),
    (
        "stalled, joints: [neck], loaded: [neck], share: 60 %, at_least: 50 mNm, settled: 1.5 s, "
        "still: 6 deg/s, for: 0.2 s}",
        "reached}",
    ),
)
"""The nose is clamped by a position loop."""


def test_a_position_loop_and_a_velocity_loop_share_their_arrays(newt):
    driver = driving(newt(DRIVE, *SEEKING, states=HELD | {"Grip": "TailHeld"}))
    driver.give(ev.Answer("clamp"))
    driver.accept()
    kinds = [type(each).__name__ for each in driver.state.robot.loops]

    driver.run(driver.now + 0.1, **SLOW)
    shared = driver.setpoints
    driver.run(driver.now + 0.1, **SLOW)

    assert kinds == ["RunningVelocityLoop"] * 4 + ["RunningPositionLoop"]
    assert driver.array["fold_neck"] == pytest.approx(-0.5)
    assert driver.setpoints == shared, "an array of a position loop is awaited"
    driver.accept()
    assert duties(driver)[0] > shared.values[0]
    driver.signals |= {"neck": -0.5}
    driver.run(driver.now + 0.1, **SLOW)
    accept_all(driver)
    assert driver.array["fold_neck"] == 0, "it has ended with its command"
    assert [type(each).__name__ for each in driver.state.robot.loops] == ["RunningVelocityLoop"] * 4
    assert sent_during(driver, 0.3, **SLOW)


def test_its_command_may_be_done_while_the_stream_is_under_way(newt):
    driver = newt(DRIVE)
    driver.report_all(0.1)
    driver.report_all(0.2)
    driver.accept()

    driver.run(0.5, **SLOW)

    assert driver.in_flight
    assert driver.last_status.status == "done"


def test_a_trace_sends_the_first_array_alone(newt):
    driver = newt(DRIVE, nominal=True)

    driver.accept()
    driver.tick(driver.wake_at)

    assert len(driver.of(fx.Setpoints)) == 1


def test_a_state_of_the_engine_with_loops_is_written_without_loss(newt):
    driver = driving(newt(DRIVE))
    driver.run(driver.now + 0.2, **SLOW)

    assert state_from_text(state_to_text(driver.state)) == driver.state


def test_a_speed_that_the_motor_never_reaches_is_a_fault_of_the_profile(newt):
    with pytest.raises(LoadError, match="120 mm/s is more than 'drive_b' reaches, 100 mm/s"):
        newt(IDLE, ("drive_a: 60 mm/s, drive_b: -60 mm/s", "drive_a: 60 mm/s, drive_b: 120 mm/s"))
