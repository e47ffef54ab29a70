"""Robots of a batch move as each of them does when its cycles pass one by one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from random import Random
from threading import Thread
from typing import Any

import numpy as np
import pytest
from representative import thorough_but

from pirate_sm import UsageError
from pirate_sm.core._model.pipe import Attitude, Blockage, Start
from pirate_sm.core._model.pipe_runs import Elbow, Mitre
from pirate_sm.core.models import Pipe, Profile, Straight, Turns
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.batch import Batch
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.kinematic.world import kinematic
from pirate_sm.simulation.simulated_robot import SimulatedRobot

from .conftest import CYCLE_S

STRAIGHT, BEND = (Straight(straight=2.0),), (Straight(straight=1.0), Mitre(mitre=1.5))
ROUND: dict[str, Any] = {"section": "round", "start": Start(at=0.8)}
PIPES: dict[str, dict[str, Any]] = {
    "bars": {"segments": (*BEND, *STRAIGHT), "start": Start(at=0.9)},
    "bars, upright": {"segments": STRAIGHT, "tilt": 1.5, "uphill": 0.0},
    "bars, blocked": {"segments": STRAIGHT, "blockages": (Blockage(at=1.1, lasting=0.5),)},
    "bars, turned": {"segments": STRAIGHT, "turns": Turns(**{"from": 0.3, "to": 1.0, "tilt": 1.0})},
    "round": {"segments": (*STRAIGHT[:1], Elbow(elbow=1.5, radius=0.18), *STRAIGHT), **ROUND},
    "round, left": {
        "segments": (Straight(straight=1.0),), **ROUND, "frame": Attitude(pitch=-1.0),
    },
}  # fmt: skip
DEFECTS = {
    "none": (), "motors": ("wheels_3_4_dead", "gamma_2_stiff"),
    "values": ("gamma_2_sticks", "gamma_3_spikes"), "boards": ("firmware_reset", "messages_lost"),
}  # fmt: skip
ROBOTS = 3


def robots(profile: Profile, pipe: Pipe, defects: Sequence[str] = ()) -> list[SimulatedRobot]:
    return [
        SimulatedRobot(profile, pipe, kinematic, seed=seed, defects=defects)
        for seed in range(ROBOTS)
    ]


def steps(profile: Profile) -> list[tuple[int, Floats | None]]:
    """For how many cycles which setpoints are in force, a row for each robot."""
    lot, found = Random(3), []
    for cycles in (1, 40, 7, 60, 90, 120):
        rows = [[lot.uniform(-1.2, 1.2) for _ in profile.slots] for _ in range(ROBOTS)]
        found.append((cycles, np.array(rows) if lot.random() < 0.8 else None))
    return found


def one_by_one(profile: Profile, some: Sequence[SimulatedRobot]) -> list[tuple[Any, ...]]:
    """What robots show after each step when every cycle is a call."""
    shown = []
    turns = [robot.turns(one_value=False) for robot in some]
    for cycles, setpoints in steps(profile):
        for row, robot in enumerate(some):
            if setpoints is not None:
                robot.set_values(setpoints[row].tolist())
            for _ in range(cycles):
                now = robot.cycles + 1
                robot.step(now * CYCLE_S, turns[row][now % len(turns[row])])
                robot.meet_obstacles()
            counts = robot.electronics.counts.tolist()
            shown.append((robot.physics.quantities.tolist(), counts, robot.gone, robot.truth))
    return shown


@pytest.mark.parametrize("threads", thorough_but([2], [1, 2, 5]))
@pytest.mark.parametrize("pipe", PIPES)
@pytest.mark.parametrize("defects", thorough_but(["motors", "boards"], DEFECTS))
def test_a_batch_moves_its_robots_as_they_move_alone(
    profile: Profile, pipe: str, defects: str, threads: int
) -> None:
    within = Pipe(diameter=0.12, **PIPES[pipe])
    some = robots(profile, within, DEFECTS[defects])
    batch, shown = Batch(some, profile.link, threads), []
    for cycles, setpoints in steps(profile):
        batch.advance(cycles, setpoints)
        for row, robot in enumerate(some):
            arrays = batch.quantities[row].tolist(), batch.counts[row].tolist()
            shown.append((*arrays, bool(batch.gone[row]), robot.truth))

    assert shown == one_by_one(profile, robots(profile, within, DEFECTS[defects]))


def test_robots_that_leave_the_pipe_are_gone(profile: Profile) -> None:
    batch = Batch(robots(profile, Pipe(diameter=0.12, **PIPES["round, left"])), profile.link)
    assert batch.gone.tolist() == [False] * ROBOTS

    batch.advance(500)

    assert batch.gone.tolist() == [True] * ROBOTS


@pytest.mark.parametrize(("rows", "more", "value"), [(2, 0, 0.0), (3, 1, 0.0), (3, 0, np.nan)])
def test_setpoints_are_a_number_for_each_slot_of_each_robot(
    profile: Profile, rows: int, more: int, value: float
) -> None:
    batch = Batch(robots(profile, Pipe(diameter=0.12, segments=STRAIGHT)), profile.link)

    with pytest.raises(UsageError, match=r"finite numbers of the shape \(3, 18\)"):
        batch.advance(1, np.full((rows, len(profile.slots) + more), value))


@pytest.mark.parametrize("rows", ["x", [["x"]], [[1.0], [1.0, 2.0]], {}])
def test_setpoints_that_are_no_numbers_are_refused(profile: Profile, rows: Any) -> None:
    batch = Batch(robots(profile, Pipe(diameter=0.12, segments=STRAIGHT)), profile.link)

    with pytest.raises(UsageError, match=r"finite numbers of the shape \(3, 18\)"):
        batch.advance(1, rows)


@pytest.mark.parametrize("cycles", [-1, 1.5, "x", None])
def test_cycles_are_a_whole_number(profile: Profile, cycles: Any) -> None:
    batch = Batch(robots(profile, Pipe(diameter=0.12, segments=STRAIGHT)), profile.link)

    with pytest.raises(UsageError, match="cycles: expected a whole number from 0 on, got"):
        batch.advance(cycles)


def test_quantities_have_names(profile: Profile) -> None:
    some = robots(profile, Pipe(diameter=0.12, segments=STRAIGHT))
    batch = Batch(some, profile.link)
    batch.advance(20)

    assert batch.values("arc").tolist() == [robot.arcs_m for robot in some]
    assert len(batch) == len(some)


@pytest.mark.parametrize("pipe", ["bars", "round"])
def test_other_threads_go_on_while_cycles_pass(profile: Profile, pipe: str) -> None:
    robot = robots(profile, Pipe(diameter=0.12, **PIPES[pipe]))[0]
    physics: Any = robot.physics
    around, turns = np.array([CYCLE_S, *robot.leeway]), np.zeros((1, 4), np.int64)
    span = np.zeros(4)
    electronics = robot.electronics
    arrays = electronics.channels, electronics.counts, electronics.rng, span
    most = 4e6
    span[col.X_UNTIL] = most
    place = physics.quantities, physics.roll_angles, robot.arcs, around
    let: Callable[[], None] = partial(physics.pass_cycles, place, turns, *arrays)
    passing = Thread(target=let)
    passing.start()
    while passing.is_alive() and span[col.X_CYCLES] == 0.0:
        pass
    span[col.X_UNTIL] = 0.0
    passing.join()

    assert 0.0 < span[col.X_CYCLES] < most
