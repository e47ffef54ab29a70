"""Many simulated robots, advanced in one call on all processors: for learning on the physics.

Setpoints go in and quantities and counts come out, without an engine. Each robot moves as it would
move alone, to the last bit, whatever the number of threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from math import ceil, inf
from numbers import Integral
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from pirate_sm.core.errors import UsageError
from pirate_sm.core.models import LinkSettings
from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.crew import Crew
from pirate_sm.simulation.physics import GlidingPhysics, QuantityLayout
from pirate_sm.simulation.simulated_robot import CycleReading, SimulatedRobot


class Batch:
    """Simulated robots that are advanced together.

    Args:
        robots: The robots, of one kind; nobody else advances them.
        link: The link of their boards: how long a cycle is, and what one reads.
        threads: How many threads share the work; one for each processor by default.

    Attributes:
        cycle_s: How long a cycle is.
        quantities: `(robots, quantities)`: the true quantities after the last cycle, SI, laid out
            by :class:`~pirate_sm.simulation.physics.QuantityLayout`.
        counts: `(robots, channels)`: what the boards have measured last, raw. Defects that change
            or lose what boards report do not show here, nor do those of the link's controller.
        gone: `(robots,)`: which robots have left the pipe for good.
    """

    def __init__(
        self, robots: Sequence[SimulatedRobot], link: LinkSettings, threads: int | None = None
    ) -> None:
        self.cycle_s = link.cycle
        self._courses = [_Course(robot, link) for robot in robots]
        self._crew = Crew(threads)
        self.quantities: Floats = np.array([each.physics.quantities for each in robots])
        self.counts: Floats = np.array([each.electronics.counts for each in robots])
        self.gone = np.array([each.gone for each in robots], dtype=np.bool_)

    def __len__(self) -> int:
        """Return how many robots there are."""
        return len(self._courses)

    def values(self, quantity: str) -> Floats:
        """Return a quantity of every wheel, `(robots, wheels)`; see `physics.PER_WHEEL`."""
        layout = QuantityLayout(len(self._courses[0].robot.arcs))
        return self.quantities[:, layout.block(quantity)]

    def advance(self, cycles: int, setpoints: ArrayLike | None = None) -> None:
        """Let cycles of the bus pass for every robot.

        Args:
            cycles: How many; each lasts as long as the link's.
            setpoints: `(robots, slots)`: put in force before, each clipped to the limits of its
                slot; None leaves those in force.

        Raises:
            UsageError: The cycles are no whole number from 0 on, or the setpoints are not a finite
                number for each slot of each robot.
        """
        courses = self._courses
        if not isinstance(cycles, Integral) or cycles < 0:
            raise UsageError(f"cycles: expected a whole number from 0 on, got {cycles!r}")
        if setpoints is not None:
            for course, values in zip(courses, self._rows(setpoints), strict=True):
                course.robot.set_values(values)
        self._crew.each(partial(_Course.run, cycles=cycles), courses)
        for row, course in enumerate(courses):
            robot = course.robot
            self.quantities[row] = robot.physics.quantities
            self.counts[row] = robot.electronics.counts
            self.gone[row] = robot.gone

    def _rows(self, setpoints: ArrayLike) -> list[list[float]]:
        """Return the setpoints of each robot."""
        expected = len(self._courses), self._courses[0].robot.electronics.slots
        try:
            rows = np.asarray(setpoints, dtype=np.float64)
        except (TypeError, ValueError):
            rows = np.empty(0)
        if rows.shape != expected or not np.isfinite(rows).all():
            raise UsageError(f"setpoints: expected finite numbers of the shape {expected}")
        return cast(list[list[float]], rows.tolist())


class _Course:
    """The course of one robot; cycles pass in compiled calls wherever nothing else acts on it."""

    def __init__(self, robot: SimulatedRobot, link: LinkSettings) -> None:
        self.robot = robot
        self._cycle_s = link.cycle
        self._turns = robot.turns(link.state_message == "value")
        self._cycles = 0
        physics, electronics = robot.physics, robot.electronics
        self._physics = physics if isinstance(physics, GlidingPhysics) else None
        self._span: Floats = np.zeros(4)
        self._around: Floats = np.array([link.cycle, *robot.leeway])
        self._arrays: tuple[Any, ...] = (
            *(_turn_table(self._turns), electronics.channels),
            *(electronics.counts, electronics.rng, self._span),
        )

    def run(self, cycles: int) -> None:
        """Let cycles pass."""
        end = self._cycles + cycles
        while self._cycles < end:
            last = min(end, self._undisturbed())
            if self._physics is not None and self._cycles < last:
                self._pass(self._physics, last)
            else:
                self._step()

    def _undisturbed(self) -> float:
        """Return up to which cycle only physics and sensors act."""
        until_s = self.robot.glides_until_s(self._cycles * self._cycle_s)
        if until_s in (inf, -inf):
            return until_s
        last = ceil(until_s / self._cycle_s)
        while last * self._cycle_s >= until_s:  # time stays below it
            last -= 1
        return last

    def _pass(self, physics: GlidingPhysics, last: float) -> None:
        """Let cycles pass in one compiled call."""
        self._span[:] = self._cycles, last, self.robot.time_s, 0.0
        robot = self.robot
        place = robot.physics.quantities, physics.roll_angles, robot.arcs, self._around
        physics.pass_cycles(place, *self._arrays)
        cycles, _, time_s, met = self._span.tolist()
        robot.passed(int(cycles) - self._cycles, time_s)
        self._cycles = int(cycles)
        if met:
            robot.meet_obstacles()

    def _step(self) -> None:
        """Let one cycle pass."""
        self._cycles += 1
        turn = self._turns[self._cycles % len(self._turns)]
        self.robot.step(self._cycles * self._cycle_s, turn)
        self.robot.meet_obstacles()


def _turn_table(turns: Sequence[CycleReading]) -> Ints:
    """Return which channels each cycle reads, see `columns.py`."""
    rows = [(0, turn.first, turn.last, 0) for turn in turns]
    return np.array(rows, dtype=np.int64).reshape(-1, 4)
