"""Exactly where the criterion of a command is met."""

from __future__ import annotations

from math import nan

import pytest

from pirate_sm.core._engine.robot.actuation_spec import PositionSpec, TorqueSpec
from pirate_sm.core._engine.robot.criteria import (
    AngleSet,
    Bound,
    CriterionSpec,
    Demand,
    JointsArrived,
    TorqueBorne,
    WheelTurning,
    needs_of_signals,
    only,
    standing,
)
from pirate_sm.core._engine.robot.loops import RunningPositionLoop, RunningTorqueLoop

RATE, TORQUE, ANGLE, SPEED, OTHER = range(5)


def seen(**shown: float) -> tuple[float, ...]:
    names = ("rate", "torque", "angle", "speed", "other")
    return tuple(shown.get(name, 0.0) for name in names)


def torque_loop(asked_nm: float, torque: int = TORQUE) -> RunningTorqueLoop:
    spec = TorqueSpec(
        **dict.fromkeys(TorqueSpec._fields, 0.0) | {"torque": torque, "within_nm": 0.125}
    )
    return RunningTorqueLoop(0, spec, asked_nm)


def position_loop(target_rad: float) -> RunningPositionLoop:
    spec = PositionSpec(**dict.fromkeys(PositionSpec._fields, 0.5) | {"threshold_rad": 0.125})
    return RunningPositionLoop(0, ANGLE, RATE, TORQUE, spec, target_rad)


def criterion(*demands: Demand, for_s: float = 0.0) -> CriterionSpec:
    return CriterionSpec("", "", "", demands, for_s)


BORNE = TorqueBorne(TORQUE, 0, 1.0, 0.25)
STALLED = criterion(only(Bound(RATE, "<", 0.5)), BORNE, for_s=1.5)


@pytest.mark.parametrize(
    ("rate", "torque", "duty", "met"),
    [
        (0.49, 0.6, 0.5, True),
        (0.5, 0.6, 0.5, False),
        (-0.5, 0.6, 0.5, False),
        (nan, 0.6, 0.5, False),
        (0.0, 0.5, 0.5, False),
        (0.0, 0.51, 0.5, True),
        (0.0, -0.51, 0.5, True),
        (0.0, 0.25, 0.0, False),
        (0.0, 0.26, 0.0, True),
        (0.0, nan, 0.0, False),
    ],
)
def test_a_joint_is_stalled_that_stands_and_bears_more_than_it_must(rate, torque, duty, met):
    assert STALLED.holds(seen(rate=rate, torque=torque), (duty,), ()) == met


@pytest.mark.parametrize(
    ("asked_nm", "torque", "met"),
    [
        (0.0, nan, True),
        (1.0, 0.9, True),
        (1.0, 0.875, True),
        (1.0, 0.87, False),
        (1.0, nan, False),
        (-1.0, 0.9, False),
    ],
)
def test_a_joint_under_a_torque_loop_bears_the_torque_of_its_loop(asked_nm, torque, met):
    loops = (position_loop(0.0), torque_loop(9.0, OTHER), torque_loop(asked_nm))

    assert criterion(BORNE).holds(seen(torque=torque), (1.0,), loops) == met


REACHED = criterion(JointsArrived(still=0.5, loaded=0.5, least_nm=0.25), for_s=1.5)


@pytest.mark.parametrize(
    ("rate", "torque", "duty", "met"),
    [
        (0.49, 0.51, 1.0, True),
        (0.49, 0.5, 1.0, False),
        (0.5, 0.51, 1.0, False),
        (-0.5, 0.51, 1.0, False),
        (0.0, -0.51, 1.0, False),
        (0.0, -0.51, -1.0, True),
        (0.0, 0.26, 0.25, True),
        (0.0, 0.25, 0.25, False),
        (0.0, 9.0, 0.0, False),
        (nan, 9.0, 1.0, False),
    ],
)
def test_a_joint_that_is_pushed_and_stands_is_stopped_by_a_wall(rate, torque, duty, met):
    spec = position_loop(0.25).spec._replace(stall_torque_nm=1.0)
    loop = position_loop(0.25)._replace(spec=spec)

    assert REACHED.holds(seen(rate=rate, torque=torque), (duty,), (loop,)) == met


def test_every_position_loop_must_have_come_to_its_angle():
    here, there = position_loop(0.125), position_loop(0.25)
    still = seen(rate=9.0)

    assert REACHED.holds(still, (0.0,), (here, torque_loop(1.0)))
    assert not REACHED.holds(still, (0.0,), (here, there))
    assert REACHED.must_hold_s(still, (here,)) == 0.0
    assert REACHED.must_hold_s(still, (here, there)) == 1.5


@pytest.mark.parametrize(
    ("speed", "setpoint", "met"),
    [
        (0.51, 1.0, True),
        (0.5, 1.0, False),
        (-0.51, 1.0, False),
        (-0.51, -1.0, True),
        (0.51, 0.0, False),
        (nan, 1.0, False),
    ],
)
def test_a_wheel_turns_the_way_it_is_driven(speed, setpoint, met):
    turning = criterion(WheelTurning(((1, OTHER), (0, SPEED)), above=0.5))

    assert turning.holds(seen(speed=speed), (setpoint, 0.0), ()) == met


@pytest.mark.parametrize(
    ("speed", "other", "met"),
    [
        (0.49, nan, True),
        (0.5, nan, False),
        (-0.5, 0.0, False),
        (nan, 0.49, True),
        (nan, nan, False),
    ],
)
def test_wheels_stand_if_one_is_heard_and_none_turns(speed, other, met):
    numbers = seen(speed=speed, other=other)

    one_part = standing((SPEED, OTHER), 0.5)
    assert criterion(*one_part).holds(numbers, (), ()) == met
    two_parts = criterion(*one_part, *standing((RATE,), 0.5))
    assert not two_parts.holds(seen(rate=nan), (), ())


@pytest.mark.parametrize(
    ("angle", "met"), [(1.5, True), (0.5, True), (1.51, False), (0.49, False), (nan, False)]
)
def test_an_angle_is_at_its_setpoint(angle, met):
    assert criterion(AngleSet(0, ANGLE, within=0.5)).holds(seen(angle=angle), (1.0,), ()) == met


@pytest.mark.parametrize(
    ("value", "met"), [(0.49, True), (0.5, False), (-0.5, False), (nan, False)]
)
def test_a_signal_is_near_zero(value, met):
    assert criterion(only(Bound(OTHER, "<", 0.5))).holds(seen(other=value), (), ()) == met


def test_some_criteria_must_hold_for_a_time():
    assert STALLED.must_hold_s(seen(), ()) == 1.5
    assert criterion().must_hold_s(seen(), ()) == 0.0


def test_a_criterion_without_demands_is_met():
    assert criterion().holds((), (), ())


@pytest.mark.parametrize(
    ("demand", "heard", "missing"),
    [
        (AngleSet(0, ANGLE, 0.5), {ANGLE}, ()),
        (AngleSet(0, ANGLE, 0.5), {RATE}, (ANGLE,)),
        (WheelTurning(((1, OTHER), (0, SPEED)), 0.5), {SPEED}, ()),
        (WheelTurning(((1, OTHER), (0, SPEED)), 0.5), {ANGLE}, (OTHER,)),
        (JointsArrived(0.5, 0.5), set(), ()),
        (standing((SPEED, OTHER), 0.5)[0], {OTHER}, ()),
        (standing((SPEED, OTHER), 0.5)[0], {ANGLE}, (SPEED,)),
        (standing((SPEED, OTHER), 0.5)[1], set(), ()),
    ],
)
def test_signals_that_nobody_measures_keep_a_criterion_from_being_met(demand, heard, missing):
    needs = needs_of_signals(criterion(demand), 2)

    assert tuple(at for need in needs for at in need.unheard(frozenset(heard))) == missing
