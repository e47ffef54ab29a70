"""Many robots at once, beside one robot with the interpreter.

    python -m benchmarks.batch [--robots 32] [--threads N] [--mission NAME] [--repeats 7]

A mission is run, and which setpoints came into force in which cycle is kept. Then a batch of robots
gets the same setpoints in the same cycles, without an engine, and ends where the mission has ended,
to the last bit. Mission, batch on one thread and batch on several are measured in turn, and the
least time of each counts. × real time is mission seconds of all robots per second of processor
time, so per core; only the last number of a line is by the wall clock.

Then whole missions, engine and all, on one thread, on several, and in as many processes that have
begun before: missions per second of the wall clock, in turn, the most of each.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from os import cpu_count
from time import perf_counter, process_time
from typing import NamedTuple

import numpy as np

from benchmarks import gliding
from pirate_sm.core.companion import entered
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.options import Fidelity
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, load, prepare
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.backend import SimulatorBackend
from pirate_sm.simulation.batch import Batch
from pirate_sm.simulation.crew import Crew

MISSIONS = ("mitre_bend", "take_elbow", "house_connection")
FIDELITIES: tuple[Fidelity, ...] = ("usual", "fast")
REPEATS = 7
SHARED = "mitre_bend"


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


class Replayed(NamedTuple):
    """A batch on the course of a mission, and how long that has taken."""

    batch: Batch
    cpu_s: float
    wall_s: float


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
    loaded: LoadedMission, course: Course, order: Order, robots: int, threads: int | None
) -> Replayed:
    """Let a batch take the course of a mission."""
    some = []
    for _ in range(robots):
        backend = prepare(order, loaded).backend
        assert isinstance(backend, SimulatorBackend)
        some.append(backend.robot)
    batch = Batch(some, loaded.loaded_robot.profile.link, threads)
    cpu_s, wall_s = process_time(), perf_counter()
    for values, cycles in course.stretches:
        batch.advance(cycles, None if values is None else np.tile(values, (robots, 1)))
    return Replayed(batch, process_time() - cpu_s, perf_counter() - wall_s)


def main() -> int:
    """Print a line for each mission and fidelity, and one for whole missions."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=32)
    parser.add_argument("--threads", type=int, default=cpu_count() or 1)
    parser.add_argument("--mission", action="append", choices=MISSIONS, help="all by default")
    parser.add_argument("--repeats", type=int, default=REPEATS)
    wishes = parser.parse_args()
    robots, threads, repeats = wishes.robots, wishes.threads, wishes.repeats
    for mission in wishes.mission or MISSIONS:
        usual: tuple[float, float] | None = None
        for fidelity in FIDELITIES:
            rates = _rates(Order(mission, fidelity=fidelity), robots, threads, repeats)
            single, core, shared, wall = rates
            usual = usual or (single, core)
            print(
                f"{mission}, {fidelity}: one with the interpreter {single:,.0f} × real time, batch "
                f"{core:,.0f} per core: {core / usual[0]:.2f} × the usual one with the "
                f"interpreter, {core / usual[1]:.2f} × the usual batch; on {threads} "
                f"threads {shared:,.0f} per core, {wall:,.0f} in all"
            )
    _share(robots, threads, repeats)
    return 0


def _rates(
    order: Order, robots: int, threads: int, repeats: int
) -> tuple[float, float, float, float]:
    """Return × real time of a mission, of a batch per core on one thread and on several, in all."""
    loaded = load(order)
    courses, alone, shared = [], [], []
    for _ in range(repeats):
        course = course_of(loaded, order)
        courses.append(course)
        alone.append(replayed(loaded, course, order, robots, 1))
        shared.append(replayed(loaded, course, order, robots, threads))
        for each in (alone[-1], shared[-1]):
            assert (each.batch.quantities == course.quantities).all(), "it has gone another way"
    time_s = courses[0].time_s
    return (
        time_s / min(each.cpu_s for each in courses),
        robots * time_s / min(each.cpu_s for each in alone),
        robots * time_s / min(each.cpu_s for each in shared),
        robots * time_s / min(each.wall_s for each in shared),
    )


def one(seed: int) -> None:
    """Run a whole mission."""
    gliding.run(Order(SHARED, seed=seed), glides=True)


def _share(missions: int, threads: int, repeats: int) -> None:
    """Print how many whole missions pass in a second."""
    pool = ProcessPoolExecutor(threads, mp_context=get_context("spawn"))
    with pool, Crew(1) as alone, Crew(threads) as crew:
        list(pool.map(one, range(8 * threads)))  # each has loaded the mission
        ways: dict[str, Callable[[], object]] = {
            "one thread": lambda: alone.each(one, range(missions)),
            f"{threads} threads": lambda: crew.each(one, range(missions)),
            f"{threads} processes": lambda: list(pool.map(one, range(missions), chunksize=4)),
        }
        rates: dict[str, list[float]] = {name: [] for name in ways}
        for _ in range(repeats):
            for name, way in ways.items():
                began_s = perf_counter()
                way()
                rates[name].append(missions / (perf_counter() - began_s))
    found = ", ".join(f"{name} {max(some):.1f}" for name, some in rates.items())
    print(f"whole missions, {SHARED}, per second: {found}")


if __name__ == "__main__":
    sys.exit(main())
