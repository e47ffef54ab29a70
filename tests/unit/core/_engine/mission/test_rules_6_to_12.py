"""The twelve rules of the mission language (docs/missions.md), each by name: 6 to 12."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from driving import BOTH_CLAMPED, DRIVING_FORWARD, PIRATE, Driver, driver_of, write_mission

from pirate_sm.core import effects as fx
from pirate_sm.core._loading.mission.loader import load_mission
from pirate_sm.core._loading.problems import LoadError
from pirate_sm.core._model import events as ev

CLOSE = ev.DetectorWord("close", 5.0)


# --- 6. Conditions at every input and deadline; the order of a tie is in test_order.py


def test_rule_6_every_input_is_looked_at(drive):
    driver = drive("""
start: a
phases:
  a: {wait: [{when: segment == Joint, go: e}], within: {time: 5 s, go: e}}
ends: {e: {succeed: ok}}
""")
    driver.give(ev.EnvironmentReport("Joint", 0.0, 0.0, math.nan), 0.5)

    assert driver.ended.end == "e"


def test_rule_6_the_time_to_wake_is_that_of_the_next_deadline(drive):
    driver = drive(
        """
start: a
phases:
  a:
    wait: [{when: detector == close, held: 700 ms, go: e}, {after: 3 s, go: e}]
    within: {time: 5 s, go: e}
ends: {e: {succeed: ok}}
""",
        nominal=True,
    )
    assert driver.wake_at == 3.0
    driver.give(CLOSE, 1.0)
    assert driver.wake_at == pytest.approx(1.7)


# --- 5 and 6. Deadlines cannot follow each other without end

TO_AND_FRO = """
start: a
phases:
  a: {wait: [{after: 16 ms, go: b}]}
  b: {wait: [{after: 16 ms, go: a}]}
ends: {e: {succeed: ok}}
"""


def phases_until_it_ends(driver, limit_s: float) -> int:
    while driver.of(fx.Ended) == [] and driver.wake_at < limit_s:
        driver.give(ev.Tick(), driver.wake_at)
    return len(driver.of(fx.PhaseChange))


def test_phases_that_follow_each_other_faster_than_sensors_speak_are_a_fault(tmp_path):
    """Two phases with `after: 1 us` took 41 s of computing for 7.5 s of their time."""
    loaded = load_mission(write_mission(tmp_path, TO_AND_FRO, PIRATE))
    program = replace(loaded.program, most_phases=50)
    driver = Driver(loaded.robot, program, nominal=True)

    assert phases_until_it_ends(driver, 10.0) == 51
    assert driver.of(fx.Fault)[0].code == "mission.runaway"
    assert (driver.ended.outcome, driver.now) == ("fault", pytest.approx(50 * 0.016))


def test_phases_that_take_a_bus_cycle_each_may_go_on_for_ever(drive):
    driver = drive(TO_AND_FRO, nominal=True)

    assert phases_until_it_ends(driver, 5.0) > 300
    assert driver.of(fx.Fault) == []


# --- 7. held counts from the sample that made the condition true

HELD = """
start: a
phases:
  a:
    wait: [{when: gamma_1 > 10 deg, held: 1 s, go: e}]
    within: {time: 1 min, go: late}
ends: {e: {succeed: ok}, late: {fail: late}}
on_fault: [{fault: sensor.silent, then: continue}]
"""


def seen(driver, at: float, angle_deg: float) -> None:
    driver.signals["gamma_1"] = math.radians(angle_deg)
    driver.report_all(at)


def test_rule_7_held_counts_from_the_sample_that_made_it_true(drive):
    driver = drive(HELD)
    seen(driver, 0.2, 5)
    seen(driver, 0.4, 15)
    seen(driver, 1.3, 15)
    assert driver.ended is None

    driver.tick(1.4)

    assert driver.ended.end == "e"


@pytest.mark.parametrize("other", [5.0, math.nan])
def test_rule_7_false_or_unknown_clears_it(drive, other):
    driver = drive(HELD)
    seen(driver, 0.2, 15)
    seen(driver, 1.0, other)
    seen(driver, 1.1, 15)
    seen(driver, 2.0, 15)
    assert driver.ended is None

    driver.tick(2.1)

    assert driver.ended.end == "e"


# --- 8. A stale, unfitted or NaN signal is unknown, and unknown never fires


@pytest.mark.parametrize(
    "condition",
    ["gamma_1 > 10 deg", "not (gamma_1 > 10 deg)", "gamma_1 > 0 deg or gamma_1 <= 0 deg"],
)
def test_rule_8_unknown_never_fires(drive, condition):
    driver = drive(f"""
start: a
phases:
  a: {{wait: [{{when: "{condition}", go: e}}], within: {{time: 900 ms, go: late}}}}
ends: {{e: {{succeed: ok}}, late: {{fail: late}}}}
""")
    driver.tick(0.5)
    driver.give(CLOSE, 0.6)
    assert driver.ended is None
    driver.tick(0.9)

    assert driver.ended.end == "late"


def test_rule_8_a_signal_that_goes_stale_stops_holding(drive):
    driver = drive(HELD)
    seen(driver, 0.2, 15)
    driver.give(CLOSE, 0.6)
    driver.tick(0.75)  # 0.5 s after the last frame it is stale
    driver.report(23, 0.9)
    driver.report(24, 1.3)

    assert driver.ended is None


def test_rule_8_an_unknown_if_is_not_taken_and_says_so(drive):
    driver = drive("""
start: a
phases:
  a:
    do:
      - {log: turned, if: gamma_1 > 0 deg}
      - choose: [{if: not (gamma_1 > 0 deg), do: [{log: not turned}]}]
        else: [{log: who knows}]
    go: e
ends: {e: {succeed: ok}}
""")
    logs = driver.messages
    assert logs[1:] != []
    assert "is unknown, not taken" in logs[0]
    assert "is unknown, not taken" in logs[1]
    assert logs[2] == "who knows"


def test_rule_8_what_is_known_decides_where_it_can(drive):
    driver = drive("""
start: a
phases:
  a: {do: [{log: yes, if: gamma_1 > 0 deg or LightingState == Off}], go: e}
ends: {e: {succeed: ok}}
""")
    assert driver.messages == ["yes"]


# --- 9. The detector's word is a latched level with a time of validity

DETECTING = """
start: a
phases:
  a: {do: [ClampFront], wait: [{when: detector == close, go: e}], within: {time: 1 min, go: late}}
ends: {e: {succeed: ok}, late: {fail: late}}
"""


def test_rule_9_a_word_said_before_the_wait_fires_when_it_is_armed(drive):
    driver = drive(DETECTING)
    driver.give(CLOSE, 0.1)

    driver.until(lambda d: d.state.mission.ending)

    assert driver.fired == ["e"]


def test_rule_9_a_word_does_not_hold_beyond_its_validity(drive):
    driver = drive(DETECTING)
    driver.give(ev.DetectorWord("close", 0.3), 0.1)
    driver.run(2.0)

    driver.until_waiting("a")

    assert driver.fired == []


def test_rule_9_another_word_takes_its_place(drive):
    driver = drive(DETECTING)
    driver.give(CLOSE, 0.1)
    driver.give(ev.DetectorWord("in", 5.0), 0.2)

    driver.until_waiting("a")

    assert driver.fired == []
    assert [word.word for word in driver.of(fx.Detected)] == ["close", "in"]


def test_rule_9_the_same_word_again_renews_its_validity(drive):
    driver = drive(DETECTING)
    driver.give(ev.DetectorWord("close", 0.3), 0.1)
    driver.give(ev.DetectorWord("close", 5.0), 0.2)
    driver.run(2.0)

    driver.until(lambda d: d.state.mission.ending)

    assert driver.fired == ["e"]
    assert len(driver.of(fx.Detected)) == 1


def test_rule_9_a_shorter_validity_is_woken_for(drive):
    driver = drive(DETECTING, nominal=True)
    driver.give(ev.DetectorWord("close", 5.0), 0.1)

    effects = driver.give(ev.DetectorWord("close", 0.3), 0.2)

    assert fx.WakeAt(0.5) in effects


def test_rule_9_a_word_that_the_robot_does_not_know_is_logged(drive):
    driver = drive(DETECTING)
    driver.give(ev.DetectorWord("beware", 5.0), 0.1)

    assert driver.messages == ["the detector said 'beware', an unknown word"]


# --- 10. A fault's go acts when the array is resolved and the wheels are stopped: test_faults.py


def test_rule_10_the_wheels_stand_before_the_handler_begins(drive):
    driver = drive("""
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
on_fault: [{fault: robot.stuck, go: rescue}]
start: a
phases:
  a: {do: [DriveForward], wait: [{operator: x, go: e}], within: {time: 1 h, go: e}}
  rescue: {do: [{log: rescuing}], go: e}
ends: {e: {succeed: ok}}
""")
    driver.until_waiting("a")
    assert driver.nonzero["wheel_1"] == 1

    driver.give(ev.FaultReport("robot.stuck", "it does not move"))
    assert driver.faults == [("robot.stuck", "rescue")]
    assert driver.array["wheel_1"] == 0
    assert driver.phases == ["a"]

    driver.accept()
    assert driver.phases == ["a", "rescue"]


# --- 11. Every end performs the safe stop; {cause} names step, place and reason


def test_rule_11_every_end_stops_the_wheels_and_holds_the_clamps(drive):
    driver = drive("""
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
start: a
phases: {a: {do: [DriveForward], go: e}}
ends: {e: {succeed: ok}}
""")
    driver.until_done("DriveForward")

    assert driver.ended is None, "the fate of the safe array is awaited"
    assert driver.nonzero == pytest.approx(
        {"bend_1": -0.7, "bend_2": 0.7, "bend_3": -0.7, "bend_4": 0.7}
    )
    driver.accept()
    assert driver.ended == fx.Ended("succeeded", "ok", "e")


def test_rule_11_the_cause_names_step_place_and_reason(drive):
    driver = drive("""start: a
on_failure: failed
phases: {a: {do: [{command: ClampFront, timeout: 2 s}], go: e}}
ends: {e: {succeed: ok}, failed: {fail: "Because {cause}"}}
""")
    driver.accept()
    driver.run(2.0)
    driver.accept()

    message = driver.ended.message
    assert message.startswith("Because ClampFront (")
    assert "m.yaml:6:19" in message
    assert "not done within 2 s because " in message


# --- 12. Numbers carry units


@pytest.mark.parametrize(
    ("phase", "message"),
    [
        ("do: [{command: Brake, timeout: 5}], go: e", "without a unit"),
        ("do: [{command: Brake, timeout: 5 mm}], go: e", "a duration"),
        ("do: [{command: Brake, retry: 2 s}], go: e", "expected a count"),
        ("wait: [{when: gamma_1 > 90, go: e}], within: {time: 1 s, go: e}", "needs a unit"),
        ("wait: [{when: gamma_1 > 90 mm, go: e}], within: {time: 1 s, go: e}", "cannot compare"),
    ],
)
def test_rule_12_a_number_without_its_unit_is_refused(tmp_path, phase, message):
    body = f"start: a\nphases: {{a: {{{phase}}}}}\nends: {{e: {{succeed: ok}}}}\n"

    with pytest.raises(LoadError, match=message):
        driver_of(write_mission(tmp_path, body))


def test_the_states_of_a_start_can_be_declared_from_outside(drive):
    for states in (BOTH_CLAMPED, DRIVING_FORWARD):
        driver = drive(
            "start: a\nphases: {a: {wait: [{after: 1 s, go: e}]}}\nends: {e: {succeed: ok}}\n",
            states=states,
        )
        assert states.items() <= driver.states.items()
