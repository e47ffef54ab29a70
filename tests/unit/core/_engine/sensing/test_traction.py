"""Slip, normal forces and friction out of frames, against a speed that is measured outside."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import asin, cos, isnan, nan
from pathlib import Path
from shutil import copytree

import pytest
from driving import DRIVING_FORWARD, IDLE, PIRATE, Driver

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.engine import Engine
from pirate_sm.core._model import events as ev

RADIUS_M = 0.024
DIRECTIONS = (1, -1, 1, -1, 1, -1)
LEAN, OBLIQUE = asin((0.120 - 0.048) / 0.090), asin((0.120 - 0.048) / 0.098)
CLAMPED = {
    "gamma_1": -2 * LEAN,
    "gamma_2": LEAN + OBLIQUE,
    "gamma_3": -(LEAN + OBLIQUE),
    "gamma_4": 2 * LEAN,
    "bend_torque_1": -0.7,
    "bend_torque_4": 0.7,
}
DRIVING_BACKWARD = {
    "BendingState": "DoubleClamped",
    "FrontWheelsState": "DrivingBackward",
    "RearWheelsState": "DrivingBackward",
}
CARELESS = f"on_fault: [{{fault: [robot.stuck, wheel.dead], then: continue}}]\n{IDLE}"


class Rolling:
    """The robot in a level pipe; a ruler tells how fast it moves."""

    def __init__(self, driver: Driver) -> None:
        self.driver = driver
        driver.signals |= CLAMPED

    def go(
        self,
        for_s: float,
        body_m_s: float | None,
        rims_m_s: float | Mapping[int, float],
        every_s: float = 0.1,
    ) -> Rolling:
        """Wheels roll so fast for a while; without a speed of the body the ruler is silent.

        The ruler tells it before each step, so its last value is a step old at the end.
        """
        rims = rims_m_s if isinstance(rims_m_s, Mapping) else dict.fromkeys(range(1, 7), rims_m_s)
        mirrored = -1 if self.driver.robot.polarity == "mirrored" else 1
        until = self.driver.now + for_s
        while self.driver.now < until - 1e-9:
            if body_m_s is not None:
                self.driver.give(ev.OutsideNumber("ruler", body_m_s))
            turning = {
                f"theta_{wheel}": rim * mirrored * DIRECTIONS[wheel - 1] / RADIUS_M
                for wheel, rim in rims.items()
            }
            self.driver.run(self.driver.now + every_s, every=every_s, **turning)
        return self

    def __getitem__(self, name: str) -> float:
        value = self.driver.engine.signals(self.driver.state)[name]
        assert isinstance(value, float)
        return value


@pytest.fixture
def rolling(drive: Callable[..., Driver]) -> Callable[..., Rolling]:
    def start(states: Mapping[str, str] = DRIVING_FORWARD, body: str = CARELESS) -> Rolling:
        return Rolling(drive(body, PIRATE, states=states))

    return start


def currents(ma: float) -> dict[str, float]:
    return {f"wheel_current_{wheel}": ma / 1000 for wheel in range(1, 7)}


@pytest.mark.parametrize("polarity", ["normal", "mirrored"])
@pytest.mark.parametrize(
    ("states", "body", "rim", "ratio"),
    [
        (DRIVING_FORWARD, 0.08, 0.10, -0.25),
        (DRIVING_FORWARD, 0.10, 0.08, 0.2),
        (DRIVING_BACKWARD, -0.08, -0.10, -0.25),
        (DRIVING_BACKWARD, -0.10, -0.08, 0.2),
    ],
)
def test_slip_is_counted_along_the_robot_and_its_ratio_against_the_travel(
    rolling, polarity, states, body, rim, ratio
):
    robot = rolling(states, f"polarity: {polarity}\n{CARELESS}").go(0.5, body, rim)

    for wheel in range(1, 7):
        assert robot[f"slip_speed_{wheel}"] == pytest.approx(rim - body)
        assert robot[f"slip_{wheel}"] == pytest.approx(ratio)


def test_a_ruler_that_averages_over_a_start_or_a_stop_shows_no_slip(rolling):
    robot = rolling().go(1.0, 0.0, 0.0).go(0.1, 0.045, 0.09)
    assert isnan(robot["slip_speed_1"])
    assert robot.go(0.5, 0.09, 0.09)["slip_speed_1"] == pytest.approx(0.0, abs=1e-6)

    robot.go(0.1, 0.045, 0.0)
    assert isnan(robot["slip_speed_1"])
    assert robot.go(0.5, 0.0, 0.0)["slip_speed_1"] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(("body", "known"), [(0.0049, False), (0.0051, True), (-0.0051, True)])
def test_the_ratio_is_unknown_below_5_mm_s_and_the_speed_is_not(rolling, body, known):
    robot = rolling().go(0.5, body, 0.02)

    assert isnan(robot["slip_1"]) is not known
    assert robot["slip_speed_1"] == pytest.approx(0.02 - body)


@pytest.mark.parametrize(("silent_s", "known"), [(0.15, True), (0.25, False), (1.0, False)])
def test_a_ruler_that_is_silent_is_replaced_by_the_wheels_and_slip_is_unknown(
    rolling, silent_s, known
):
    robot = rolling().go(0.5, 0.08, 0.10).go(silent_s, None, 0.10, every_s=0.05)

    assert robot["body_speed"] == pytest.approx(0.08 if known else 0.10)
    for name in ("slip_1", "slip_speed_1", "ruler"):
        assert isnan(robot[name]) is not known


def test_without_a_ruler_wheels_that_differ_from_the_others_do_not_count(rolling):
    rims = {1: 0.30, 2: 0.095, 3: 0.10, 4: 0.105, 5: 0.098, 6: 0.0}

    assert rolling().go(0.5, None, rims)["body_speed"] == pytest.approx(0.099)


def test_without_a_ruler_wheels_that_do_not_agree_show_no_speed(rolling):
    rims = {1: 0.30, 2: 0.20, 3: 0.15, 4: 0.10, 5: 0.05, 6: 0.0}

    assert isnan(rolling().go(0.5, None, rims)["body_speed"])


def test_a_value_of_an_unknown_signal_is_told_and_changes_nothing(rolling):
    robot = rolling()
    before = robot.driver.state.sensing

    robot.driver.give(ev.OutsideNumber("yardstick", 0.1))

    assert robot.driver.state.sensing == before
    assert [each.message for each in robot.driver.of(fx.Log)] == [
        "'yardstick' was measured outside, an unknown signal"
    ]


def slipping(robot: Rolling, for_s: float, *, rim: float = 0.10, ma: float = 60.0) -> Rolling:
    """The first wheel slips, the others roll."""
    robot.driver.signals |= currents(ma)
    rims = dict.fromkeys(range(2, 7), 0.02)
    return robot.go(for_s, 0.02, {1: rim, **rims})


def test_friction_is_known_after_half_a_second_of_slip(rolling):
    robot = rolling().go(1.5, 0.02, 0.02)
    assert isnan(slipping(robot, 0.5)["mu_1"])

    slipping(robot, 0.3)

    assert robot["mu_1"] == pytest.approx(robot["mu_used_1"], rel=0.02)
    assert robot["mu_estimate_front"] == robot["mu_1"]
    for name in ("mu_2", "mu_6", "mu_estimate_rear"):
        assert isnan(robot[name])


def tyres_that_resist(folder: Path, share: float) -> Path:
    """A copy of the robot whose tyres resist rolling by this share of their normal forces."""
    copytree(PIRATE, folder)
    profile = (folder / "profile.yaml").read_text(encoding="utf-8")
    assert "\nsimulation:\n" in profile
    with_tyre = f"\nsimulation:\n  tyre: {{rolling_resistance: {share}}}\n"
    (folder / "profile.yaml").write_text(profile.replace("\nsimulation:\n", with_tyre), "utf-8")
    return folder


@pytest.mark.parametrize("states", [DRIVING_FORWARD, DRIVING_BACKWARD])
def test_what_resists_rolling_is_not_friction(drive, tmp_path, states):
    way = 1 if states is DRIVING_FORWARD else -1
    robot = Rolling(drive(CARELESS, tyres_that_resist(tmp_path / "robot", 0.02), states=states))
    robot.driver.signals |= currents(60)
    robot.go(1.5, way * 0.02, way * 0.02)

    robot.go(1.5, way * 0.02, {1: way * 0.1, **dict.fromkeys(range(2, 7), way * 0.02)})

    for wheel in robot.driver.robot.wheels:
        each = wheel.place + 1
        share = 0.06 * wheel.n_per_a / robot[f"normal_force_{each}"]
        assert robot[f"mu_used_{each}"] == pytest.approx(share - 0.02, abs=1e-3)
    assert robot["mu_1"] == pytest.approx(robot["mu_used_1"], rel=0.02)


def test_motors_that_only_overcome_what_resists_rolling_push_against_nothing(drive, tmp_path):
    """Its wheels press as if no motor gave anything, since that is what the walls bear."""
    still = Rolling(drive(CARELESS, PIRATE, states=DRIVING_FORWARD)).go(1.5, 0.0, 0.0)
    tyres = tyres_that_resist(tmp_path / "robot", 0.02)
    robot = Rolling(drive(CARELESS, tyres, states=DRIVING_FORWARD))
    pressed_n = [still[f"normal_force_{wheel}"] for wheel in range(1, 7)]
    for wheel, normal_n in zip(robot.driver.robot.wheels, pressed_n, strict=True):
        current = f"wheel_current_{wheel.place + 1}"
        robot.driver.signals |= {current: 0.02 * normal_n / wheel.n_per_a}

    robot.go(1.5, 0.02, 0.02)

    found_n = [robot[f"normal_force_{wheel}"] for wheel in range(1, 7)]
    assert found_n == pytest.approx(pressed_n, rel=0.06)  # motors react on their links


def test_friction_is_unknown_again_as_soon_as_the_wheel_grips(rolling):
    robot = slipping(rolling().go(1.5, 0.02, 0.02), 1.0)
    assert not isnan(robot["mu_1"])

    assert isnan(robot.go(0.2, 0.02, 0.02)["mu_1"])


@pytest.mark.parametrize(("rim", "known"), [(0.029, False), (0.032, True), (-0.02, False)])
def test_friction_needs_a_slip_of_10_mm_s_the_way_that_the_wheel_is_driven(rolling, rim, known):
    robot = slipping(rolling().go(1.5, 0.02, 0.02), 1.2, rim=rim)

    assert isnan(robot["mu_1"]) is not known


def test_a_motor_at_its_limit_shows_no_friction(rolling):
    robot = slipping(rolling().go(1.5, 0.02, 0.02), 1.2, ma=345)

    assert isnan(robot["mu_1"])
    assert robot["mu_used_1"] > 0


def test_older_frames_are_forgotten_by_degrees(rolling):
    robot = slipping(rolling().go(1.5, 0.02, 0.02), 3.0)
    before = robot["mu_1"]

    soon = slipping(robot, 0.5, ma=90)["mu_1"]
    late = slipping(robot, 15.0, ma=90)["mu_1"]

    assert before * 1.02 < soon < before * 1.3
    assert late == pytest.approx(robot["mu_used_1"], rel=0.02)


def test_a_frame_without_values_loses_nothing_that_was_learned(rolling):
    robot = slipping(rolling().go(1.5, 0.02, 0.02), 1.5)
    learned, known = robot.driver.state.sensing.traction.slipping[0], robot["mu_1"]

    board = robot.driver.frame(22)
    robot.driver.give(ev.SensorFrame(22, (nan,) * len(board.values)), robot.driver.now + 0.1)
    robot.driver.report(27)  # with the last wheel the signals of all are made

    assert isnan(robot["mu_1"])
    assert isnan(robot["normal_force_1"]) or robot["normal_force_1"] > 0
    assert robot.driver.state.sensing.traction.slipping[0] == learned
    assert slipping(robot, 0.3)["mu_1"] == pytest.approx(known, rel=0.05)


def test_after_a_longer_silence_of_the_ruler_slip_must_be_steady_anew(rolling):
    robot = slipping(rolling().go(1.5, 0.02, 0.02), 1.5)
    robot.go(1.0, None, {1: 0.10, **dict.fromkeys(range(2, 7), 0.02)})
    assert isnan(robot["mu_1"])

    assert isnan(slipping(robot, 0.3)["mu_1"])
    assert not isnan(slipping(robot, 0.5)["mu_1"])


def test_forces_are_unknown_without_a_clamped_part_or_with_an_unknown_joint(rolling):
    assert isnan(rolling({"BendingState": "Unclamped"}).go(1.5, 0.0, 0.0)["normal_force_1"])

    robot = rolling().go(1.5, 0.02, 0.02)
    assert robot["normal_force_1"] > 10
    robot.driver.signals["gamma_2"] = nan
    assert isnan(robot.go(0.3, 0.02, 0.02)["normal_force_1"])


def test_a_wheel_that_is_dragged_holds_back(rolling):
    robot = rolling()
    robot.driver.signals |= currents(60)
    pushing = robot.go(1.5, 0.02, 0.02)["normal_force_2"]

    # Their motors reach 100 mm/s without load: now all six pull back, against the leading end.
    dragged = robot.go(0.5, 0.30, 0.30)["normal_force_2"]

    level = 2 * 0.7 / (0.090 * cos(LEAN))
    assert dragged < pushing
    assert pushing > level


def test_a_board_that_is_silent_takes_the_signals_of_its_wheel_with_it(rolling):
    robot = rolling().go(1.5, 0.02, 0.05)
    assert not isnan(robot["slip_speed_1"])

    for _ in range(30):
        robot.driver.give(ev.OutsideNumber("ruler", 0.02))
        for board in set(robot.driver.robot.boards) - {22}:
            robot.driver.report(board, robot.driver.now + 0.02)

    assert isnan(robot["slip_speed_1"])
    assert not isnan(robot["slip_speed_2"])


# --- when they are estimated -----------------------------------------------------------------

FORCE = CARELESS.replace(
    "{operator: stop, go: stopped}", "{when: normal_force_1 > 1 N, go: stopped}"
)
"""Waits for a force."""


def kept(robot: Rolling, name: str) -> float:
    """What the state itself has for the signal."""
    number: float = robot.driver.state.sensing.numbers[
        robot.driver.robot.vocabulary.numbers.index(name)
    ]
    return number


def test_estimates_that_nothing_reads_are_computed_only_when_asked_for(rolling):
    robot = rolling().go(1.5, None, 0.02)

    assert isnan(kept(robot, "normal_force_1"))
    assert isnan(kept(robot, "body_speed"))
    assert robot["normal_force_1"] > 10
    assert robot["body_speed"] == pytest.approx(0.02)
    assert robot["mu_used_1"] >= 0


def test_both_ways_give_the_same(rolling):
    lazy = rolling().go(1.5, None, 0.02)
    driver = lazy.driver
    other = Engine(driver.robot, driver.engine.program, nominal=False, every_signal=True)
    eager, _ = other.step(driver.state, driver.frame(27), driver.now)
    lazy.driver.give(driver.frame(27))

    assert repr(other.numbers(eager)) == repr(driver.engine.numbers(driver.state))
    assert eager.sensing.numbers == pytest.approx(other.numbers(eager), nan_ok=True)
    assert isnan(kept(lazy, "normal_force_1"))


def test_a_condition_that_reads_one_sees_it(rolling):
    robot = rolling(body=FORCE)
    assert not robot.driver.fired

    robot.go(1.5, None, 0.02)

    assert robot.driver.fired
    assert kept(robot, "normal_force_1") > 1


def test_slip_is_kept_while_a_speed_from_outside_is_known_or_a_wheel_slips(rolling):
    robot = slipping(rolling().go(1.5, 0.02, 0.02), 1.0)
    assert kept(robot, "mu_1") == robot["mu_1"] > 0

    robot.go(3.0, None, 0.02)
    before = kept(robot, "normal_force_1")
    robot.driver.signals |= {"bend_torque_1": -0.3}
    robot.go(0.5, None, 0.02)

    assert kept(robot, "normal_force_1") == before != robot["normal_force_1"]


def test_what_was_estimated_long_ago_is_not_shown_for_the_present(rolling):
    robot = rolling().go(1.5, 0.02, 0.02).go(3.0, None, 0.02)
    assert not isnan(kept(robot, "slip_speed_1"))

    robot.driver.give(ev.OutsideNumber("ruler", 0.02))

    assert isnan(robot["slip_speed_1"])
    robot.go(0.1, 0.02, 0.02)
    assert robot["slip_speed_1"] == pytest.approx(0.0, abs=1e-3)
