"""List the configurations in which a robot may be whose run was cut off."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, NamedTuple

from pirate_sm.core._engine.mission.program import Program
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot import command_outcome, commands
from pirate_sm.core._engine.robot.confirmation_spec import DrivenSpec, StandingSpec
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    DECLARED,
    DENIED,
    STOPPED,
    Flight,
    Mark,
    Marks,
    Motion,
    RobotState,
    at_rest_in,
    known_values,
    states_of,
)
from pirate_sm.core._engine.robot.sensor_verdict import spec_of, verdict
from pirate_sm.core._engine.state import EngineState


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


def unproven(robot: RobotSpec, body: RobotState) -> Marks:
    """Return the marks of a robot of which nothing is confirmed any more.

    What had been confirmed is *declared*: sensors may confirm it. What was not confirmed keeps its
    mark, which only a command removes.
    """
    here = body.configuration
    kept = {mark for mark in body.marks if mark.command not in (DECLARED, STOPPED)}
    known = {(mark.kind, mark.which) for mark in kept}
    every = {Mark("part", part, DECLARED) for part in robot.held[here]}
    every |= {Mark("region", region, DECLARED) for region in range(len(robot.regions))}
    kept |= {mark for mark in every if (mark.kind, mark.which) not in known}
    return frozenset(kept | {Mark("region", each, STOPPED) for each in robot.driven[here]})


def denied(
    robot: RobotSpec, program: Program, last: EngineState, rest: RobotState
) -> Iterator[Mark]:
    """Yield the marks; those that the last known signals contradict are denied.

    A part that stands across the mouth of a tee, for example, shows another diameter. There the
    sensors say nothing now either, and a command must confirm the part. Wheels that turned may
    have come to rest since.
    """
    names, setpoints = states_of(robot, rest), at_rest_in(robot, rest.configuration).values
    for mark in rest.marks:
        numbers, diameter_m = last.sensing.numbers, program.diameter_m
        wheels = isinstance(spec_of(robot, names, mark), StandingSpec | DrivenSpec)
        if mark.command != DECLARED or wheels:
            yield mark
        elif verdict(robot, setpoints, rest, mark, numbers, diameter_m).against:
            yield mark._replace(command=DENIED)
        else:
            yield mark


# --- inside ---------------------------------------------------------------------------------


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
    values = list(known_values(body.values, last.sensing.numbers, robot))
    for slot in (*robot.safe_zero, *body.seeking):
        values[slot] = 0.0
    rest = RobotState(
        body.configuration,
        tuple(values),
        marks=unproven(robot, body),
        next_id=body.next_id + (body.flight is not None),
        control=body.control,
    )
    return rest._replace(marks=frozenset(denied(robot, program, last, rest)))
