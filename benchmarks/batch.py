"""Many robots in one call, beside one robot with the interpreter.

    python -m benchmarks.batch [--robots 32] [--threads N]

A mission is run, and which setpoints came into force in which cycle is kept. Then a batch of robots
gets the same setpoints in the same cycles, without an engine, and ends where the mission has ended,
to the last bit. Both are measured in turn; × real time is mission seconds of all robots per second
of processor time, so per core, and the least time of each counts. The last column is by the wall
clock, on as many threads as given.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from functools import partial
from time import perf_counter, process_time
from typing import NamedTuple

import numpy as np

from pirate_sm.backends.simulated import SimulatorBackend
from pirate_sm.companion import entered
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.model.fidelity import Fidelity
from pirate_sm.runtime.first_choice import FirstChoice
from pirate_sm.runtime.loop import MissionRun
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.batch import Batch
from pirate_sm.simulation.simulated_robot import SimulatedRobot
from pirate_sm.simulation.xpbd.kinematic import kinematic
from pirate_sm.wiring import Order, load, prepare
from pirate_sm.wiring.sim import start_values

MISSIONS = ("mitre_bend", "take_elbow", "house_connection")
FIDELITIES: tuple[Fidelity, ...] = ("usual", "fast")
REPEATS = 7


class Course(NamedTuple):
    """What a mission has put in force.

    Attributes:
        stretches: Setpoints, and for how many cycles they were in force; None: those of the start.
        quantities: The true quantities at the end.
        time_s: How long it has taken, in mission time; ``cpu_s``: of the processor.
    """

    stretches: list[tuple[tuple[float, ...] | None, int]]
    quantities: Floats
    time_s: float
    cpu_s: float


def course_of(loaded: LoadedMission, order: Order) -> Course:
    """Run a mission with the interpreter."""
    prepared = prepare(order, loaded)
    backend = prepared.backend
    assert isinstance(backend, SimulatorBackend)
    begins: list[tuple[tuple[float, ...] | None, int]] = [(None, 0)]
    robot, put = backend.robot, backend.robot.electronics.set_values

    def noting(values: Iterable[float]) -> None:
        given = tuple(values)
        begins.append((given, robot.cycles))
        put(given)

    robot.electronics.set_values = noting  # type: ignore[method-assign]
    run = MissionRun(prepared.engine, backend, companions=(*prepared.companions, FirstChoice()))
    with entered(prepared.companions):
        began = process_time()
        result = run.execute()
        cpu_s = process_time() - began
    ends = [*(begin for _, begin in begins[1:]), robot.cycles]
    stretches = [(values, end - begin) for (values, begin), end in zip(begins, ends, strict=True)]
    return Course(stretches, robot.physics.quantities.copy(), result.now_s, cpu_s)


def replayed(
    loaded: LoadedMission, course: Course, fidelity: Fidelity, robots: int, threads: int | None
) -> tuple[float, float]:
    """Return processor time and time of the wall clock of a batch on the course of a mission."""
    assert loaded.pipe is not None
    profile = loaded.loaded_robot.profile
    some = [
        SimulatedRobot(
            profile, loaded.pipe, partial(kinematic, fidelity=fidelity),
            seed=seed, start_values=start_values(loaded),
        )
        for seed in range(robots)
    ]  # fmt: skip
    for robot in some:
        robot.hold()
    batch = Batch(some, profile.link, threads)
    began, began_s = process_time(), perf_counter()
    for values, cycles in course.stretches:
        batch.advance(cycles, None if values is None else np.tile(values, (robots, 1)))
    took = process_time() - began, perf_counter() - began_s
    assert (batch.quantities == course.quantities).all(), "a batch has gone another way"
    return took


def main() -> int:
    """Print a line for each mission and fidelity."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=32)
    parser.add_argument("--threads", type=int, help="one for each processor by default")
    wishes = parser.parse_args()
    for mission in MISSIONS:
        usual = 0.0
        for fidelity in FIDELITIES:
            order = Order(mission, fidelity=fidelity)
            loaded = load(order)
            pairs = []
            for _ in range(REPEATS):
                course = course_of(loaded, order)
                pairs.append(
                    (
                        course,
                        replayed(loaded, course, fidelity, wishes.robots, 1),
                        replayed(loaded, course, fidelity, wishes.robots, wishes.threads),
                    )
                )
            time_s = wishes.robots * course.time_s
            single = course.time_s / min(each.cpu_s for each, _, _ in pairs)
            core = time_s / min(one[0] for _, one, _ in pairs)
            shared = time_s / min(each[0] for _, _, each in pairs)
            wall = time_s / min(each[1] for _, _, each in pairs)
            usual = usual or core
            print(
                f"{mission:17} {fidelity:5}: one with the interpreter {single:6,.0f} × real time, "
                f"batch {core:6,.0f} per core = {core / single:.2f} ×, {core / usual:.2f} × usual; "
                f"threads: {shared:6,.0f} per core, {wall:6,.0f} in all"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
