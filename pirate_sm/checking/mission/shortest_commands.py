"""Find the shortest sequence of commands that leads to the initial states of a mission."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from pirate_sm.engine.robot import command_outcome
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.robot.robot_state import RobotState


def way(
    robot: RobotSpec, body: RobotState, wanted: Sequence[tuple[int, str]]
) -> tuple[str, ...] | None:
    """Return the names of the commands in order; None if no commands lead there.

    The sequence never releases the last clamp. Unconfirmed states count as confirmed at the
    beginning, because each command is given separately.

    Args:
        robot: The robot.
        body: Its commanded state.
        wanted: Regions with their target states.
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
