"""The states in which an interrupted run may have left the robot."""

from __future__ import annotations

from typing import Literal, NamedTuple

from pirate_sm.core._engine.mission.program import Program
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot import command_outcome, commands
from pirate_sm.core._engine.robot.declared_states import declared_in
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    DECLARED,
    STOPPED,
    Flight,
    Motion,
    RobotState,
    safe_values,
)
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core._engine.unwatched import denied, unproven


class Hypothesis(NamedTuple):
    """A configuration in which the robot may be.

    Attributes:
        name: ``recorded``: as the recording ends. ``sent``: a command whose first array was
            submitted last was accepted although nobody has recorded it. ``adopted``: nothing was
            recorded.
        body: The robot at rest there, with everything unconfirmed. Its values are those of the
            array that holds it: recorded duties, wheels and the slots of loops at zero.
        command: The command that leads there; empty where none does.
        drives: Whether its array drives wheels.
    """

    name: Literal["recorded", "sent", "adopted"]
    body: RobotState
    command: str = ""
    drives: bool = False

    def in_configuration(self, robot: RobotSpec, there: int, last: EngineState) -> Hypothesis:
        """Return the same robot in a configuration that an operator gives, with nothing confirmed.

        Args:
            robot: The robot.
            there: Index of the configuration.
            last: The engine's last recorded state; what was open then is still open.
        """
        kept = {each for each in last.robot.marks if each.command not in (DECLARED, STOPPED)}
        known = {(mark.kind, mark.which) for mark in kept}
        declared = declared_in(robot, there).marks
        marks = kept | {each for each in declared if (each.kind, each.which) not in known}
        body = self.body._replace(configuration=there, marks=frozenset(marks))
        return Hypothesis("recorded", body)


def hypotheses(
    robot: RobotSpec, program: Program, last: EngineState, maybe: int | None = None
) -> tuple[Hypothesis, ...]:
    """Return where the robot may be; the recorded configuration comes first.

    Args:
        robot: The robot.
        program: The mission.
        last: The engine's last recorded state.
        maybe: A command, by its index, that may have been sent after it; None if the recording
            shows everything that was sent. A command whose first array is in flight in ``last``
            counts without it.
    """
    body = last.robot
    flight, motion = body.flight, body.motion
    if maybe is not None and flight is None and not command_outcome.refusal(robot, body, maybe):
        moment = Moment(robot, program, False, 0.0)
        begun = commands.begin(moment, body, last.sensing, maybe, None, "")
        flight, motion = begun.flight, begun.motion
    found = [Hypothesis("recorded", _at_rest(robot, program, last, body))]
    if flight is not None and motion is not None and flight.purpose == "gate":
        sent = _after(robot, body, flight, motion)
        name = robot.commands[motion.command].name
        drives = any(flight.values[slot] for slot in robot.safe_zero)
        found.append(Hypothesis("sent", _at_rest(robot, program, last, sent), name, drives))
    return tuple(found)


def _after(robot: RobotSpec, body: RobotState, flight: Flight, motion: Motion) -> RobotState:
    """Return the robot after the acceptance of a command's first array."""
    return body._replace(
        configuration=motion.target,
        marks=command_outcome.marks_after(robot, body.configuration, body.marks, motion.command),
        values=flight.values,
        seeking=flight.seeking,
    )


def _at_rest(robot: RobotSpec, program: Program, last: EngineState, body: RobotState) -> RobotState:
    """Return the robot with nothing under way, everything unconfirmed and the values of a hold."""
    rest = RobotState(
        body.configuration,
        safe_values(robot, body, last.sensing.numbers),
        marks=unproven(robot, body),
        next_id=body.next_id + (body.flight is not None),
        control=body.control,
    )
    return rest._replace(marks=frozenset(denied(robot, program, last, rest)))
