"""Evidence: its age, and the connection that it belongs to."""

from __future__ import annotations

from math import isnan

import pytest
from driving import BOTH_CLAMPED, IDLE, REAR_CLAMPED, command

from pirate_sm.core._engine.robot.evidence import NOTHING, Evidence
from pirate_sm.core._engine.robot.robot_state import DENIED
from pirate_sm.core._model import events as ev


def test_the_age_of_evidence_is_computed_when_it_is_asked_for():
    assert Evidence("sensor", 12.0, 0).age_s(14.5) == 2.5
    assert isnan(NOTHING.age_s(14.5))


@pytest.mark.parametrize("code", ["firmware.reset", "link.interrupted"])
def test_each_return_of_the_controller_begins_the_next_connection(drive, code):
    driver = drive(f"on_fault: [{{fault: [{code}, robot.stuck], then: continue}}]\n{IDLE}")
    assert driver.state.sensing.connection == 0

    driver.give(ev.FaultReport("robot.stuck", "it does not move"))
    assert driver.state.sensing.connection == 0

    driver.give(ev.FaultReport(code, "it is back"))
    driver.give(ev.FaultReport(code, "it is back again"))
    driver.run(driver.now + 1.0)
    assert driver.state.sensing.connection == 2


def shown(driver) -> dict[str, str]:
    """What has shown each state and clamp, by name."""
    evidence = driver.engine.evidence(driver.state)
    robot = driver.robot
    return {name: evidence[name].source for name in (*robot.regions, *robot.parts)}


def test_belief_says_by_what_it_was_shown_when_and_in_which_connection(drive):
    driver = drive(f"on_fault: [{{fault: firmware.reset, then: continue}}]\n{IDLE}")
    driver.run(1.0)
    assert set(shown(driver).values()) == {"assumption", "nothing"}

    command(driver, "ClampFront")
    driver.accept()
    assert shown(driver)["front"] == shown(driver)["BendingState"] == "echo", "it has arrived"
    driver.until_done("ClampFront")
    clamped_s = driver.now
    assert driver.engine.evidence(driver.state)["front"] == Evidence("sensor", clamped_s, 0)
    assert shown(driver)["BendingState"] == "sensor", "as its command asks for"

    command(driver, "ToggleLighting")
    driver.accept()
    assert shown(driver)["LightingState"] == "echo", "no sensor sees the light"

    driver.give(ev.FaultReport("firmware.reset", "it is back", 1.0))
    front = driver.engine.evidence(driver.state)["front"]
    assert front == Evidence("sensor", clamped_s, 0), "older evidence, of another connection"
    assert front.connection != driver.state.sensing.connection


def test_what_is_declared_is_shown_by_a_person_until_a_sensor_shows_it(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED, declared=True)

    assert shown(driver)["rear"] == shown(driver)["FrontWheelsState"] == "person"


def test_belief_in_a_clamp_ends_with_the_clamp(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    assert shown(driver)["rear"] == "assumption"

    command(driver, "RelaxRear")
    driver.accept()

    assert (shown(driver)["front"], shown(driver)["rear"]) == ("assumption", "nothing")


def test_a_clamp_that_a_fault_denies_is_shown_by_nothing(drive):
    text = f"on_fault: [{{fault: clamp.lost, then: continue}}]\n{IDLE}"
    driver = drive(text, states=BOTH_CLAMPED)
    rule = next(rule for rule in driver.robot.faults if rule.denies)

    driver.give(ev.FaultReport(rule.code, rule.message))

    denied = {driver.robot.parts[part] for part in rule.denies}
    assert {name for name in driver.robot.parts if shown(driver)[name] == "nothing"} == denied


def test_a_signal_has_the_evidence_of_its_boards_last_report(drive):
    driver = drive(IDLE)
    assert "gamma_1" not in driver.engine.evidence(driver.state)

    driver.report(22, at=0.1)
    driver.report(23, at=0.2)

    evidence = driver.engine.evidence(driver.state)
    assert evidence["gamma_1"] == Evidence("sensor", 0.1, 0)
    assert evidence["gamma_2"] == Evidence("sensor", 0.2, 0)
    assert evidence["diameter_front"].age_s(0.3) == pytest.approx(0.2)

    driver.report_all(0.3)
    driver.report(22, at=0.4)
    assert driver.engine.evidence(driver.state)["odometry"] == Evidence("sensor", 0.3, 0)


def test_a_command_says_which_proof_it_needs(drive):
    driver = drive(IDLE)
    proofs = {spec.name: spec.proof for spec in driver.robot.commands}

    assert proofs["ClampFront"] == "sensor"
    assert proofs["ToggleLighting"] == "echo"


@pytest.mark.parametrize(
    ("denied", "why"),
    [(False, "front: no sensor has shown that it holds"), (True, "front: its clamp is denied")],
)
def test_belief_that_is_missing_is_named_where_a_command_is_refused(drive, denied, why):
    text = f"on_fault: [{{fault: clamp.lost, then: continue}}]\n{IDLE}"
    driver = drive(text, states=REAR_CLAMPED)
    command(driver, "ClampFront")
    driver.accept()
    driver.run(40.0)
    assert driver.last_status.status == "failed"
    if denied:
        marks = frozenset(m._replace(command=DENIED) for m in driver.state.robot.marks)
        driver.state = driver.state._replace(robot=driver.state.robot._replace(marks=marks))

    command(driver, "RelaxRear")

    assert driver.last_status.reason == (
        f"impossible: it would let go of the last confirmed clamp (rear); {why}"
    )
