"""What a part must bear at least to hold the robot in the mission's pipe."""

from math import sqrt

import pytest

from pirate_sm.core import library
from pirate_sm.core._engine.robot.criteria import TorqueBorne
from pirate_sm.core._loading.mission.loader import holding_in, load_mission

LEG_M, HEIGHT_M, FRICTION, WEIGHT_N = 0.09, 0.072, 0.7, 0.79 * 9.81


def least_nm(loaded, command="ClampFront"):
    """The least torque of each joint that the command's criterion asks for, without a share."""
    done = loaded.robot.commands[loaded.robot.table.command_index[command]].done
    return [load.least_nm for load in done.settled.asked(TorqueBorne)]


@pytest.mark.parametrize(("pipe", "slope"), [("vertical", 1.0), ("straight_turning", 1.0)])
def test_an_apex_bears_the_robot_alone_at_the_steepest_place(pipe, slope):
    apex, other = least_nm(load_mission(library.find_mission("climb"), pipe=pipe))
    pressed_n = 1.25 * WEIGHT_N * slope / FRICTION
    assert apex == pytest.approx(pressed_n * sqrt(LEG_M**2 - HEIGHT_M**2) / 4, rel=0.01)
    assert other == 0.1


def test_a_flat_pipe_asks_for_nothing_more():
    assert least_nm(load_mission(library.find_mission("mitre_bend"))) == [0.1, 0.1]


def test_an_unknown_pipe_may_be_upright(loaded_newt):
    robot = loaded_newt("profile.yaml")
    held = holding_in(robot.normal, robot.profile, None)
    assert [part.joints[0].least_nm > 0.1 for part in held.sight.parts] == [True, True]


def test_a_profile_that_names_a_torque_means_it(loaded_newt):
    swap = ("share: 60 %, at_least: 50 mNm, settled: 1.5 s", "torque: 0.25 Nm")
    absolute = loaded_newt("profile.yaml", swap)
    robot = holding_in(absolute.normal, absolute.profile, None)
    held = robot.commands[robot.table.command_index["HoldNose"]].done
    assert [(load.full_nm, load.least_nm) for load in held.asked(TorqueBorne)] == [(0.0, 0.25)]
    assert held.settled is None


def test_what_is_kept_with_the_robot_of_a_mission_ends_with_the_mission():
    """Compiled triggers are: robots that missions share would keep those of all that ever ran."""
    first, second = (load_mission(library.find_mission("climb")) for _ in range(2))

    assert first.robot is not second.robot
    assert first.robot.commands is second.robot.commands, "raised once"
