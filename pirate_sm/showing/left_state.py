"""In what state a run has left the robot, in words."""

from __future__ import annotations

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.robot.robot_state import confirmed_at
from pirate_sm.engine.state import EngineState


def left_state(
    robot: RobotSpec, state: EngineState, sent: tuple[float, ...], *, nominal: bool, heard: bool
) -> str:
    """Return in what state a run has left the robot: its wheels and what holds it.

    Args:
        robot: The robot.
        state: The engine's state at the end.
        sent: The last array that was sent; empty if none was.
        nominal: Whether there are no sensors.
        heard: Whether the robot has confirmed the last array, as far as its link can.
    """
    if not sent:
        return "nothing was sent: the robot is as it was"
    stopped = not any(sent[slot] for slot in robot.safe_zero)
    wheels = "wheels set to zero" if stopped else "the wheels may TURN: no safe array was sent"
    if not heard:
        wheels = f"{wheels}, NOT confirmed by the robot"
    here, marks = state.robot.configuration, state.robot.marks
    confirmed = confirmed_at(robot, here, marks)
    held = [
        f"{robot.parts[part]} clamped ({_by_what(part in confirmed, nominal=nominal)})"
        for part in sorted(robot.held[here])
    ]
    return "; ".join([wheels, *(held or ["no part is clamped"])])


def _by_what(confirmed: bool, *, nominal: bool) -> str:
    if nominal:
        return "without sensors"
    return "confirmed by sensors" if confirmed else "NOT confirmed by sensors"
