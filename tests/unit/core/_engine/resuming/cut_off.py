"""A run that is cut off, and what the boards of its robot show afterwards."""

from __future__ import annotations

from dataclasses import dataclass, field

from driving import Driver

from pirate_sm.core._engine.engine import Engine
from pirate_sm.core._engine.resuming.hypotheses import Hypothesis, hypotheses
from pirate_sm.core._engine.resuming.reconciling import Reconciled, StateVerdict, reconcile
from pirate_sm.core._engine.resuming.resumption import Resumption, resumption
from pirate_sm.core._engine.robot.robot_state import RobotState
from pirate_sm.core._model.events import SensorFrame

GRIPPING = {
    "gamma_1": -1.0,
    "gamma_2": 1.0,
    "gamma_3": -1.0,
    "gamma_4": 1.0,
    "bend_torque_1": -0.7,
    "bend_torque_2": 0.7,
    "bend_torque_3": -0.7,
    "bend_torque_4": 0.7,
}
"""What both parts of the PIRATE show that hold in the same pipe."""

LOOK_S = 1.0


@dataclass
class CutOff:
    """A run at the moment in which nobody records it any more.

    Attributes:
        driver: The run before; its signals are what the boards go on showing.
        driven_s: How long the wheels may have been driven since.
        silent: Boards that do not report any more.
    """

    driver: Driver
    driven_s: float = 0.0
    silent: frozenset[int] = frozenset()
    frames: list[tuple[float, SensorFrame]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.robot, self.program = self.driver.robot, self.driver.engine.program
        self.last, self.last_s = self.driver.state, self.driver.now

    def look(self, **signals: float) -> Reconciled:
        """The boards report for a second; these signals show something else now."""
        self.driver.signals |= signals
        begin_s = self.last_s + 5.0
        for turn in range(11):
            at_s = begin_s + turn * LOOK_S / 10
            boards = [board for board in self.robot.boards if board not in self.silent]
            self.frames += [(at_s, self.driver.frame(board)) for board in boards]
        end_s = begin_s + LOOK_S
        return reconcile(self.robot, self.program, self.last, self.frames, end_s, self.driven_s)

    @property
    def recorded(self) -> Hypothesis:
        return hypotheses(self.robot, self.program, self.last)[0]

    def go_on(self, at: str = "here", **signals: float) -> Driver:
        """The mission continues with the recorded hypothesis."""
        way = self.look(**signals).way
        found = resumption(self.robot, self.program, self.last, self.last_s, self.recorded, way, at)
        assert isinstance(found, Resumption), found
        return resumed(self.driver, self.program, found)

    def why_not(self, at: str = "here") -> str:
        way = self.look().way
        found = resumption(self.robot, self.program, self.last, self.last_s, self.recorded, way, at)
        assert not isinstance(found, Resumption)
        return found.reason


def resumed(before: Driver, program, found: Resumption) -> Driver:
    """An engine that goes on, with the world as it was."""
    driver = Driver.__new__(Driver)
    driver.__dict__ |= before.__dict__
    driver.taken = []
    resuming = found.program(program)
    driver.engine = Engine(before.robot, resuming, nominal=False, taken=driver.taken)
    driver.now = 0.0
    driver.state, effects = driver.engine.start(0.0, resumed=found)
    driver.effects = list(effects)
    return driver


def verdict_of(found: Reconciled, about: str) -> StateVerdict:
    """What the first table says about a region or part."""
    return next(each for each in found.tables[0].verdicts if each.about == about)


def confirmed(body: RobotState, kind: str) -> set[int]:
    """The regions or parts without a mark."""
    return {mark.which for mark in body.marks if mark.kind == kind}
