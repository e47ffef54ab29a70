"""What the odometry counts, by which rule."""

from __future__ import annotations

import pytest
from driving import BOTH_CLAMPED, FRONT_CLAMPED, IDLE, command

from pirate_sm.core._engine.engine import Engine

READING = f"on_fault: [{{fault: [wheel.dead, robot.stuck], then: continue}}]\n{IDLE}".replace(
    "[{operator: stop", "[{when: odometry > 90 m, go: stopped}, {operator: stop"
)
RIM_M_S = 0.09
TURN = RIM_M_S / 0.024


def driving(drive, *, alphabet: int | None = None):
    driver = drive(READING, states=BOTH_CLAMPED)
    if alphabet is not None:
        driver.engine = Engine(
            driver.robot, driver.engine.program, nominal=False, alphabet=alphabet
        )
        driver.state, _ = driver.engine.start(0.0, body=driver.state.robot)
    driver.report_all(0.1)
    command(driver, "DriveForward")
    driver.accept()
    return driver


def turning(*wheels: int, rate: float = TURN) -> dict[str, float]:
    return {f"theta_{wheel}": rate if wheel % 2 else -rate for wheel in wheels}


def shown(driver) -> tuple[float, float]:
    signals = driver.engine.signals(driver.state)
    return signals["odometry"], signals["odometry_bound"]


def test_belief_in_a_wheel_that_neither_turns_nor_bears_force_ends(drive) -> None:
    driver = driving(drive)

    driver.run(5.1, **turning(1, 2, 5, 6))

    odometry_m, bound_m = shown(driver)
    assert odometry_m == pytest.approx(5.0 * RIM_M_S, abs=0.01)
    assert bound_m < 0.03
    assert driver.state.sensing.distance.out == {2, 3}


def test_a_wheel_that_turns_with_the_others_again_is_believed_again(drive) -> None:
    driver = driving(drive)
    driver.run(2.0, **turning(1, 2, 3, 4, 5))

    driver.run(5.1, **turning(1, 2, 3, 4, 5, 6))

    assert driver.state.sensing.distance.out == frozenset()
    assert shown(driver)[0] == pytest.approx(5.0 * RIM_M_S, abs=0.01)


def test_wheels_that_push_hard_may_slip(drive) -> None:
    driver = driving(drive)
    driver.run(1.0, **turning(1, 2, 3, 4, 5, 6))
    before_m = shown(driver)[1]
    driver.signals |= {f"wheel_current_{wheel}": 0.05 * wheel for wheel in range(1, 7)}

    driver.run(3.0, **turning(1, 2, 3, 4, 5, 6))

    assert shown(driver)[1] - before_m == pytest.approx(2.0 * RIM_M_S, rel=0.2)


def test_the_speed_is_that_of_the_driven_wheels_and_of_all_where_none_is_driven(drive) -> None:
    driver = drive(READING, states=FRONT_CLAMPED)
    driver.run(1.0, **turning(1, 2, 3))
    assert driver.engine.signals(driver.state)["speed"] == pytest.approx(RIM_M_S / 2)

    command(driver, "DriveForward")
    driver.accept()
    driver.run(2.0, **turning(1, 2, 3))

    assert driver.engine.signals(driver.state)["speed"] == pytest.approx(RIM_M_S)


def test_an_older_recording_keeps_the_odometry_that_it_was_made_with(drive) -> None:
    driver = driving(drive, alphabet=9)

    driver.run(5.1, **turning(1, 2, 5, 6))

    assert driver.engine.signals(driver.state)["odometry"] == pytest.approx(
        5.0 * RIM_M_S * 4 / 6, abs=0.01
    )
