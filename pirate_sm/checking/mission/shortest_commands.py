"""The fewest commands that bring a robot into the states that a mission starts in."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from pirate_sm.engine.robot import command_outcome
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.robot.robot_state import RobotState


def way(
    robot: RobotSpec, body: RobotState, wanted: Sequence[tuple[int, str]]
) -> tuple[str, ...] | None:
    """Return the names of the commands, in order, if each is done; None where none lead there.

    No command that lets go of the last clamp is among them. What is not confirmed at the
    beginning counts as confirmed: each command on the way is given by itself.

    Args:
        robot: The robot.
        body: Where it is.
        wanted: Regions and the states that they shall be in.
    """
    table = robot.table
    waiting: deque[tuple[int, tuple[str, ...]]] = deque([(body.configuration, ())])
    known = {body.configuration}
    while waiting:
        here, commands = waiting.popleft()
        states = table.configurations[here]
        if all(states[region] == state for region, state in wanted):
            return commands
        at_rest = body._replace(configuration=here, marks=frozenset())
        for number, command in enumerate(robot.commands):
            target = table.follow(here, number)
            if target in known or command.lets_go:
                continue
            if not command_outcome.refusal(robot, at_rest, number):
                known.add(target)
                waiting.append((target, (*commands, command.name)))
    return None
