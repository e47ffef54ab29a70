"""The twelve rules of the mission language (docs/missions.md), each by name: 1 to 5."""

from __future__ import annotations

import pytest
from driving import driver_of, write_mission

from pirate_sm.core import effects as fx
from pirate_sm.core._loading.problems import LoadError
from pirate_sm.core._model import events as ev

# --- 1. Steps run one after the other, each awaited until it is done


def test_rule_1_a_step_is_awaited_until_it_is_done(drive):
    driver = drive("""
start: a
phases:
  a: {do: [ClampFront, {log: clamped}, ToggleLighting], go: e}
ends: {e: {succeed: ok}}
""")
    driver.accept()
    driver.run(3.0)
    assert driver.messages == []

    driver.until_done("ToggleLighting")

    assert driver.messages == ["clamped"]
    order = [status for status in driver.statuses if status[1] in ("sent", "done")]
    assert order == [
        ("ClampFront", "sent"),
        ("ClampFront", "done"),
        ("ToggleLighting", "sent"),
        ("ToggleLighting", "done"),
    ]
    assert driver.ended is None
    driver.obey()
    assert driver.ended.outcome == "succeeded"


def test_rule_1_calls_repeats_choices_and_parameters_are_constants_of_a_run(drive, tmp_path):
    write_mission(
        tmp_path,
        """
parameters: {times: {type: count}, who: {type: duration, default: 3 s}}
start: blink
phases:
  blink: {do: [{repeat: {times: $times, do: [ToggleLighting]}}, {log: "after {who}"}], go: e}
ends: {e: {succeed: Blinked}}
""",
        name="blink.yaml",
    )
    driver = drive("""
parameters: {n: {type: count, default: 3}}
start: a
phases:
  a:
    do:
      - choose: [{if: LightingState == On, do: [{log: was on}]}]
        else: [{log: was off}]
      - {call: blink, with: {times: $n}}
      - {log: now on, if: LightingState == On}
      - {log: now off, if: LightingState == Off}
    go: e
ends: {e: {succeed: ok}}
""")
    driver.until(lambda d: d.ended)

    assert driver.statuses.count(("ToggleLighting", "done")) == 3
    assert driver.messages == ["was off", "after 3 s", "blink: Blinked", "now on"]


# --- 2. starts_in is checked at start and at every call


def test_rule_2_a_mission_begins_in_the_states_that_it_names(drive):
    driver = drive("""
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
start: a
phases: {a: {do: [DriveForward], go: e}}
ends: {e: {succeed: ok}}
""")
    assert driver.states == {
        "FrontWheelsState": "Fixed",
        "RearWheelsState": "Fixed",
        "BendingState": "DoubleClamped",
        "RotationState": "Unaligned",
        "LightingState": "Off",
    }
    assert driver.statuses == [("DriveForward", "sent")]


CALLED = """
starts_in: {BendingState: RearClampedFrontRelaxed}
start: a
phases: {a: {do: [ClampFront], go: e}}
ends: {e: {succeed: ok}}
"""


def test_rule_2_a_call_in_other_states_fails_and_says_which(drive, tmp_path):
    write_mission(tmp_path, CALLED, name="called.yaml")
    driver = drive("""
start: a
phases: {a: {do: [ClampFront, {call: called}], go: e}}
ends: {e: {succeed: ok}}
""")
    driver.until(lambda d: d.state.mission.ending)

    message = driver.state.mission.ending.message
    assert message.startswith("mission called (")
    assert message.endswith(
        "cannot begin: BendingState is FrontClampedRearRelaxed, not RearClampedFrontRelaxed"
    )


def test_rule_2_without_starts_in_a_called_mission_wants_the_initial_configuration(drive, tmp_path):
    write_mission(tmp_path, CALLED.partition("\n")[2].partition("\n")[2], name="called.yaml")
    driver = drive("""
start: a
phases: {a: {do: [ToggleLighting, {call: called}], go: e}}
ends: {e: {succeed: ok}}
""")
    driver.until(lambda d: d.state.mission.ending)

    assert "LightingState is On, not Off" in driver.state.mission.ending.message


def test_rule_2_an_unconfirmed_state_is_not_the_state_wanted(drive, tmp_path):
    write_mission(tmp_path, CALLED, name="called.yaml")
    driver = drive("""
start: a
phases:
  a: {do: [{command: ClampRear, timeout: 1 s, on_failure: b}], go: b}
  b: {do: [{call: called}], go: e}
ends: {e: {succeed: ok}}
""")
    driver.accept()
    driver.run(2.0)

    assert "BendingState is RearClampedFrontRelaxed unconfirmed" in (
        driver.state.mission.ending.message
    )


# --- 3. A step ends done or failed


def test_rule_3_unneeded_skip_forgives_only_unneeded(drive):
    driver = drive("""
start: a
phases:
  a:
    do:
      - {command: Brake, unneeded: skip}
      - {command: RelaxRear, unneeded: skip}
      - {command: DriveForward, unneeded: skip}
    go: e
ends: {e: {succeed: ok}}
""")
    assert driver.statuses == [
        ("Brake", "skipped"),
        ("RelaxRear", "skipped"),
        ("DriveForward", "refused"),
    ]
    assert driver.ended.outcome == "failed"
    assert "was refused as impossible" in driver.ended.message


def test_rule_3_a_refused_command_is_a_failure(drive):
    driver = drive("""
start: a
phases: {a: {do: [Brake], go: e}}
ends: {e: {succeed: ok}}
""")
    assert driver.statuses == [("Brake", "refused")]
    assert driver.ended.outcome == "failed"
    assert driver.of(fx.Setpoints) == []


def test_rule_3_a_refusal_is_not_retried(drive):
    driver = drive("""
start: a
phases: {a: {do: [{command: DriveForward, retry: 5}], go: e}}
ends: {e: {succeed: ok}}
""")
    assert driver.statuses == [("DriveForward", "refused")]


# --- 4. A failure goes to the nearest on_failure

FAILING = "{{command: DriveForward{}}}"
ENDS = "ends: {step: {fail: s}, phase: {fail: p}, mission: {fail: m}, e: {succeed: ok}}"


@pytest.mark.parametrize(
    ("step", "phase", "mission", "end"),
    [
        (", on_failure: step", "on_failure: phase,", "on_failure: mission", "step"),
        ("", "on_failure: phase,", "on_failure: mission", "phase"),
        ("", "", "on_failure: mission", "mission"),
        ("", "", "", ""),
    ],
)
def test_rule_4_step_then_phase_then_mission(drive, step, phase, mission, end):
    driver = drive(f"""
{mission}
start: a
phases: {{a: {{{phase} do: [{FAILING.format(step)}], go: e}}}}
{ENDS}
""")
    assert driver.ended.outcome == "failed"
    assert driver.ended.end == end


@pytest.mark.parametrize(
    ("step", "mission", "end"),
    [
        (", on_failure: step", "on_failure: mission", "step"),
        ("", "on_failure: mission", "mission"),
        ("", "", ""),
    ],
)
def test_rule_4_then_the_callers_in_the_same_order(drive, tmp_path, step, mission, end):
    write_mission(
        tmp_path,
        "start: a\nphases: {a: {do: [DriveForward], go: e}}\nends: {e: {succeed: x}}\n",
        name="called.yaml",
    )
    driver = drive(f"""
{mission}
start: a
phases: {{a: {{do: [{{call: called{step}}}], go: e}}}}
{ENDS}
""")
    assert driver.ended.end == end


def test_rule_4_the_phase_that_handles_failures_does_not_handle_its_own(drive):
    driver = drive("""
on_failure: rescue
start: a
phases:
  a: {do: [DriveForward], go: e}
  rescue: {do: [DriveBackward], go: e}
ends: {e: {succeed: ok}}
""")
    assert driver.phases == ["a", "rescue"]
    assert driver.ended.outcome == "failed"
    assert driver.ended.message.startswith("DriveBackward")


def test_rule_4_a_step_may_be_passed_over(drive):
    driver = drive("""
on_failure: rescue
start: a
phases:
  a: {do: [{command: DriveForward, on_failure: continue}, {log: went on}], go: e}
  rescue: {go: e}
ends: {e: {succeed: ok}}
""")
    assert driver.messages[-1] == "went on"
    assert driver.ended.outcome == "succeeded"


def test_rule_4_a_failed_end_of_a_called_mission_is_a_failure_of_the_call(drive, tmp_path):
    write_mission(
        tmp_path,
        "start: a\nphases: {a: {go: bad}}\nends: {bad: {fail: No good}}\n",
        name="called.yaml",
    )
    driver = drive("""
start: a
phases: {a: {do: [{call: called, on_failure: caught}], go: e}}
ends: {e: {succeed: ok}, caught: {fail: "Caught {cause}"}}
""")
    assert driver.ended.end == "caught"
    assert "called: No good" in driver.ended.message


# --- 5. wait arms when do has finished; within counts from then


def test_rule_5_within_counts_from_the_end_of_do(drive):
    driver = drive("""
start: a
phases:
  a:
    do: [ClampFront]
    wait: [{when: detector == close, go: e}]
    within: {time: 5 s, go: late}
ends: {e: {succeed: ok}, late: {fail: "{cause}"}}
""")
    driver.run(3.0)
    driver.until_waiting("a")
    armed = driver.now
    assert driver.of(fx.WaitArmed)[0].deadline_s == pytest.approx(armed + 5)

    driver.run(armed + 4.9)
    assert driver.fired == []
    driver.run(armed + 5.0)

    assert driver.fired == ["within"]
    message = driver.state.mission.ending.message
    assert message.endswith(
        "lasted longer than 5 s: it awaited 'detector == close' (detector is unknown)"
    )


def test_rule_5_a_trigger_does_not_fire_before_the_wait_is_armed(drive):
    driver = drive("""
start: a
phases:
  a:
    do: [ClampFront]
    wait: [{operator: now, go: e}]
    within: {time: 5 s, go: e}
ends: {e: {succeed: ok}}
""")
    driver.give(ev.Answer("now"), 0.1)
    driver.until_waiting("a")
    assert driver.fired == []

    driver.give(ev.Answer("now"))

    assert driver.fired == ["e"]


@pytest.mark.parametrize(
    "phase",
    [
        "wait: [{when: 'true', go: e}]",
        "do: [Brake]",
        "do: [Brake], go: e, within: {time: 5 s, go: e}",
        "wait: [{when: 'true', go: e}], within: {time: 5 s, go: e}, go: e",
    ],
)
def test_rule_5_a_phase_waits_within_a_time_or_goes(tmp_path, phase):
    body = f"start: a\nphases: {{a: {{{phase}}}}}\nends: {{e: {{succeed: ok}}}}\n"
    with pytest.raises(LoadError):
        driver_of(write_mission(tmp_path, body))
