"""Steps and missions that choose a control: what is sent, awaited, failed and left behind."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from driving import Driver, command, write_mission
from rolling_newt import BEARING, CONTROLS, SWITCH

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.robot.robot_state import at_rest_in, state_change
from pirate_sm.core._model import events as ev
from pirate_sm.running.recording.format.json_values import state_from_text, state_to_text

BORNE = {"neck_torque": -0.3, "hip_torque": 0.3}
SLOW = {"roll_a": 2.0, "roll_b": -2.0, "roll_c": 2.0, "roll_d": -2.0}
FOLDS = ("fold_neck", "fold_hip")
TRACKS = ("drive_a", "drive_b", "drive_c", "drive_d")


@pytest.fixture
def bearing(newt: Callable[..., Driver]) -> Callable[..., Driver]:
    """Starts an engine on the newt with controls, whose folds bear 200 mNm."""

    def start(body: str = SWITCH, *swaps: tuple[str, str], **options: Any) -> Driver:
        driver = newt(body, BEARING, CONTROLS, *swaps, **options)
        driver.signals |= {"neck_torque": -0.2, "hip_torque": 0.2}
        if not options.get("nominal"):
            driver.report_all(0.05)
            driver.report_all(0.1)
        return driver

    return start


def duties(driver: Driver, slots: tuple[str, ...]) -> tuple[float, ...]:
    return tuple(driver.array[name] for name in slots)


def accept_all(driver: Driver) -> None:
    while driver.in_flight:
        driver.accept()


def sent_during(driver: Driver, seconds: float, **turning: float) -> list[fx.Setpoints]:
    """What is sent while boards report and every array is accepted at once."""
    before, until = len(driver.of(fx.Setpoints)), driver.now + seconds
    while driver.now < until - 1e-9 and not driver.ended:
        driver.run(driver.now + 0.1, **turning)
        accept_all(driver)
    return driver.of(fx.Setpoints)[before:]


def switching(driver: Driver) -> Driver:
    """The mission has come to the step, and its array is accepted."""
    driver.give(ev.Answer("on"))
    driver.accept()
    return driver


def settled(driver: Driver) -> Driver:
    """The joints bear what the control asks of them, and the mission waits."""
    switching(driver)
    driver.signals |= BORNE
    sent_during(driver, 0.2)
    assert driver.of(fx.WaitArmed)[-1].phase == "gentle"
    return driver


def loops(driver: Driver) -> list[str]:
    return [type(each).__name__ for each in driver.state.robot.loops]


def warned(driver: Driver) -> str:
    return "\n".join(each.message for each in driver.of(fx.Log) if each.level == "warning")


# --- what is sent ------------------------------------------------------------------------------


def test_it_sends_one_array_with_the_duties_of_its_loops(bearing):
    driver = bearing()

    driver.give(ev.Answer("on"))

    (array,) = driver.of(fx.Setpoints)
    assert array == driver.setpoints
    winding = 1.2 * 0.1 + 0.2 / 0.8
    assert duties(driver, FOLDS) == pytest.approx((-winding, winding), abs=0.0026)
    assert driver.nonzero.keys() == set(FOLDS)
    assert [each.message for each in driver.of(fx.Log)][-1] == "control gentle"


def test_it_sends_nothing_where_it_changes_nothing(bearing):
    driver = bearing()

    driver.give(ev.Answer("limp"))

    assert driver.of(fx.Setpoints) == []
    assert driver.of(fx.WaitArmed)[-1].phase == "limp"


def test_an_unknown_torque_is_awaited_without_a_current(bearing):
    driver = bearing()
    driver.signals |= {"neck_torque": float("nan")}
    driver.report_all(0.2)

    switching(driver)

    assert driver.array["fold_neck"] == 0
    assert driver.array["fold_hip"] > 0
    driver.signals |= {"hip_torque": 0.3}
    sent_during(driver, 1.0)
    assert driver.of(fx.WaitArmed)[-1].phase == "still"


def test_in_mirrored_polarity_the_torques_change_sign(bearing):
    driver = bearing(f"polarity: mirrored\n{SWITCH}")
    driver.signals |= {"neck_torque": 0.2, "hip_torque": -0.2}
    driver.report_all(0.2)

    driver.give(ev.Answer("on"))

    winding = 1.2 * 0.1 + 0.2 / 0.8
    assert duties(driver, FOLDS) == pytest.approx((winding, -winding), abs=0.0026)


def test_loops_go_on_that_both_controls_have(bearing):
    driver = settled(bearing())
    driver.give(ev.Answer("on"))
    driver.accept()
    sent_during(driver, 0.5, **SLOW)
    folds = [
        each for each in driver.state.robot.loops if type(each).__name__ == "RunningTorqueLoop"
    ]

    driver.give(ev.Answer("on"))

    assert [each for each in driver.state.robot.loops if each in folds] == folds
    assert duties(driver, TRACKS) == pytest.approx((0.9, -0.9, 0.9, -0.9)), "begun anew"


def test_later_commands_are_actuated_by_it(bearing):
    driver = bearing(f"control: swift\n{SWITCH}")
    driver.accept()
    driver.signals |= BORNE
    sent_during(driver, 0.2)

    driver.give(ev.Answer("drive"))

    assert driver.last_status.name == "GoAhead"
    assert duties(driver, TRACKS) == pytest.approx((0.9, -0.9, 0.9, -0.9))


def test_the_usual_control_ends_its_loops(bearing):
    driver = settled(bearing())

    driver.give(ev.Answer("usual"))

    assert duties(driver, FOLDS) == (-0.5, 0.5)
    assert loops(driver) == []
    assert [each.message for each in driver.of(fx.Log)][-1] == "the usual control"


def test_its_loops_run_while_the_mission_waits_and_commands(bearing):
    driver = settled(bearing())
    driver.give(ev.Answer("light"))
    accept_all(driver)
    driver.signals |= {"neck_torque": -0.1}

    sent = sent_during(driver, 0.3)

    assert driver.states["Lamp"] == "Lit"
    assert sent
    assert driver.array["fold_neck"] < 0


def test_a_return_from_a_torque_to_an_angle_seeks_nothing(bearing):
    """What a command brought to an angle stays where it is: no command is under way."""
    driver = bearing(SWITCH, states={"Grip": "Loose"})
    driver.give(ev.Answer("limp"))
    driver.accept()
    assert loops(driver) == ["RunningTorqueLoop", "RunningTorqueLoop"]
    driver.signals |= {"neck_torque": 0.0, "hip_torque": 0.0, "neck": 0.5, "hip": 0.5}
    sent_during(driver, 0.3)

    driver.give(ev.Answer("on"))
    accept_all(driver)

    assert loops(driver) == []
    assert sent_during(driver, 0.5) == []
    assert duties(driver, FOLDS) == (0, 0)


# --- what is awaited ---------------------------------------------------------------------------


def test_it_waits_until_every_joint_bears_its_torque(bearing):
    driver = switching(bearing())
    driver.signals |= {"neck_torque": -0.3}
    sent_during(driver, 1.0)
    assert driver.of(fx.WaitArmed)[-1].phase == "still"

    driver.signals |= BORNE
    sent_during(driver, 0.2)

    assert driver.of(fx.WaitArmed)[-1].phase == "gentle"
    assert duties(driver, FOLDS) == (0, 0), "the worms hold"


def test_a_step_that_is_late_fails(bearing):
    driver = switching(bearing())
    driver.signals |= {"neck_torque": -0.3}

    sent_during(driver, 4.0)

    assert driver.ended is not None
    assert driver.ended.outcome == "failed"
    told = driver.ended.message
    assert told.startswith("control gentle (")
    assert told.endswith("m.yaml:13:10): fold_hip did not bear the torque within 3 s")


def test_a_late_step_leads_where_its_failure_leads(bearing):
    late = SWITCH.replace("timeout: 3 s}", "timeout: 3 s, on_failure: late}")
    driver = switching(bearing(late))

    sent_during(driver, 2.9)
    assert driver.phases[-1] == "gentle"
    sent_during(driver, 0.2)

    assert driver.phases[-1] == "late"
    assert "did not bear the torque" in warned(driver)
    assert loops(driver) == ["RunningTorqueLoop"] * 2, "they go on"


def test_time_alone_wakes_it(bearing):
    driver = switching(bearing(SWITCH.replace("timeout: 3 s}", "timeout: 200 ms}")))

    while driver.state.mission.ending is None:
        driver.tick(driver.wake_at)

    assert driver.now == pytest.approx(0.3)


def test_the_operator_passes_over_it(bearing):
    driver = switching(bearing())

    driver.give(ev.Skip())

    assert driver.of(fx.WaitArmed)[-1].phase == "gentle"
    assert loops(driver) == ["RunningTorqueLoop"] * 2


def test_a_control_step_can_be_skipped_while_its_array_is_in_flight(bearing):
    driver = bearing()
    driver.give(ev.Answer("on"))

    driver.give(ev.Skip())
    driver.accept()

    assert driver.of(fx.WaitArmed)[-1].phase == "gentle"


def test_once_the_time_is_up_no_control_begins(bearing):
    driver = bearing(f"time_limit: 1 s\n{SWITCH}")

    driver.give(ev.Answer("on"), at=1.0)

    assert driver.state.robot.control == 0
    assert driver.state.mission.ending is not None


def test_a_pause_stops_its_loops_and_its_clock(bearing):
    driver = switching(bearing())
    sent_during(driver, 1.0)
    driver.give(ev.Pause())
    accept_all(driver)
    assert duties(driver, FOLDS) == (0, 0)
    assert sent_during(driver, 10.0) == []

    driver.give(ev.Resume())
    accept_all(driver)

    assert loops(driver) == ["RunningTorqueLoop"] * 2
    sent_during(driver, 1.8)
    assert not driver.state.mission.ending
    sent_during(driver, 0.3)
    assert driver.ended is not None


def test_a_step_after_a_pause_is_done_once_the_torques_are_borne(bearing):
    driver = switching(bearing())
    driver.give(ev.Pause())
    accept_all(driver)
    driver.give(ev.Resume())
    accept_all(driver)
    driver.signals |= BORNE

    sent_during(driver, 0.2)

    assert driver.of(fx.WaitArmed)[-1].phase == "gentle"


# --- whole missions ----------------------------------------------------------------------------


def test_a_mission_begins_with_its_control(bearing):
    driver = bearing(f"control: gentle\n{SWITCH}")
    assert driver.phases == []
    driver.accept()
    driver.signals |= BORNE

    sent_during(driver, 0.2)

    assert driver.phases == ["still"]


def test_a_mission_whose_control_is_late_leads_where_its_failures_lead(bearing):
    driver = bearing(f"control: gentle\non_failure: late\n{SWITCH}")
    driver.accept()

    sent_during(driver, 9.8)
    assert driver.phases == []
    sent_during(driver, 0.4)

    assert driver.phases == ["late"]


def test_a_mission_that_is_handed_its_first_phase_takes_its_control(bearing):
    """So it is started at the console: it begins paused, and the operator hands it over."""
    engine = bearing(f"control: gentle\n{SWITCH}", nominal=True).engine
    begun, _ = engine.start(0.0, paused=True)
    change = state_change(engine.robot, begun.robot)

    after, effects = engine.step(begun, ev.GoTo("still", change.states, change.unconfirmed), 1.0)

    assert begun.robot.control == 0
    assert after.robot.control == 1
    assert [each for each in effects if isinstance(each, fx.Setpoints)]


CALLED = """\
control: gentle
starts_in: {Grip: BothHeld}
start: light
phases:
  light: {do: [SwitchLamp], go: lit}
ends: {lit: {succeed: Lit}}
"""


def test_a_called_mission_brings_its_control_and_leaves_it(bearing, tmp_path):
    write_mission(tmp_path, CALLED, tmp_path / "newt", "called.yaml")
    driver = bearing(SWITCH.replace("do: [SwitchLamp]", "do: [{call: called}]").replace(
        "timeout: 3 s}", "timeout: 3 s}, {control: none}"))  # fmt: skip
    settled_until_usual(driver)
    driver.give(ev.Answer("light"))

    driver.accept()
    sent_during(driver, 0.3)

    assert driver.states["Lamp"] == "Lit"
    assert driver.of(fx.WaitArmed)[-1].phase == "light"
    assert loops(driver) == ["RunningTorqueLoop"] * 2


def settled_until_usual(driver: Driver) -> None:
    switching(driver)
    driver.signals |= BORNE
    sent_during(driver, 0.3)
    assert driver.of(fx.WaitArmed)[-1].phase == "gentle"
    assert loops(driver) == []


def test_a_next_mission_begins_with_the_usual_control(bearing):
    driver = settled(bearing())
    driver.give(ev.Abort("enough"))
    accept_all(driver)

    after, _ = driver.engine.start(driver.now, body=driver.state.robot.at_rest())

    assert driver.state.robot.control == 1
    assert after.robot.control == 0


# --- what goes wrong ---------------------------------------------------------------------------


def test_a_refused_array_ends_the_mission(bearing):
    driver = bearing()
    driver.give(ev.Answer("on"))

    driver.accept("rejected", "not now")

    assert driver.faults == [("backend.failed", "stop")]
    assert duties(driver, FOLDS) == (-0.5, 0.5), "what was in force holds on"


def test_an_array_of_unknown_fate_is_repeated(bearing):
    driver = bearing()
    driver.give(ev.Answer("on"))
    array = driver.setpoints
    driver.accept("unknown")

    driver.tick(driver.now + 0.1)

    assert driver.of(fx.Setpoints)[-2:] == [array, array]


def test_an_end_leaves_a_joint_that_locks_itself_without_a_current(bearing):
    driver = switching(bearing())
    assert duties(driver, FOLDS)[0] < 0

    driver.give(ev.Abort("enough"))

    assert duties(driver, FOLDS) == (0, 0)
    driver.accept()
    assert driver.ended


def test_stopped_wheels_stay_stopped_under_another_control(bearing):
    """Wheels that a fault has stopped are driven by a command, not by another control."""
    driver = bearing()
    driver.give(ev.Answer("drive"))
    driver.accept()
    sent_during(driver, 0.5, **SLOW)
    driver.give(ev.FaultReport("motor.hot", "said"))
    accept_all(driver)

    sent_during(driver, 0.3)

    assert driver.phases[-1] == "handle"
    assert driver.state.robot.control == 2
    assert duties(driver, TRACKS) == (0, 0, 0, 0)


@pytest.mark.parametrize(("share", "duty"), [(1.0, 0.9), (0.5, 0.45)])
def test_another_control_keeps_to_the_speed_chosen_for_driving_by_hand(bearing, share, duty):
    driver = paused(bearing())
    driver.give(ev.OperatorCommand("GoAhead", share=share))
    driver.accept()
    sent_during(driver, 0.6, **{name: rate * share for name, rate in SLOW.items()})

    driver.give(ev.GoTo("swift", *state_change(driver.robot, driver.state.robot)))

    assert in_force(driver) == "swift"
    assert duties(driver, TRACKS) == pytest.approx((duty, -duty, duty, -duty), abs=0.001)


def test_the_operator_commands_by_the_control_in_force(bearing):
    driver = settled(bearing())
    driver.give(ev.Pause())
    accept_all(driver)

    command(driver, "GoAhead")

    assert duties(driver, TRACKS) == pytest.approx((0.6, -0.6, 0.6, -0.6))


# --- criteria, traces, snapshots ---------------------------------------------------------------


def test_a_clamp_under_a_torque_loop_is_done_at_its_torque(bearing):
    """The 250 mNm of the criterion do not apply: 200 are asked for."""
    driver = bearing(
        SWITCH.replace("do: [SwitchLamp]", "do: [HoldNose]"),
        ("-300 mNm, fold_hip: 300 mNm", "-200 mNm, fold_hip: 200 mNm"),
        states={"Grip": "TailHeld"},
    )
    driver.give(ev.Answer("on"))
    assert driver.of(fx.Setpoints) == []
    driver.give(ev.Answer("light"))
    driver.accept()
    driver.signals |= {"neck_torque": -0.1}
    sent_during(driver, 1.0)
    assert driver.last_status.status == "accepted"

    driver.signals |= {"neck_torque": -0.2}
    sent_during(driver, 0.5)

    assert driver.last_status.status == "done"


def test_a_trace_awaits_no_torque(bearing):
    driver = bearing(nominal=True)
    driver.give(ev.Answer("on"))
    driver.accept()

    driver.tick(driver.now)

    assert driver.of(fx.WaitArmed)[-1].phase == "gentle"
    assert len(driver.of(fx.Setpoints)) == 1


def test_a_state_of_the_engine_with_a_control_is_written_without_loss(bearing):
    driver = switching(bearing())

    assert state_from_text(state_to_text(driver.state)) == driver.state


# --- taken up at a later phase -------------------------------------------------------------------


@pytest.fixture
def by_hand(bearing: Callable[..., Driver]) -> Callable[..., Driver]:
    """Starts an engine as the console does: the operator has the robot first."""

    def start(body: str = SWITCH) -> Driver:
        driver = bearing(body)
        rest = at_rest_in(driver.robot, driver.engine.program.start_configuration)
        driver.state, effects = driver.engine.start(driver.now, paused=True, body=rest)
        driver.effects[:] = effects
        driver.report_all(driver.now + 0.1)
        return driver

    return start


def handed_at(driver: Driver, phase: str) -> list[str]:
    """The operator hands the paused mission over there; the controls that are named on the way."""
    before = len(driver.of(fx.Log))
    driver.give(ev.GoTo(phase, *state_change(driver.robot, driver.state.robot)))
    accept_all(driver)
    driver.signals |= BORNE
    sent_during(driver, 0.3)
    told = [each.message for each in driver.of(fx.Log)[before:]]
    return [each for each in told if "control" in each]


def paused(driver: Driver) -> Driver:
    driver.give(ev.Pause())
    accept_all(driver)
    return driver


def in_force(driver: Driver) -> str:
    return driver.robot.controls[driver.state.robot.control].name


@pytest.mark.parametrize("phase", ["light", "drive", "still"])
def test_a_later_phase_begins_under_the_control_of_the_missions_head(by_hand, phase):
    driver = by_hand(f"control: gentle\n{SWITCH}")
    assert in_force(driver) == ""

    assert handed_at(driver, phase) == ["control gentle"]
    assert in_force(driver) == "gentle"
    assert driver.phases == [phase]
    assert loops(driver).count("RunningTorqueLoop") == 2


def test_a_later_phase_begins_under_the_control_that_a_step_before_it_sets(by_hand):
    driver = by_hand()

    assert handed_at(driver, "light") == ["control gentle"]
    assert driver.phases == ["light"]


def test_a_phase_that_the_mission_comes_to_under_the_usual_control_takes_that(bearing):
    driver = paused(settled(bearing()))

    assert handed_at(driver, "still") == ["the usual control"]
    assert in_force(driver) == ""


def test_where_the_usual_control_is_in_force_and_meant_nothing_is_said_of_it(by_hand):
    driver = by_hand()

    assert handed_at(driver, "still") == []
    assert driver.phases == ["still"]


def test_a_control_in_force_stays_where_the_mission_may_come_under_it(bearing):
    driver = paused(settled(bearing()))

    # "drive" is entered under the usual control, from "still", and under "gentle"
    assert handed_at(driver, "drive") == ["control gentle"]
    assert in_force(driver) == "gentle"


def test_a_clamp_whose_loop_the_pause_has_stopped_bears_its_torque_again(bearing):
    driver = paused(settled(bearing()))
    assert loops(driver) == []

    handed_at(driver, "light")

    assert loops(driver) == ["RunningTorqueLoop"] * 2
    assert driver.phases[-1] == "light"


def test_a_control_that_is_not_reached_leads_where_the_phases_failures_lead(by_hand):
    light = SWITCH.replace("  light:\n", "  light:\n    on_failure: late\n")
    driver = by_hand(light)
    driver.give(ev.GoTo("light", *state_change(driver.robot, driver.state.robot)))
    driver.accept()

    sent_during(driver, 4.0)

    assert driver.phases == ["late"]
    assert "did not bear the torque within 3 s" in warned(driver)


def test_a_mission_begun_at_a_later_phase_sets_its_control_first(bearing):
    driver = bearing(start_phase="light")

    assert in_force(driver) == "gentle"
    driver.accept()
    driver.signals |= BORNE
    sent_during(driver, 0.2)
    assert driver.phases == ["light"]


def test_a_mission_without_controls_is_taken_up_as_ever(bearing):
    program = bearing("start: a\nphases: {a: {do: [Rest], go: b}, b: {do: [SwitchLamp], go: e}}\n"
                      "ends: {e: {succeed: ok}}\n").engine.program  # fmt: skip

    assert program.entries == {}
    assert program.beginning("b") == program.enter("b")
