"""Find the shortest sequences of commands that lead the robot to other configurations.

Each command is simulated with the functions that run it on the robot, and counts as done. Commands
that the engine would refuse are left out. Commands that release the last clamp or break a safety
rule are used only as a last resort, to report what prevents a plan; they are never recommended.
"""

from __future__ import annotations

from collections.abc import Iterator
from heapq import heappop, heappush
from itertools import count
from typing import NamedTuple

from pirate_sm.core._engine import safety
from pirate_sm.core._engine.mission.program import Program
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot import command_outcome, commands
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import Mark, RobotState, confirmed_parts
from pirate_sm.core._engine.sensing.known_signals import Sensing, nothing_known
from pirate_sm.core._model.events import SubmitResult

RulePlaces = tuple[int, ...]
"""The progress of each safety rule, see :func:`pirate_sm.core._engine.safety.follow`."""

_Key = tuple[int, frozenset[Mark], RulePlaces]


class PlannedStep(NamedTuple):
    """One command of a plan.

    Attributes:
        command: Index of the command.
        body: The robot after the command.
        hindrance: Why the command should not be given here; empty if it may be given.
    """

    command: int
    body: RobotState
    hindrance: str = ""


class Plan(NamedTuple):
    """A sequence of commands that leads to one configuration.

    Attributes:
        body: The robot after the last command.
        steps: The commands in order.
        hindered: The first step with a hindrance; None if the plan can be followed.
    """

    body: RobotState
    steps: tuple[PlannedStep, ...]
    hindered: PlannedStep | None

    def nominal_s(self, robot: RobotSpec) -> float:
        """Return the sum of the commands' nominal durations, s."""
        return sum(robot.commands[step.command].nominal_s for step in self.steps)


class _Way(NamedTuple):
    """A step, linked to the one before it."""

    before: _Way | None
    step: PlannedStep

    def plan(self, body: RobotState) -> Plan:
        steps: list[PlannedStep] = []
        way: _Way | None = self
        while way is not None:
            steps.append(way.step)
            way = way.before
        steps.reverse()
        return Plan(body, tuple(steps), next((each for each in steps if each.hindrance), None))


def plans(
    robot: RobotSpec, program: Program, body: RobotState, places: RulePlaces | None = None
) -> Iterator[Plan]:
    """Yield the best plan for each reachable configuration, beginning with the present one.

    Plans are ordered by hindrance, then by number of commands, then by nominal duration.

    Args:
        robot: The robot.
        program: The program whose safety rules are in force.
        body: The robot's present state, with no command under way.
        places: Progress of the rules; None if they have not been evaluated yet.
    """
    sensing = nothing_known(robot, blind=True)
    if places is None:
        places, _ = safety.follow(program, robot, safety.unseen(program), body, 0)
    serial = count()  # breaks ties, so that states are never compared
    queue: list[tuple[int, int, float, int, RobotState, RulePlaces, _Way | None]] = []
    heappush(queue, (0, 0, 0.0, next(serial), body, places, None))
    known: set[_Key] = set()
    while queue:
        hindrances, length, nominal_s, _, here, at, way = heappop(queue)
        key = (here.configuration, here.marks, at)
        if key in known:
            continue
        known.add(key)
        yield way.plan(here) if way is not None else Plan(here, (), None)
        for step, after in next_steps(robot, program, sensing, here, at):
            if (step.body.configuration, step.body.marks, after) not in known:
                cost = (
                    hindrances + bool(step.hindrance),
                    length + 1,
                    nominal_s + robot.commands[step.command].nominal_s,
                )
                heappush(queue, (*cost, next(serial), step.body, after, _Way(way, step)))


def opened(robot: RobotSpec, body: RobotState, target: int) -> frozenset[int]:
    """Return the parts that a change to a configuration releases while no other part holds.

    A part holds only if its clamp is confirmed and it is held before and after.
    """
    before, after = robot.held[body.configuration], robot.held[target]
    remaining = confirmed_parts(robot, body) & after
    return frozenset() if remaining else before - after


def next_steps(
    robot: RobotSpec, program: Program, sensing: Sensing, body: RobotState, places: RulePlaces
) -> Iterator[tuple[PlannedStep, RulePlaces]]:
    """Yield the step of each possible command, with the progress of the rules after it."""
    for command, spec in enumerate(robot.commands):
        if command_outcome.refusal(robot, body, command):
            continue
        after = _done(robot, program, body, sensing, command)
        following, broken = safety.follow(program, robot, places, after, 1, spec.name)
        hindrance = _letting_go(robot, body, after.configuration)
        if not hindrance and broken:
            hindrance = "it breaks " + "; ".join(map(safety.said, broken))
        yield PlannedStep(command, after, hindrance), following


def _letting_go(robot: RobotSpec, body: RobotState, target: int) -> str:
    parts = " and ".join(robot.parts[part] for part in sorted(opened(robot, body, target)))
    return f"it lets go of {parts}, and no other part is confirmed to hold" if parts else ""


def _done(
    robot: RobotSpec, program: Program, body: RobotState, sensing: Sensing, command: int
) -> RobotState:
    """Return the robot after the command, with all arrays accepted and all stages done."""
    now = Moment(robot, program, True, 0.0)
    later = Moment(robot, program, True, robot.commands[command].nominal_s)
    body = commands.begin(now, body, sensing, command, None, "")
    while body.motion is not None or body.flight is not None:
        if body.flight is not None:
            accepted = SubmitResult(body.flight.setpoint_id, "accepted")
            body, _ = commands.resolve(now, body, accepted)
        else:
            body, _ = commands.watch(later, body, sensing)
    return body
