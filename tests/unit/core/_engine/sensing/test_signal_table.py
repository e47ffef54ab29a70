"""Raw counts become SI by appendix B of the thesis; what is not known is unknown."""

from __future__ import annotations

import math

import pytest
from driving import BOTH_CLAMPED, DRIVING_FORWARD, IDLE, NEWT, PIRATE, changed_newt, command

from pirate_sm.core import effects as fx
from pirate_sm.core._model import events as ev

CARELESS = f"on_fault: [{{fault: [sensor.silent, robot.stuck], then: continue}}]\n{IDLE}"

# Channels by board, in the order of the wire.
BEND_ANGLE, BEND_SPRING, BEND_LOAD, WHEEL_ANGLE, WHEEL_VELOCITY, WHEEL_LOAD = range(6)


def counts(**at: float) -> tuple[float, ...]:
    values = [0.0] * 9
    for name, value in at.items():
        values[int(name.removeprefix("c"))] = value
    return tuple(values)


def frame(driver, board: int, values: tuple[float, ...], at: float) -> dict[str, float]:
    driver.give(ev.SensorFrame(board, values), at)
    return driver.engine.signals(driver.state)


def test_a_damaged_acceleration_is_not_believed(drive):
    """A line damages a reading: -50 m/s^2 is no fall, and no weight of the robot's either."""
    driver = drive(IDLE, PIRATE, doubting=True)
    shown = frame(driver, 24, counts(c2=16384), 0.1)

    damaged = frame(driver, 24, counts(c2=-5 * 16384), 0.2)
    assert damaged["acceleration"] == shown["acceleration"]


@pytest.mark.parametrize(
    ("board", "values", "signal", "si"),
    [
        (22, counts(c0=1024), "gamma_1", math.pi / 2),  # B-1
        (23, counts(c0=-512), "gamma_2", -math.pi / 4),
        (26, counts(c2=250), "bend_current_3", 0.25),  # B-2
        (22, counts(c1=100), "bend_torque_1", 3.5e-3 * (58 / 16) ** 2 * 360 / 4096 * 100),  # B-6
        (25, counts(c0=16 * 809 / 4), "phi", math.pi / 2),  # B-7
        (25, counts(c1=90), "rotate_current", 0.09),  # B-8
        (27, counts(c3=16 * 112), "theta_6", 2 * math.pi),  # B-9
        (24, counts(c8=310), "wheel_current_3", 0.31),  # B-10
        (24, counts(c2=16384), "acceleration", 9.81),
    ],
)
def test_a_count_is_converted_as_appendix_b_says(drive, board, values, signal, si):
    driver = drive(IDLE)

    assert frame(driver, board, values, 0.1)[signal] == pytest.approx(si)


def test_a_wheels_speed_is_the_difference_of_its_angle_over_time(drive):
    driver = drive(IDLE)
    first = frame(driver, 22, counts(c3=0), 0.1)
    assert math.isnan(first["omega_1"]), "one frame tells no speed"

    second = frame(driver, 22, counts(c3=16 * 112 / 4), 0.6)  # B-11

    assert second["omega_1"] == pytest.approx(math.pi / 2 / 0.5)


def test_two_frames_of_one_moment_are_a_period_apart(drive):
    driver = drive(IDLE, doubting=True)
    frame(driver, 22, counts(c3=0), 0.1)
    frame(driver, 22, counts(c3=448), 0.6)

    again = frame(driver, 22, counts(c3=449), 0.6)

    assert again["omega_1"] == pytest.approx(2 * math.pi / 16 / 112 / (6 * 0.016))


@pytest.mark.thorough
@pytest.mark.parametrize("stall_s", [0.0, 0.05, 0.15, 0.3])
def test_a_pause_of_the_computer_is_no_speed(drive, stall_s):
    """Frames that have waited while this program stood still are read together."""
    fastest = 0.0
    for phase in range(50 if stall_s else 1):
        driver = drive(CARELESS, states=DRIVING_FORWARD, doubting=True)
        boards = list(driver.robot.boards)
        stalled = range(0) if not stall_s else (1.0 + phase * 0.0024, stall_s)
        for cycle in range(1, 150):
            sent_s = cycle * 0.016
            read_s = sent_s
            if stall_s and stalled[0] <= sent_s < stalled[0] + stall_s:
                read_s = stalled[0] + stall_s
            board = boards[cycle % len(boards)]
            for wheel in range(1, 7):
                way = 1 if wheel % 2 else -1
                driver.signals[f"theta_{wheel}"] = way * sent_s * 0.10 / 0.024
            driver.report(board, max(read_s, driver.now))
            speed = driver.engine.signals(driver.state)["speed"]
            fastest = max(fastest, 0.0 if math.isnan(speed) else abs(speed))

    assert driver.faults == []
    assert 0.099 < fastest < 0.13


def test_the_speed_of_wheels_that_nobody_drives_is_the_mean_of_all(drive):
    driver = drive(CARELESS)
    driver.run(0.5, theta_1=1.0, theta_2=-2.0, theta_3=3.0)

    expected = (1.0 + 2.0 + 3.0) / 6 * 0.024
    assert driver.engine.signals(driver.state)["speed"] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("acceleration", "roll", "pitch"),
    [
        ((0, 0, 1), 0, 0),
        ((0, -1, 1), 45, 0),
        ((0, 1, 0), -90, 0),
        ((1, 0, 1), 0, 45),
        ((-1, 0, 0), 0, -90),
    ],
)
def test_roll_and_pitch_are_those_of_gravity(drive, acceleration, roll, pitch):
    driver = drive(IDLE)
    x, y, z = (16384 * part for part in acceleration)

    signals = frame(driver, 24, counts(c0=x, c1=y, c2=z), 0.1)  # B-13, B-14

    assert math.degrees(signals["roll"]) == pytest.approx(roll)
    assert math.degrees(signals["pitch"]) == pytest.approx(pitch)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 6])
def test_belief_a_norm_is_of_all_its_signals_and_of_no_others(drive, tmp_path, count):
    """The first signal of the robot counted as a missing one, and a fourth one did not count."""
    of = ["neck", "hip", "roll_b", "hip", "neck", "roll_b"][:count]
    norm = f"derived:\n  size: {{norm_of: [{', '.join(of)}]}}"
    driver = drive(IDLE, changed_newt(tmp_path, ("derived:", norm)))

    frame(driver, 40, (300.0, 0.0), 0.1)
    signals = frame(driver, 3, (200.0, 100.0, 0.0, -50.0, 0.0), 0.11)

    assert abs(signals["roll_a"]) > 0
    assert signals["size"] == pytest.approx(math.hypot(*(signals[each] for each in of)))


def test_the_diameter_is_that_of_the_clamped_v(drive):
    driver = drive(IDLE)
    angle = 2 * math.asin(0.072 / 0.09)

    signals = frame(driver, 27, counts(c0=angle / (2 * math.pi / 4096)), 0.1)

    assert signals["diameter_rear"] == pytest.approx(0.12)  # eq. 3-2: h + 2r
    assert math.isnan(signals["diameter_front"])


def test_a_wheels_torque_has_the_sign_of_its_setpoint(drive):
    driver = drive(IDLE, states=DRIVING_FORWARD)
    driver.report_all(0.1)
    command(driver, "DriveBackward")
    driver.accept()

    forward = frame(driver, 22, counts(c5=200), 0.2)["wheel_torque_1"]
    other_side = frame(driver, 23, counts(c5=200), 0.2)["wheel_torque_2"]

    assert forward == pytest.approx(-8.44e-3 * 112 * 0.2)  # eq. 5-3
    assert other_side == pytest.approx(8.44e-3 * 112 * 0.2)


def test_without_a_setpoint_there_is_no_torque(drive):
    driver = drive(IDLE)

    assert frame(driver, 22, counts(c5=200), 0.1)["wheel_torque_1"] == 0


def test_odometry_is_the_mean_way_of_the_driven_wheels(drive):
    driver = drive(CARELESS, states=BOTH_CLAMPED)
    driver.report_all(0.1)
    command(driver, "DriveForward")
    driver.accept()
    turning = {f"theta_{n}": 1.0 if n % 2 else -1.0 for n in range(1, 7)}

    driver.run(10.1, **turning)

    signals = driver.engine.signals(driver.state)
    assert signals["odometry"] == pytest.approx(10 * 0.024, rel=0.05)
    assert signals["speed"] == pytest.approx(0.024)


@pytest.mark.parametrize(("polarity", "sign"), [("normal", 1), ("mirrored", -1)])
def test_forward_is_forward_in_either_polarity(drive, polarity, sign):
    driver = drive(f"polarity: {polarity}\n{CARELESS}", states=DRIVING_FORWARD)
    driver.report_all(0.1)
    turning = {f"theta_{n}": sign * (1.0 if n % 2 else -1.0) for n in range(1, 7)}

    driver.run(1.1, **turning)

    assert driver.engine.signals(driver.state)["speed"] == pytest.approx(0.024)


def test_a_wheel_that_tells_nothing_does_not_spoil_the_odometry(drive):
    driver = drive(CARELESS, states=BOTH_CLAMPED)
    driver.report_all(0.1)
    command(driver, "DriveForward")
    driver.accept()
    driver.signals["theta_3"] = math.nan
    turning = {f"theta_{n}": 1.0 if n % 2 else -1.0 for n in (1, 2, 4, 5, 6)}

    driver.run(10.1, **turning)

    assert driver.engine.signals(driver.state)["odometry"] == pytest.approx(0.24, rel=0.05)


@pytest.mark.parametrize("deaf_s", [0.4, 0.7, 5.0])  # fresh, stale, and silent for this long
def test_what_is_rolled_while_boards_cannot_be_heard_is_not_lost(drive, deaf_s):
    driver = drive(CARELESS, states=BOTH_CLAMPED)
    driver.report_all(0.1)
    command(driver, "DriveForward")
    driver.accept()
    turning = {f"theta_{n}": 1.0 if n % 2 else -1.0 for n in range(1, 7)}
    driver.run(2.0, **turning)
    began_m = driver.engine.signals(driver.state)["odometry"]
    ends_s = 2.0 + deaf_s

    while driver.now < ends_s - 1e-9:
        driver.now += 0.1
        for name, rate in turning.items():
            driver.signals[name] += rate * 0.1
        for board in set(driver.robot.boards) - {24, 25}:
            driver.report(board)
    driver.run(ends_s + 0.3, **turning)

    rolled_m = driver.engine.signals(driver.state)["odometry"] - began_m
    assert rolled_m == pytest.approx((deaf_s + 0.3) * 0.024, abs=0.001)


def test_a_signal_not_heard_for_too_long_is_unknown(drive):
    driver = drive(CARELESS)
    frame(driver, 22, counts(c0=1024, c3=10), 0.1)
    frame(driver, 23, counts(c0=1024, c3=10), 0.5)
    driver.tick(0.61)
    driver.tick(driver.wake_at)

    signals = driver.engine.signals(driver.state)
    assert math.isnan(signals["gamma_1"])
    assert math.isnan(signals["diameter_front"])
    assert signals["gamma_2"] == pytest.approx(math.pi / 2)

    again = frame(driver, 22, counts(c0=1024, c3=99), 0.9)
    assert again["gamma_1"] == pytest.approx(math.pi / 2)
    assert math.isnan(again["omega_1"]), "no rate over the silence"


def test_belief_in_the_first_reading_after_a_silence_needs_it_to_be_possible(drive):
    """The line has damaged it. It was believed, and the next one was a speed of 1e23 m/s."""
    driver = drive(CARELESS, states=DRIVING_FORWARD, doubting=True)
    turning = {f"theta_{n}": 1.0 if n % 2 else -1.0 for n in range(1, 7)}
    driver.run(1.0, **turning)
    began_m = driver.engine.signals(driver.state)["odometry"]
    while driver.now < 1.7:  # board 22 is stale, not silent
        driver.now += 0.1
        for board in set(driver.robot.boards) - {22}:
            driver.report(board)
    values = list(driver.frame(22).values)
    values[BEND_ANGLE], values[WHEEL_ANGLE] = -1000.0, 4.8e27

    shown = frame(driver, 22, tuple(values), 1.8)
    assert (shown["gamma_1"], shown["theta_1"]) == (0.0, pytest.approx(1.0))
    driver.report_all(1.9)
    shown = driver.engine.signals(driver.state)
    assert (shown["gamma_1"], shown["theta_1"]) == (0.0, pytest.approx(1.0))
    assert shown["odometry"] == pytest.approx(began_m, abs=0.005)
    assert driver.faults == []


def test_belief_in_a_counter_that_has_restarted_gives_no_speed_and_no_way(drive):
    driver = drive(CARELESS, states=DRIVING_FORWARD, doubting=True)
    driver.run(1.0, theta_1=1.0, theta_2=-1.0)
    began = driver.engine.signals(driver.state)
    driver.signals["theta_1"] = -1e6

    for at in range(1, 10):
        driver.report_all(1.0 + 0.1 * at)
        shown = driver.engine.signals(driver.state)
        assert shown["omega_1"] == pytest.approx(0.0) or (at == 3 and math.isnan(shown["omega_1"]))

    assert shown["theta_1"] == pytest.approx(-1e6)
    assert shown["odometry"] == pytest.approx(began["odometry"], abs=0.005)
    assert driver.faults == []


def test_the_speed_is_unknown_when_no_wheel_is_heard(drive):
    driver = drive(CARELESS)
    driver.run(0.5, theta_1=1.0)
    assert not math.isnan(driver.engine.signals(driver.state)["speed"])

    driver.tick(1.05)

    assert math.isnan(driver.engine.signals(driver.state)["speed"])


def test_a_channel_without_a_value_is_a_silent_sensor_once(drive):
    driver = drive(CARELESS)
    driver.report_all(0.1)
    driver.signals["gamma_1"] = math.nan

    driver.run(0.5)
    assert driver.faults == [("sensor.silent", "continue")]
    assert driver.of(fx.Fault)[0].message == "gamma_1 has no value"

    driver.signals["gamma_1"] = 0.0
    driver.run(0.8)
    driver.signals["gamma_1"] = math.nan
    driver.run(1.0)
    assert len(driver.faults) == 2, "told again after it had come back"


def test_a_board_that_says_nothing_is_a_silent_sensor_once(drive):
    driver = drive(CARELESS)
    driver.report_all(0.1)
    while driver.now < 3.0:
        driver.now += 0.1
        for board in driver.robot.boards:
            if board != 24:
                driver.report(board)

    assert driver.faults == [("sensor.silent", "continue")]
    assert "board 24 (rotation) has not reported for 1 s" in driver.of(fx.Fault)[0].message


def test_when_no_board_says_anything_the_link_is_silent(drive):
    driver = drive(CARELESS)
    driver.report_all(0.1)
    while not driver.ended and driver.now < 5:
        driver.tick(driver.wake_at)

    assert driver.faults == [("link.silent", "stop")]
    assert 1.1 <= driver.now <= 1.6
    assert driver.ended.outcome == "fault"


def test_a_silent_link_is_noticed_however_long_signals_stay_fresh(drive, tmp_path):
    robot = changed_newt(tmp_path, ("stale_after: 300 ms", "stale_after: 3 h"))
    driver = drive(IDLE, robot)

    while not driver.ended:
        driver.tick(driver.wake_at)

    assert driver.faults == [("link.silent", "stop")]
    assert driver.now <= 1.2


def test_a_frame_that_is_too_short_says_nothing(drive):
    driver = drive(IDLE)

    signals = frame(driver, 22, (1024.0, 1.0), 0.1)

    assert math.isnan(signals["gamma_1"])


@pytest.mark.parametrize("value", [math.inf, -math.inf, 1e308])
def test_a_monstrous_count_does_not_break_the_engine(drive, value):
    driver = drive(CARELESS)

    for at in (0.1, 0.2):
        for board in driver.robot.boards:
            driver.give(ev.SensorFrame(board, (value,) * 9), at)


def test_another_robots_counts_are_converted_by_its_own_profile(drive):
    driver = drive(IDLE, NEWT)
    signals = frame(driver, 3, (500.0, 2048.0, 400.0, 0.0, 0.0), 0.1)

    assert signals["roll_b"] == pytest.approx(math.pi / 2)
    assert signals["neck"] == pytest.approx(math.pi / 2)
    assert signals["neck_torque"] == pytest.approx(0.2)
    assert signals["width_nose"] == pytest.approx(0.08 * math.sin(math.pi / 4) + 0.04)
