"""A robot whose cycles pass without a wire: what its boards read, and what becomes of it."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest

from pirate_sm.core._model.pipe import Attitude, Start
from pirate_sm.core._model.pipe_runs import Junction
from pirate_sm.core.models import Defect, Pipe, PipeRun, Profile, Straight
from pirate_sm.simulation.kinematic.space.space_world import SpaceWorld
from pirate_sm.simulation.kinematic.world import World, kinematic
from pirate_sm.simulation.simulated_robot import SimulatedRobot

from .conftest import CYCLE_S


def robot_in(profile: Profile, defect: Defect | None = None, **more: Any) -> SimulatedRobot:
    pipe = Pipe(**({"diameter": 0.12, "segments": (Straight(straight=2.0),)} | more))
    defects = [] if defect is None else [(defect, np.random.default_rng(1))]
    return SimulatedRobot(profile, pipe, World, seed=1, more_defects=defects)


def run(robot: SimulatedRobot, seconds: float, begin_s: float = 0.0) -> None:
    turns = itertools.cycle(robot.turns(one_value=False))
    for cycle in range(round(seconds / CYCLE_S)):
        robot.step(begin_s + CYCLE_S * (cycle + 1), next(turns))
        robot.meet_obstacles()


def test_an_unclamped_robot_falls_out_and_comes_to_rest(profile: Profile) -> None:
    robot = robot_in(profile, tilt=math.pi / 2, uphill=0.0, start=Start(at=1.0))
    run(robot, 0.2)
    assert not robot.gone
    run(robot, 5.0)
    assert robot.truth.gone
    assert max(robot.arcs_m) < 0.0
    at_rest = robot.truth.wheels
    run(robot, 1.0)
    assert robot.truth.wheels == at_rest


def test_a_robot_that_lies_outside_feels_its_weight(profile: Profile) -> None:
    robot = robot_in(profile, tilt=math.pi / 2, uphill=0.0, start=Start(at=1.0))
    run(robot, 5.0)
    row = robot.electronics.rows["acc_z"]
    assert robot.electronics.counts[row] == pytest.approx(16384, rel=0.03)


def test_a_cycle_reads_the_channels_of_its_turn_only(profile: Profile) -> None:
    robot = robot_in(profile)
    turn = robot.turns(one_value=True)[0]
    before = robot.electronics.counts.copy()
    robot.electronics.physics.duties[:] = 0.5
    for cycle in range(100):
        robot.step(CYCLE_S * (cycle + 1), turn)
    (changed,) = np.nonzero(robot.electronics.counts != before)
    assert set(changed) == {turn.first}
    assert robot.read(2.0, turn) == [robot.electronics.counts[turn.first]]


def test_setpoints_beyond_what_a_slot_takes_are_cut(profile: Profile) -> None:
    robot = robot_in(profile)
    robot.set_values([30.0] * len(profile.slots))
    assert max(robot.duties) == 1.0


def test_a_defect_is_due_at_its_moment(profile: Profile) -> None:
    motion = Defect(kind="stray_motion", description="", after=1.0)
    robot = robot_in(profile, motion)
    assert robot.due_s == 1.0
    assert robot.strike(0.999) == []
    assert [incident.what for incident in robot.strike(1.0)] == ["motor_moves"]
    assert robot.due_s == math.inf
    assert sum(duty != 0.0 for duty in robot.duties) == 1


def test_the_truth_of_a_robot_in_space_has_a_third_coordinate_and_its_run(profile: Profile) -> None:
    pipe = Pipe(
        diameter=0.12,
        section="round",
        segments=(Straight(straight=2.0),),
        start=Start(at=1.0),
    )
    robot = SimulatedRobot(profile, pipe, SpaceWorld, seed=1, start_values=None)
    truth = robot.truth
    assert truth.run == "main"
    assert truth.arc_m == pytest.approx(1.0, abs=0.01)
    assert [z for _, _, z in truth.points] == list(truth.z_m)
    assert len(truth.z_m) == len(truth.wheels)
    # It stands on the floor, which is where the drawing's z points to.
    assert min(truth.z_m) > 0.03
    assert robot.in_space == (truth.z_m, truth.rolls_rad)


def test_the_truth_between_bars_stays_in_its_plane(profile: Profile) -> None:
    truth = robot_in(profile).truth
    assert truth.z_m == ()
    assert {z for _, _, z in truth.points} == {0.0}
    assert len(truth.walls) == 2


@pytest.mark.parametrize("pitch", [-math.pi / 3, 0.0, math.pi / 2])
def test_a_robot_that_leaves_a_round_pipe_is_gone_and_stays_a_number(
    profile: Profile, pitch: float
) -> None:
    pipe = Pipe(
        diameter=0.12, section="round", frame=Attitude(pitch=pitch), start=Start(at=0.8),
        segments=(Straight(straight=1.0),),
    )  # fmt: skip
    robot = SimulatedRobot(profile, pipe, kinematic, seed=1)
    duties = robot.physics.duties
    # It drives out of the flat pipe, clamped; out of the others it slides.
    if pitch == 0.0:
        duties[1:5] = (-0.7, 0.7, -0.7, 0.7)
        duties[6:] = (1.0, -1.0, 1.0, -1.0, 1.0, -1.0)
    run(robot, 20.0)
    assert robot.truth.gone
    assert np.isfinite(robot.physics.quantities).all()


def test_a_robot_in_a_pipe_that_is_not_on_its_route_is_not_gone(profile: Profile) -> None:
    runs = {
        "main": PipeRun(**{"from": "entry"}, to="t", segments=(Straight(straight=1.0),)),
        "on": PipeRun(**{"from": "t.on"}, to="far", segments=(Straight(straight=3.0),)),
        "side": PipeRun(**{"from": "t.branch"}, to="exit", segments=(Straight(straight=1.0),)),
    }
    pipe = Pipe(
        diameter=0.12, section="round", runs=runs, junctions={"t": Junction(tee=math.pi / 2)},
        routes={"in": ("main", "side")}, frame=Attitude(pitch=-math.pi / 2),
        ends={"entry": "open", "far": "closed", "exit": "open"},
    )  # fmt: skip
    robot = SimulatedRobot(profile, pipe, kinematic, seed=1)
    run(robot, 5.0)
    lowest = max(x for x, _, _ in robot.physics.places())
    assert lowest == pytest.approx(4.0 - 0.024, abs=2e-3)  # on the closed end
    assert not robot.truth.gone
