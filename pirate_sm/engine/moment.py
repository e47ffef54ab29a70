"""What the engine works with while it answers one event."""

from __future__ import annotations

from pirate_sm.engine.mission.program import Program
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.model.effects import Effect, Log


class Moment:
    """One moment of a run, and what has happened in it so far.

    Functions take a state and return the next one; what the outside must do or know of it they add
    to ``effects`` in order.

    Args:
        robot: What runs.
        program: The mission.
        nominal: Whether commands are taken as done after their nominal duration.
        now_s: Seconds since the run began.

    Attributes:
        effects: What has happened, in order.
        emit: Appends one effect.
    """

    __slots__ = ("effects", "emit", "nominal", "now_s", "program", "robot")

    def __init__(self, robot: RobotSpec, program: Program, nominal: bool, now_s: float) -> None:
        self.robot = robot
        self.program = program
        self.now_s = now_s
        self.nominal = nominal
        self.effects: list[Effect] = []
        self.emit = self.effects.append

    def trial(self) -> Moment:
        """Return the same moment, to try something in it: what happens there is not told here."""
        return Moment(self.robot, self.program, self.nominal, self.now_s)

    def warn(self, message: str) -> None:
        """Add a warning for the operator."""
        self.effects.append(Log("warning", message))
