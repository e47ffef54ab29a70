"""The working context of one engine step: robot, program, time, and the effects so far."""

from __future__ import annotations

from pirate_sm.core._engine.mission.program import BranchKey, BranchKind, Program
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import RESTORING
from pirate_sm.core._model.events import ALPHABET_VERSION
from pirate_sm.core.effects import Effect, Log

ROUNDING_S = 1e-9
"""Tolerance of time comparisons. Sums of times differ by rounding: without a tolerance, a deadline
could be due for the clock that wakes the engine, and not yet for the engine."""


def has_come(now: float, at_s: float) -> bool:
    """Return whether the time ``at_s`` has been reached, within rounding."""
    return now >= at_s - ROUNDING_S


class Moment:
    """The context of one step of the engine.

    Functions take a state and return the next one. They add what the runtime must do or report to
    ``effects``, in order.

    Args:
        robot: The robot.
        program: The mission.
        nominal: Whether commands count as done after their nominal duration.
        now_s: Seconds since the run began.
        follows_traction: Whether the signals of slip and friction are estimated in every round.
        alphabet: The version of the alphabet by whose rules the engine decides.
        taken: Receives each branch of the mission that is taken; None: nothing counts them.

    Attributes:
        effects: The effects so far, in order.
        emit: Appends one effect.
    """

    __slots__ = (
        "alphabet",
        "effects",
        "emit",
        "follows_traction",
        "nominal",
        "now_s",
        "program",
        "robot",
        "taken",
    )

    def __init__(
        self,
        robot: RobotSpec,
        program: Program,
        nominal: bool,
        now_s: float,
        follows_traction: bool = False,
        alphabet: int = ALPHABET_VERSION,
        taken: list[BranchKey] | None = None,
    ) -> None:
        self.robot = robot
        self.program = program
        self.now_s = now_s
        self.nominal = nominal
        self.follows_traction = follows_traction
        self.alphabet = alphabet
        self.taken = taken
        self.effects: list[Effect] = []
        self.emit = self.effects.append

    def trial(self) -> Moment:
        """Return a copy without effects, to try a step whose effects are discarded."""
        same = self.robot, self.program, self.nominal, self.now_s
        return Moment(*same, self.follows_traction, self.alphabet)

    def warn(self, message: str) -> None:
        """Append a warning for the operator to the effects."""
        self.effects.append(Log("warning", message))

    def take(self, kind: BranchKind, place: str, name: str = "") -> None:
        """Note that the mission takes this branch, if branches are counted.

        A command that a resumed run gives before it continues is in no file and has no branch.
        """
        if self.taken is not None and place != RESTORING:
            self.taken.append(BranchKey(kind, place, name))
