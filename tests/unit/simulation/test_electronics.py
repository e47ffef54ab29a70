from __future__ import annotations

from collections.abc import Callable

import pytest

from pirate_sm.core.models import Profile

from .conftest import Driver, straight

Place = Callable[..., Driver]


def setpoints(profile: Profile, **values: float) -> list[float]:
    return [values.get(slot.name, 0.0) for slot in profile.slots]


def test_setpoints_reach_their_motors(profile: Profile, place: Place) -> None:
    robot = place(straight())
    robot.electronics.set_values(setpoints(profile, wheel_2=0.25, bend_1=-0.5))
    duties = {index: duty for index, duty in enumerate(robot.physics.duties.tolist()) if duty}
    n, chain = robot.chain.nodes, robot.chain
    assert duties == {n + chain.wheel_index["wheel_2"]: 0.25, chain.joint_index["gamma_1"]: -0.5}


def test_too_few_setpoints_are_refused(place: Place) -> None:
    assert place(straight()).electronics.refusal([0.0]) == "1 values for 18 slots"


def test_a_setpoint_may_be_out_of_range_by_half_a_step_of_the_wire(
    profile: Profile, place: Place
) -> None:
    electronics = place(straight()).electronics
    step = profile.link.duty_resolution
    assert electronics.refusal(setpoints(profile, wheel_2=1.0 + 0.4 * step)) == ""
    assert "outside -1..1" in electronics.refusal(setpoints(profile, wheel_2=1.0 + 0.6 * step))


def test_setpoints_are_cut_to_what_their_slots_take(profile: Profile, place: Place) -> None:
    cut = place(straight()).electronics.cut(setpoints(profile, wheel_2=-3.0, wheel_3=0.3))
    assert cut == setpoints(profile, wheel_2=-1.0, wheel_3=0.3)


def test_boards_that_start_again_leave_joint_angles_and_count_wheels_anew(place: Place) -> None:
    robot = place(straight())
    robot.clamp(1, 2, 3, 4)
    robot.drive(1.0)
    robot.run(1.0)
    rows, before = robot.electronics.rows, robot.read()
    robot.electronics.restart()
    after = robot.read()
    assert not robot.physics.duties.any()
    assert abs(before[rows["theta_1"]]) > 100
    assert after[rows["theta_1"]] == pytest.approx(0.0, abs=5.0)
    assert after[rows["gamma_1"]] == pytest.approx(before[rows["gamma_1"]], abs=20.0)
