"""A clamp whose sensors are not known for a moment: the robot stops and waits to see it again."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from driving import BOTH_CLAMPED, REAR_CLAMPED, Driver, command

from pirate_sm.core import effects as fx
from pirate_sm.core._engine import safety
from pirate_sm.core._engine.mission import flow
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._model import events as ev

TURN = 2 * math.asin((0.113 - 0.048) / 0.09)
HELD = {"bend_3": -0.7, "bend_4": 0.7}
DRIVES = """
on_fault:
  - {fault: sensor.silent, then: continue}
  - {fault: wheel.dead, go: rescue}
start: a
phases:
  a: {do: [DriveForward], wait: [{after: 5 s, go: e}], within: {time: 1 h, go: e}}
  rescue: {do: [Brake], wait: [{after: 1 s, go: e}]}
ends: {e: {succeed: "After {cause}"}}
"""
LETS_GO = """
on_fault: [{fault: sensor.silent, then: continue}]
start: a
phases:
  a: {wait: [{operator: x, go: b}], within: {time: 1 h, go: b}}
  b: {do: [RelaxFront], go: e, on_failure: f}
ends: {e: {succeed: ok}, f: {fail: "{cause}"}}
"""
CALLS = LETS_GO.replace("RelaxFront", "call: {file}")
DRIVES_ON = (
    DRIVES.replace("after: 5 s, go: e", "operator: x, go: b")
    .replace("  rescue", "  b: {do: [{call: {file}}], go: e, on_failure: f}\n  rescue")
    .replace("ends: {", "ends: {f: {fail: '{cause}'}, ")
)
NEEDS_BOTH = """
starts_in: {BendingState: DoubleClamped}
start: a
phases: {a: {do: [ToggleLighting], go: e}}
ends: {e: {succeed: ok}}
"""


def reporting(driver: Driver, until: float, silent: int = 0) -> None:
    """All boards but one report, arrays are accepted, and driven wheels turn."""
    names = driver.robot.vocabulary.numbers
    while driver.now < until - 1e-9 and not driver.ended:
        driver.now += 0.1
        if driver.in_flight:
            driver.accept()
        for wheel in driver.robot.wheels:
            turned = 0.3 * driver.state.robot.values[wheel.slot]
            driver.signals[names[wheel.angle]] = turned + driver.signals.get(names[wheel.angle], 0)
        for each in driver.robot.boards:
            if each != silent:
                driver.report(each)
        driver.tick(driver.now)


def holding(drive, body: str, states: dict[str, str]) -> Driver:
    driver = drive(body, states=states)
    for n in (1, 2, 3, 4):
        way = 1 if n % 2 == 0 else -1
        driver.signals |= {f"gamma_{n}": way * TURN, f"bend_torque_{n}": way * 0.6}
    return driver


def driving_unseen(drive, body: str = DRIVES) -> Driver:
    """A robot that drives by its rear alone, one of whose joints has just become unknown."""
    driver = holding(drive, body, REAR_CLAMPED)
    reporting(driver, 1.0)
    assert driver.nonzero.keys() > HELD.keys()
    reporting(driver, 2.1, silent=26)
    assert driver.faults == [("sensor.silent", "continue")]
    return driver


def test_belief_in_the_only_clamp_ends_and_the_wheels_stop_while_it_is_not_seen(drive):
    driver = driving_unseen(drive)

    assert driver.nonzero == pytest.approx(HELD)
    assert "BendingState" in driver.unconfirmed
    assert driver.ended is None


def test_a_mission_resumes_when_the_clamp_is_seen_again_and_its_time_stood_still(drive):
    driver = driving_unseen(drive)
    stopped_s = driver.now
    reporting(driver, 3.0, silent=26)
    reporting(driver, 3.4)
    assert driver.nonzero == pytest.approx(HELD), "it must be seen for half a second"

    reporting(driver, 4.0)

    assert driver.nonzero.keys() > HELD.keys()
    assert driver.unconfirmed == set()
    assert driver.state.mission.offset_s == pytest.approx(3.6 - stopped_s, abs=0.15)
    reporting(driver, 8.0)
    assert driver.ended.outcome == "succeeded"


def test_a_clamp_that_is_not_seen_in_time_breaks_the_rule(drive):
    driver = driving_unseen(drive)
    begun_s = driver.now
    reporting(driver, begun_s + 2.8, silent=26)
    assert driver.ended is None

    reporting(driver, begun_s + 4.0, silent=26)

    assert driver.ended.message.startswith("rule.violated: rule drive_with_a_clamp")
    assert driver.now == pytest.approx(begun_s + 3.0, abs=0.25)
    assert driver.nonzero == pytest.approx(HELD)


def test_a_clamp_that_shows_itself_open_is_not_waited_for_longer(drive):
    driver = driving_unseen(drive)
    driver.signals |= {"bend_torque_3": 0.0, "bend_torque_4": 0.0}

    reporting(driver, driver.now + 4.0)

    assert driver.ended.message.startswith("rule.violated: rule drive_with_a_clamp")


def test_a_pause_of_the_operator_meanwhile_lasts_when_the_clamp_is_seen(drive):
    driver = driving_unseen(drive)

    driver.give(ev.Pause())
    reporting(driver, driver.now + 0.1, silent=26)
    driver.give(ev.Resume())
    assert driver.messages[-1].startswith("still paused: rule drive_with_a_clamp")
    reporting(driver, 6.0)

    assert driver.nonzero == pytest.approx(HELD)
    driver.give(ev.Resume())
    assert driver.nonzero.keys() > HELD.keys()


def test_a_pause_that_the_operator_asked_for_before_stays_the_operators(drive):
    driver = holding(drive, DRIVES, REAR_CLAMPED)
    reporting(driver, 1.0)
    wanted = flow.want_pause(driver.state)
    moment = Moment(driver.robot, driver.engine.program, False, driver.now)

    assert wanted.mission.pause_wanted
    assert flow.pause_until_seen(moment, wanted) == wanted
    assert moment.effects == []


def test_two_rules_broken_in_a_pause_of_the_operator_stop_the_wheels_once(drive, monkeypatch):
    driver = holding(drive, DRIVES, REAR_CLAMPED)
    reporting(driver, 1.0)
    driver.give(ev.Pause())
    reporting(driver, 1.3)
    command(driver, "DriveForward")
    reporting(driver, 2.0)
    follow, before = safety.follow, len(driver.of(fx.Setpoints))

    def twice(*arguments):
        places, broken = follow(*arguments)
        return places, broken * 2

    monkeypatch.setattr(safety, "follow", twice)
    reporting(driver, 3.3, silent=26)

    stops = driver.of(fx.Setpoints)[before:]
    assert len({each.setpoint_id for each in stops}) == 1


def test_a_fault_meanwhile_is_handled_at_once(drive):
    driver = driving_unseen(drive)

    driver.give(ev.FaultReport("wheel.dead", "it does not turn", of=("wheel_4",)))
    reporting(driver, driver.now + 0.5, silent=26)

    assert driver.phases[-1] == "rescue"
    assert ("Brake", "sent") in driver.statuses
    assert driver.nonzero == pytest.approx(HELD)


def test_wheels_that_an_operator_drives_in_a_pause_stop_too(drive):
    driver = holding(drive, LETS_GO, REAR_CLAMPED)
    driver.give(ev.Pause())
    reporting(driver, 0.5)
    command(driver, "DriveForward")
    reporting(driver, 1.5)
    assert driver.nonzero.keys() > HELD.keys()

    reporting(driver, 3.0, silent=26)

    assert driver.nonzero == pytest.approx(HELD)
    assert driver.ended is None


def test_a_command_waits_until_the_clamp_that_it_needs_is_seen_again(drive):
    driver = holding(drive, LETS_GO, BOTH_CLAMPED)
    reporting(driver, 1.0)
    reporting(driver, 1.6, silent=26)

    driver.give(ev.Answer("x"))
    reporting(driver, 2.0)
    assert driver.statuses == []
    reporting(driver, 2.5)

    assert ("RelaxFront", "sent") in driver.statuses


def test_a_command_is_refused_when_the_clamp_is_not_seen_in_time(drive):
    driver = holding(drive, LETS_GO, BOTH_CLAMPED)
    reporting(driver, 1.0)
    reporting(driver, 1.6, silent=26)

    driver.give(ev.Answer("x"))
    reporting(driver, 4.4, silent=26)
    assert driver.statuses == []
    reporting(driver, 5.0, silent=26)

    assert driver.statuses == [("RelaxFront", "refused")]
    assert "last confirmed clamp" in driver.ended.message


def test_a_command_that_a_seen_clamp_would_not_allow_either_is_refused_at_once(drive):
    driver = holding(drive, LETS_GO.replace("RelaxFront", "BendInto"), BOTH_CLAMPED)
    reporting(driver, 1.0)
    reporting(driver, 1.6, silent=26)

    driver.give(ev.Answer("x"))

    assert driver.statuses == [("BendInto", "refused")]


def called(folder: Path) -> str:
    file = folder / "called.yaml"
    head = "format: 1\nmission: called\nrobot: pirate_ii\n"
    file.write_text(head + NEEDS_BOTH, encoding="utf-8")
    return file.name


@pytest.mark.parametrize(("silent", "outcome"), [(0, "succeeded"), (26, "failed")])
def test_a_mission_that_requires_a_clamp_waits_for_it_too(drive, tmp_path, silent, outcome):
    driver = holding(drive, CALLS.replace("{file}", called(tmp_path)), BOTH_CLAMPED)
    reporting(driver, 1.0)
    reporting(driver, 2.1, silent=26)

    driver.give(ev.Answer("x"))
    assert driver.statuses == []
    reporting(driver, 6.0, silent)

    assert driver.ended.outcome == outcome


@pytest.mark.parametrize("silent", [0, 26])
def test_the_wheels_stop_while_a_step_waits_and_drive_on_only_if_it_is_seen(
    drive, tmp_path, silent
):
    both = {"bend_1": -0.7, "bend_2": 0.7} | HELD
    body = DRIVES_ON.replace("{file}", called(tmp_path))
    driver = holding(drive, body, BOTH_CLAMPED)
    reporting(driver, 1.0)
    reporting(driver, 2.1, silent=26)
    assert driver.nonzero.keys() > both.keys(), "the front holds too"

    driver.give(ev.Answer("x"))
    reporting(driver, 2.5, silent=26)
    assert driver.nonzero == pytest.approx(both)
    effects = len(driver.effects)
    reporting(driver, 8.0, silent)

    arrays = [each for each in driver.effects[effects:] if isinstance(each, fx.Setpoints)]
    driven = any(each.values[slot] for each in arrays for slot in driver.robot.safe_zero)
    assert driven == (silent == 0)
