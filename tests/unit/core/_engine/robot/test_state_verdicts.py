"""Exactly where sensors confirm a declared state or clamp, contradict it, or say nothing."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan

import pytest
from driving import IDLE, NEWT

from pirate_sm.core._engine.robot.criteria import HeldSpec, LoadedJoint, SeenSpec
from pirate_sm.core._engine.robot.evidence import SensorVerdict, Shown, shown_by, verdict
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import DECLARED, Mark, at_rest_in
from pirate_sm.core._loading.robot.criteria import angles_shown, wheels_driven, wheels_stand

GRIP, NOSE = Mark("region", 0, DECLARED), Mark("part", 0, DECLARED)
TARGET = angles_shown(((0, 0.0),), within=0.25, beyond=0.5, for_s=1.5)

IMPLIED = SeenSpec("implied", needs=())


class Newt:
    """A newt of which one part is watched, with limits that are exact in binary.

    Its apex joint and another one bear half a newton metre each, it spans the pipe of 1 m.
    """

    def __init__(self, robot: RobotSpec) -> None:
        names = robot.vocabulary.numbers
        folds = [n for n, slot in enumerate(robot.slots) if slot.name in ("fold_neck", "fold_hip")]
        self.apex = robot.slots[folds[0]].angle
        free = [at for at in range(len(names)) if at not in (0, self.apex)]
        self.torque, self.rate, self.torque_2, self.rate_2, self.diameter, self.other = free[:6]
        self.spec = HeldSpec(
            (
                LoadedJoint(folds[0], self.torque, self.rate, 0.5, 0.25),
                LoadedJoint(folds[1], self.torque_2, self.rate_2, 0.5, 0.25),
            ),
            slack=0.125, still=0.0625, diameter=self.diameter, apex=self.apex, open_rad=2.0,
            span=0.125, span_off=0.25, for_s=0.5, settled_s=2.0,
        )  # fmt: skip
        self.robot = robot
        self.names = names
        self.setpoints = tuple(-0.5 if n == folds[1] else 0.5 for n in range(len(robot.slots)))

    def verdict(
        self,
        mark: Mark,
        state: str,
        diameter_m: float | None = 1.0,
        spec=None,
        grip=TARGET,
        second=None,
        **shown,
    ) -> SensorVerdict:
        numbers = [0.0] * len(self.names)
        holding = {"torque": 0.5, "torque_2": -0.5, "diameter": 1.0, "apex": 1.0}
        for name, value in (holding | shown).items():
            numbers[getattr(self, name)] = value
        states = ({"Loose": grip, "NoseHeld": grip, "BothHeld": grip}, *self.robot.sight.states[1:])
        sight = replace(self.robot.sight, parts=(spec or self.spec, second), states=states)
        robot = replace(self.robot, sight=sight)
        found = robot.table.configurations.index((state, "Resting", "Dark"))
        body = at_rest_in(robot, found)
        return verdict(robot, self.setpoints, body, mark, tuple(numbers), diameter_m)

    def held(self, **options) -> SensorVerdict:
        return self.verdict(NOSE, "NoseHeld", **options)

    def loose(self, **options) -> SensorVerdict:
        return self.verdict(GRIP, "Loose", **options)


@pytest.fixture
def newt(drive) -> Newt:
    return Newt(drive(IDLE, NEWT).robot)


@pytest.mark.parametrize(
    ("shown", "agrees", "for_s"),
    [
        ({}, True, 0.5),
        ({"torque": 0.49}, True, 2.0),
        ({"torque": 0.25}, True, 2.0),
        ({"torque": 0.24}, False, 0.5),
        ({"torque_2": -0.25}, True, 2.0),
        ({"torque_2": 0.5}, False, 0.5),
        ({"torque": nan}, False, 0.5),
        ({"rate": 0.0624}, True, 0.5),
        ({"rate": 0.0625}, False, 0.5),
        ({"rate": -0.0625}, False, 0.5),
        ({"diameter": 1.125}, True, 0.5),
        ({"diameter": 0.874}, False, 0.5),
        ({"diameter": 1.25}, False, 0.5),
        ({"torque": 0.125, "torque_2": 0.0}, False, 0.5),
    ],
)
def test_a_part_is_seen_to_hold(newt, shown, agrees, for_s):
    assert newt.held(**shown) == SensorVerdict(agrees, "", for_s)


def test_without_a_longer_time_only_the_whole_torque_counts(newt):
    spec = newt.spec._replace(settled_s=inf)

    assert newt.held(spec=spec) == SensorVerdict(True, "", 0.5)
    assert newt.held(spec=spec, torque=0.49) == SensorVerdict(False, "", 0.5)


def test_what_contradicts_a_part_that_is_declared_to_hold(newt):
    names = newt.names

    wide = newt.held(diameter=1.26)
    assert wide == SensorVerdict(
        False,
        f"{names[newt.diameter]} shows 1260 mm, the pipe has 1000 mm, limit 25% off",
        0.5,
    )
    slack = newt.held(torque=0.1244, torque_2=-0.124)
    assert slack == SensorVerdict(
        False,
        f"{names[newt.torque]}, {names[newt.torque_2]} show 124, 124 mNm, less than 125 mNm",
        0.5,
    )
    assert "it has opened to its end stop" in newt.held(apex=2.0).against
    assert newt.held(apex=1.99).against == ""


@pytest.mark.parametrize(
    ("shown", "told"),
    [
        ({}, True),
        ({"diameter": 1.25}, True),
        ({"diameter": 1.26}, False),
        ({"rate": 0.0625}, False),
        ({"rate_2": -0.0625}, False),
        ({"rate": 0.0624}, True),
    ],
)
def test_a_part_that_seems_to_hold_contradicts_that_nothing_does(newt, shown, told):
    found = newt.loose(**shown)

    assert found.against.startswith("the nose part") == told
    if told:
        assert not found.agrees
        assert found.for_s == 0.5


@pytest.mark.parametrize(
    ("shown", "told"),
    [
        ({"torque": 0.125}, True),
        ({"torque": 0.124}, False),
        ({"torque": -0.4}, False),
        ({"torque": -0.125, "apex": -1.0}, True),
        ({"torque": 0.4, "apex": -1.0}, False),
        ({"torque": 0.4, "diameter": 1.25}, True),
        ({"torque": 0.4, "diameter": 1.26}, False),
        ({"torque": 0.4, "diameter": nan}, False),
        ({"torque": 0.4, "diameter_m": None}, False),
        ({"torque": 0.0, "torque_2": -0.5}, False),
    ],
)
def test_a_part_may_hold_that_presses_by_its_apex_alone(newt, shown, told):
    """The other joint bears nothing."""
    found = newt.loose(**({"torque_2": 0.0} | shown))

    name = newt.names[newt.apex]
    assert (f"bears {abs(shown['torque']) * 1000:.0f} mNm at {name}" in found.against) == told


def test_a_clamp_is_seen_where_no_pipe_is_known_too(newt):
    assert newt.loose(diameter_m=None).against.startswith("the nose part")
    assert "with which it may hold" not in newt.loose().against
    assert "with which it may hold" in newt.loose(torque=0.49).against


@pytest.mark.parametrize(("apex", "told"), [(0.25, False), (-0.25, False), (0.26, True)])
def test_an_apex_at_the_angle_of_the_declared_state_presses_on_nothing(newt, apex, told):
    declared = angles_shown(((newt.apex, 0.0), (0, 5.0)), within=0.25, beyond=inf, for_s=1.5)

    found = newt.loose(grip=declared, apex=apex, torque=0.4, torque_2=0.0)

    assert ("with which it may hold" in found.against) == told


def test_another_angle_at_its_target_or_another_criterion_excuses_no_grip(newt):
    pressed = {"torque": 0.4, "torque_2": 0.0}
    elsewhere = angles_shown(((newt.apex, 0.75), (0, 0.0)), within=0.125, beyond=inf, for_s=1.5)

    assert "with which it may hold" in newt.loose(grip=elsewhere, **pressed).against
    near = angles_shown(((newt.apex, 0.75), (0, 0.0)), within=0.25, beyond=inf, for_s=1.5)
    assert "with which it may hold" not in newt.loose(grip=near, **pressed).against
    assert "with which it may hold" in newt.loose(grip=IMPLIED, **pressed).against


def test_where_a_part_is_declared_to_hold_its_torque_contradicts_no_region(newt):
    assert newt.verdict(GRIP, "NoseHeld") == SensorVerdict(True, "", 1.5)


@pytest.mark.parametrize(
    ("angle", "agrees", "contradicts"),
    [
        (0.25, True, False),
        (-0.25, True, False),
        (0.26, False, False),
        (0.5, False, False),
        (0.51, False, True),
        (-0.51, False, True),
        (nan, False, False),
    ],
)
def test_an_angle_near_its_target_is_seen_and_one_far_from_it_is_not(
    newt, angle, agrees, contradicts
):
    spec = angles_shown(((newt.other, 0.0),), within=0.25, beyond=0.5, for_s=1.5)

    found = newt.loose(grip=spec, other=angle, torque=0.0, torque_2=0.0)

    assert (found.agrees, bool(found.against), found.for_s) == (agrees, contradicts, 1.5)


@pytest.mark.parametrize(
    ("speed", "agrees", "contradicts"),
    [(0.24, True, False), (0.25, False, True), (-0.25, False, True), (nan, False, False)],
)
def test_a_wheel_stands_below_its_limit(newt, speed, agrees, contradicts):
    spec = wheels_stand((newt.other,), below=0.25, for_s=1.5)

    found = newt.verdict(GRIP, "NoseHeld", grip=spec, other=speed)

    assert (found.agrees, bool(found.against), found.for_s) == (agrees, contradicts, 1.5)


@pytest.mark.parametrize(
    ("way", "speed", "contradicts"),
    [
        (1.0, -0.25, False),
        (1.0, -0.26, True),
        (1.0, 9.0, False),
        (-1.0, 0.26, True),
        (-1.0, -9.0, False),
        (1.0, nan, False),
    ],
)
def test_a_driven_wheel_is_never_confirmed_and_contradicted_by_the_other_way(
    newt, way, speed, contradicts
):
    spec = wheels_driven(((newt.other, way),), above=0.25, for_s=1.5)

    found = newt.verdict(GRIP, "NoseHeld", grip=spec, other=speed)

    assert (found.agrees, bool(found.against), found.for_s) == (False, contradicts, 1.5)


def test_what_no_sensor_shows_is_neither_confirmed_nor_contradicted(newt):
    assert newt.verdict(GRIP, "NoseHeld", grip=SeenSpec("accepted")) == SensorVerdict(False, "")
    assert newt.verdict(GRIP, "TailHeld") == SensorVerdict(False, "")
    assert newt.verdict(GRIP, "NoseHeld", grip=IMPLIED) == SensorVerdict(True, "")


class TestShown:
    """The signals that decide about a state, for people, before and now."""

    @pytest.fixture
    def rows(self, newt):
        numbers = range(len(newt.names))
        before, now = tuple(0.001 * at for at in numbers), tuple(0.5 + 0.001 * at for at in numbers)

        def shown(spec, diameter_m: float | None = 0.12) -> list[tuple[str, ...]]:
            return [tuple(each) for each in shown_by(newt.robot, spec, before, now, diameter_m)]

        return shown

    def test_of_a_part(self, newt, rows):
        first, second, span = rows(newt.spec)

        at = newt.torque
        assert first == (
            newt.names[at], f"{at} mNm", f"{500 + at} mNm", "500 mNm or more, slack below 125 mNm",
        )  # fmt: skip
        assert second[0] == newt.names[newt.torque_2]
        at = newt.diameter
        limit = "within 12%, off beyond 25%"
        assert span == (newt.names[at], f"{at} mm", f"{500 + at} mm", f"120 mm {limit}")
        assert rows(newt.spec, None)[2][3] == f"the other parts {limit}"

    def test_of_angles(self, newt, rows):
        spec = angles_shown(((2, 0.5),), within=0.25, beyond=0.5, for_s=1.5)

        assert rows(spec) == [
            (newt.names[2], "0.1 deg", "28.8 deg", "29 deg within 14 deg, off beyond 29 deg")
        ]
        endless = angles_shown(((2, 0.5),), within=0.25, beyond=inf, for_s=1.5)
        assert rows(endless)[0][3] == "29 deg within 14 deg"

    def test_of_wheels(self, newt, rows):
        standing = wheels_stand((3,), below=0.25, for_s=1.5)
        driven = wheels_driven(((4, -1.0),), above=0.25, for_s=1.5)

        assert rows(standing) == [(newt.names[3], "0.00 rad/s", "0.50 rad/s", "below 0.25 rad/s")]
        limit = "not above 0.25 rad/s the other way"
        assert rows(driven) == [(newt.names[4], "0.00 rad/s", "0.50 rad/s", limit)]

    @pytest.mark.parametrize("spec", [IMPLIED, SeenSpec("accepted"), None])
    def test_of_what_no_signal_decides(self, rows, spec):
        assert rows(spec) == []

    def test_an_unknown_value_is_said_to_be_so(self, newt):
        spec = wheels_stand((0,), below=0.25, for_s=1.5)
        blind, seen = (nan,) * len(newt.names), (1.0,) * len(newt.names)

        assert shown_by(newt.robot, spec, blind, seen, None) == (
            Shown(newt.names[0], "unknown", "1.00 rad/s", "below 0.25 rad/s"),
        )


def test_the_error_of_a_diameter_is_a_share_of_the_pipes(newt):
    assert newt.held(diameter=2.25, diameter_m=2.0).agrees
    assert not newt.held(diameter=2.26, diameter_m=2.0).agrees


@pytest.mark.parametrize(
    ("diameter", "other", "agrees", "contradicts"),
    [
        (2.25, 2.0, True, False),
        (2.26, 2.0, False, False),
        (2.5, 2.0, False, False),
        (2.51, 2.0, False, True),
        (nan, 2.0, False, False),
        (2.0, nan, False, False),
    ],
)
def test_where_no_pipe_is_known_parts_that_hold_must_agree(
    newt, diameter, other, agrees, contradicts
):
    second = newt.spec._replace(diameter=newt.other)

    found = newt.verdict(NOSE, "BothHeld", None, second=second, diameter=diameter, other=other)

    assert (found.agrees, bool(found.against)) == (agrees, contradicts)
    if contradicts:
        names = newt.names
        assert found.against == (
            f"{names[newt.diameter]} shows 2510 mm, {names[newt.other]} 2000 mm, limit 25% off"
        )


def test_a_part_that_no_sensor_measures_is_not_compared(newt):
    assert newt.verdict(NOSE, "BothHeld", None).agrees


def test_a_motor_without_a_setpoint_may_bear_either_way(newt):
    newt.setpoints = (0.0,) * len(newt.setpoints)

    assert newt.held(torque=-0.5, torque_2=0.5).agrees
    assert newt.held(torque=0.5, torque_2=-0.5).agrees


def test_a_clamp_is_described_by_what_its_joints_bear(newt):
    found = newt.loose(torque=0.6004, diameter=1.25)

    assert "600, 500" in found.against
    assert "with which it may hold" not in found.against


def test_the_joint_of_the_apex_is_found_wherever_it_is_named(newt):
    spec = newt.spec._replace(joints=newt.spec.joints[::-1])

    pressed = newt.loose(spec=spec, torque=0.4, torque_2=0.0)
    assert "bears 400 mNm" in pressed.against
    assert newt.loose(spec=spec, torque=0.0, torque_2=0.5).against.count("bears") == 0


def test_grips_are_looked_for_only_where_a_region_of_the_part_is_declared(newt):
    assert newt.verdict(NOSE, "Loose") == SensorVerdict(True, "", 0.5)
    assert newt.verdict(Mark("region", 2, DECLARED), "Loose").against == ""


@pytest.mark.parametrize(
    ("angle", "agrees", "contradicts"),
    [(1.25, True, False), (0.0, False, True), (1.5, False, False), (1.51, False, True)],
)
def test_an_angle_is_compared_with_its_target(newt, angle, agrees, contradicts):
    spec = angles_shown(((newt.other, 1.0),), within=0.25, beyond=0.5, for_s=1.5)

    found = newt.verdict(GRIP, "NoseHeld", grip=spec, other=angle)

    assert (found.agrees, bool(found.against)) == (agrees, contradicts)
