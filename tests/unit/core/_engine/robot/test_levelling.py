"""A part is turned to an angle against the horizontal, by what the accelerometer shows."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from driving import BOTH_CLAMPED, FRONT_CLAMPED, IDLE, REAR_CLAMPED, ROOT, Driver, command
from representative import thorough_but

from pirate_sm.core._model import events as ev

IMU = ROOT / "hardware_profiles" / "pirate_ii_imu"
G = 9.81
APEX = math.radians(106)
HELD = {
    "rear": {"gamma_1": -1.8, "gamma_2": 1.7, "gamma_3": -1.7, "gamma_4": APEX},
    "front": {"gamma_1": -APEX, "gamma_2": 1.7, "gamma_3": -1.7, "gamma_4": 1.8},
}
"""The oblique module of a part that holds while the other one is relaxed."""

LYING = {
    "rear": {"gamma_1": 0.0, "gamma_2": 0.0, "gamma_3": -APEX / 2, "gamma_4": APEX},
    "front": {"gamma_1": -APEX, "gamma_2": APEX / 2, "gamma_3": 0.0, "gamma_4": 0.0},
}
STATES = {"rear": REAR_CLAMPED, "front": FRONT_CLAMPED}


def turned(a: float, b: float, angle: float) -> tuple[float, float]:
    c, s = math.cos(angle), math.sin(angle)
    return c * a - s * b, s * a + c * b


class Robot:
    """A robot in a straight pipe, one part of which holds at a roll, and what its boards show."""

    def __init__(self, drive, holder: str, roll_deg: float, pitch_deg: float = 0.0, **more) -> None:
        states = more.pop("states", STATES[holder])
        self.driver: Driver = drive(more.pop("mission", IDLE), robot=IMU, states=states, **more)
        self.holder, self.roll, self.pitch = holder, math.radians(roll_deg), math.radians(pitch_deg)
        self.phi = 0.0
        self.shaking = 0.0
        self.shown: dict[str, float] = {}
        self.stand(0.1, HELD[holder])

    def stand(self, seconds: float, angles: dict[str, float] | None = None) -> None:
        """It stands for a while; every array is accepted, and the joints obey if they are told."""
        self.shown = {**self.shown, **(angles or {})}
        self.driver.signals |= {**self.shown, "bend_torque_1": -0.7, "bend_torque_4": 0.7}
        until = self.driver.now + seconds
        while self.driver.now < until - 1e-9:
            self.driver.signals |= {"phi": self.phi, **self.felt()}
            self.driver.run(self.driver.now + 0.1)
            if self.driver.in_flight:
                self.driver.accept()

    def felt(self) -> dict[str, float]:
        """The accelerometer on the front half of the module that the holding part holds."""
        flat = math.cos(self.pitch)
        ahead, side_b, up = (
            G * math.sin(self.pitch) + self.shaking,
            -G * flat * math.sin(self.roll),
            G * flat * math.cos(self.roll),
        )
        robot, names = self.driver.robot, self.driver.robot.vocabulary.numbers
        numbers = [self.driver.signals.get(name, 0.0) for name in names]
        numbers[names.index("diameter_front")] = numbers[names.index("diameter_rear")] = 0.12
        part = robot.parts.index(self.holder)
        heading = robot.body.heading_in_pipe(numbers, part, robot.body.roll_link)
        ahead, side_b = turned(ahead, side_b, heading)
        if self.holder == "rear":
            side_b, up = turned(side_b, up, self.phi)
        return {"acc_x": ahead, "acc_y": side_b, "acc_z": up}

    def order(self, name: str) -> None:
        command(self.driver, name)
        if self.driver.in_flight:
            self.driver.accept()

    def level(self, name: str = "AlignHorizontal") -> None:
        """The command is given, the posture is taken, and gravity is measured."""
        self.order(name)
        self.stand(1.5, LYING[self.holder])

    @property
    def sent_deg(self) -> float:
        return math.degrees(self.driver.array["rotate"])

    def turn(self) -> None:
        """The roll joint comes to its setpoint."""
        self.phi = self.driver.array["rotate"]
        self.stand(1.0)

    @property
    def reason(self) -> str:
        return self.driver.last_status.reason


def as_planes(angle_deg: float) -> float:
    return math.remainder(angle_deg, 180.0)


@pytest.mark.parametrize("roll_deg", thorough_but([-150, -60, 30, 90], range(-150, 181, 30)))
@pytest.mark.parametrize(("name", "target_deg"), [("AlignHorizontal", 0), ("AlignVertical", 90)])
@pytest.mark.parametrize("holder", ["rear", "front"])
def test_the_part_that_does_not_hold_comes_into_the_plane(
    drive, holder, name, target_deg, roll_deg
):
    robot = Robot(drive, holder, roll_deg)
    robot.level(name)

    ways = 1 if holder == "rear" else -1
    rolled = roll_deg + ways * robot.sent_deg
    assert as_planes(rolled - target_deg) == pytest.approx(0.0, abs=0.2)
    assert abs(robot.sent_deg) <= 90.2, "the nearer of two ways"
    if abs(robot.sent_deg) > 3:
        assert robot.driver.last_status.status == "accepted"

    robot.turn()
    assert robot.driver.last_status.status == "done"
    assert robot.reason.endswith("deg off, as the accelerometer shows")
    assert robot.driver.unconfirmed == set()


def test_from_where_the_roll_joint_stands_it_takes_the_nearer_way(drive):
    robot = Robot(drive, "rear", -99.5)
    robot.phi = math.radians(60)
    robot.stand(0.2)
    robot.level()
    assert robot.sent_deg == pytest.approx(99.5, abs=0.1)


def test_a_holder_that_gives_way_is_corrected_once(drive):
    robot = Robot(drive, "rear", -40.0)
    robot.level()
    robot.roll -= math.radians(5)
    robot.turn()
    assert robot.driver.last_status.status == "accepted"
    assert robot.sent_deg == pytest.approx(45.0, abs=0.2)

    robot.turn()
    assert robot.driver.last_status.status == "done"


def test_a_holder_that_gives_way_again_fails_with_the_angle(drive):
    robot = Robot(drive, "rear", -40.0)
    robot.level()
    for _ in range(2):
        robot.roll -= math.radians(5)
        robot.turn()

    assert robot.driver.last_status.status == "failed"
    assert robot.reason == "still 5.0 deg off after a correction, more than 3 deg"


def test_a_small_error_is_left(drive):
    robot = Robot(drive, "front", 20.0)
    robot.level()
    robot.roll += math.radians(2)
    robot.turn()
    assert robot.reason == "2.0 deg off, as the accelerometer shows"


@pytest.mark.parametrize("holder", ["rear", "front"])
@pytest.mark.parametrize("pitch_deg", [-75, 70])
def test_in_a_steep_pipe_it_is_impossible_before_anything_moves(drive, holder, pitch_deg):
    robot = Robot(drive, holder, 20.0, pitch_deg)
    robot.order("AlignHorizontal")
    robot.stand(0.2)

    assert robot.driver.last_status.status == "failed"
    steep = f"the pipe is {abs(pitch_deg)} deg steep here"
    assert robot.reason == f"impossible: {steep}, and in more than 60 deg gravity shows no roll"
    held = {"rear": {"bend_3": -0.7, "bend_4": 0.7}, "front": {"bend_1": -0.7, "bend_2": 0.7}}
    assert robot.driver.nonzero == pytest.approx(held[holder])


@pytest.mark.parametrize("pitch_deg", [-30, 20])
def test_in_a_slope_it_is_impossible_where_a_leaning_part_hides_the_roll(drive, pitch_deg):
    robot = Robot(drive, "rear", 20.0, pitch_deg)
    robot.order("AlignHorizontal")
    robot.stand(0.2)

    assert robot.driver.last_status.status == "failed"
    roll_deg = 9 * math.tan(math.radians(abs(pitch_deg)))
    assert robot.reason == (
        f"impossible: the pipe is {abs(pitch_deg)} deg steep here; a part that leans by 9 deg in "
        f"it shows its roll to {roll_deg:.1f} deg only, and 3 deg are asked for"
    )
    assert robot.driver.nonzero == pytest.approx({"bend_3": -0.7, "bend_4": 0.7})


@pytest.mark.parametrize("pitch_deg", [-18, 18])
def test_in_a_gentle_slope_it_is_possible(drive, pitch_deg):
    robot = Robot(drive, "rear", 20.0, pitch_deg)
    robot.level()
    assert robot.sent_deg == pytest.approx(-20.0, abs=0.5)


@pytest.mark.parametrize("holder", ["rear", "front"])
def test_the_angle_at_which_a_part_holds_its_module_is_no_slope(drive, holder):
    across = []
    for pitch_deg in (-18.0, 18.0):
        robot = Robot(drive, holder, -80.0, pitch_deg)
        across.append(math.hypot(robot.driver.signals["acc_y"], robot.driver.signals["acc_z"]))
        robot.level()
        assert robot.sent_deg == pytest.approx(80.0 if holder == "rear" else -80.0, abs=0.5)
    assert min(across) < G / 2, "the module looked as in a pipe of 60 deg and more"


def test_beyond_the_range_of_the_joint_it_is_impossible_and_says_both_angles(drive):
    robot = Robot(drive, "rear", -80.0)
    driver = robot.driver
    slots = tuple(
        replace(slot, low=-math.radians(60), high=math.radians(60))
        if slot.unit == "angle"
        else slot
        for slot in driver.robot.slots
    )
    driver.robot = replace(driver.robot, slots=slots)
    driver.engine.robot = driver.robot
    robot.level()

    assert driver.last_status.status == "failed"
    assert robot.reason == (
        "impossible: phi would have to turn to 80.0 or -100.0 deg, and turns to ±60 deg at most"
    )


def test_a_shaken_robot_is_not_measured(drive):
    robot = Robot(drive, "rear", -40.0)
    robot.shaking = 6.0
    robot.order("AlignHorizontal")
    robot.stand(40.5, LYING["rear"])

    assert robot.driver.array["rotate"] == 0.0
    assert robot.driver.last_status.status == "failed"
    assert robot.reason.startswith("not done within 40 s: the accelerometer does not show")


def test_an_unknown_direction_of_gravity_turns_nothing(drive):
    mission = f"on_fault: [{{fault: sensor.silent, then: continue}}]\n{IDLE}"
    robot = Robot(drive, "rear", -40.0, mission=mission)
    robot.felt = lambda: {"acc_x": math.nan, "acc_y": math.nan, "acc_z": math.nan}
    robot.order("AlignHorizontal")
    robot.stand(40.5, LYING["rear"])

    assert robot.driver.array["rotate"] == 0.0
    assert robot.driver.last_status.status == "failed"


def test_it_is_measured_again_when_the_joint_is_there_not_on_the_way(drive):
    robot = Robot(drive, "rear", -40.0)
    robot.level()
    target = robot.driver.array["rotate"]
    for share in (0.25, 0.5, 0.75):
        robot.phi = target * share
        robot.stand(0.7)
        assert robot.driver.last_status.status == "accepted"
        assert robot.driver.array["rotate"] == target
    robot.turn()
    assert robot.driver.last_status.status == "done"


@pytest.mark.parametrize(
    ("states", "reason"),
    [
        (BOTH_CLAMPED, "DoubleClamped"),
        ({}, "impossible: exactly one part must hold, confirmed, while the other one turns"),
    ],
)
def test_it_needs_one_part_that_holds(drive, states, reason):
    robot = Robot(drive, "rear", 10.0, states=states)
    command(robot.driver, "AlignHorizontal")
    assert robot.driver.statuses[-1:] != [("AlignHorizontal", "sent")]
    told = " ".join([*robot.driver.messages, robot.reason if robot.driver.statuses else ""])
    assert reason in told


def test_it_needs_a_part_whose_hold_is_confirmed(drive):
    robot = Robot(drive, "rear", 10.0, declared=True)
    robot.driver.signals |= {"bend_torque_4": 0.3}
    command(robot.driver, "AlignHorizontal")
    assert ("AlignHorizontal", "sent") not in robot.driver.statuses


def test_driven_wheels_are_refused(drive):
    states = {**REAR_CLAMPED, "RearWheelsState": "DrivingForward"}
    robot = Robot(drive, "rear", 10.0, states=states)
    robot.order("AlignHorizontal")
    robot.stand(0.2)
    assert robot.reason == (
        "impossible: wheels are driven, and the inclination is measured at rest; brake first"
    )


def test_what_was_felt_before_the_controller_was_away_is_not_measured_with(drive):
    mission = f"on_fault: [{{fault: link.interrupted, then: continue}}]\n{IDLE}"
    robot = Robot(drive, "rear", -40.0, mission=mission)
    robot.order("AlignHorizontal")
    robot.stand(0.7, LYING["rear"])
    memory = robot.driver.state.robot.motion.levelling
    assert memory.felt
    assert not math.isnan(memory.since_s)

    robot.driver.give(ev.FaultReport("link.interrupted", "the link is back", 2.0))

    memory = robot.driver.state.robot.motion.levelling
    assert not memory.felt
    assert math.isnan(memory.since_s)


def test_a_mission_can_go_on_otherwise(drive):
    mission = (
        "start: a\n"
        "phases:\n"
        "  a: {do: [{command: AlignHorizontal, on_failure: b}], go: level}\n"
        "  b: {do: [ClampFront], go: as_it_lies}\n"
        "ends:\n"
        "  level: {succeed: Level}\n"
        '  as_it_lies: {succeed: "As it lies: {cause}"}\n'
    )
    robot = Robot(drive, "rear", 20.0, 70.0, mission=mission)
    robot.stand(1.0)
    assert robot.driver.phases[-1] == "b"
    assert robot.driver.statuses[-2:] == [("ClampFront", "sent"), ("ClampFront", "accepted")]


def test_without_sensors_it_takes_its_nominal_time(drive):
    driver = drive(
        "start: a\nphases: {a: {do: [AlignHorizontal], go: e}}\nends: {e: {succeed: ok}}\n",
        robot=IMU,
        states=REAR_CLAMPED,
        nominal=True,
    )
    driver.accept()
    while not driver.ended:
        if driver.in_flight:
            driver.accept()
        driver.give(ev.Tick(), driver.wake_at)
    assert driver.ended.outcome == "succeeded"
    assert ("AlignHorizontal", "done") in driver.statuses
    assert driver.array["rotate"] == 0.0
