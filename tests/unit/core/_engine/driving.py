"""Drives an engine by hand: time is what the test says, and every effect is kept."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.engine import Engine
from pirate_sm.core._engine.mission.program import BranchKey, Program
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import RobotState, at_rest_in, states_of, unconfirmed
from pirate_sm.core._engine.sensing.board_spec import WatchedSpec
from pirate_sm.core._loading.mission.loader import load_mission
from pirate_sm.core._model import events as ev

ROOT = Path(__file__).resolve().parents[4]
PIRATE = ROOT / "hardware_profiles" / "pirate_ii"
NEWT = ROOT / "tests" / "robots" / "newt"

E = TypeVar("E")

HEAD = """\
format: 1
mission: under_test
robot: {robot}
"""


def joints_that_obey(robot: RobotSpec, body: RobotState) -> dict[str, float]:
    """What joints show that have come to their setpoints, by the signal's name."""
    names = robot.vocabulary.numbers
    shown = {names[loop.angle]: loop.target_rad for loop in body.seekers}
    for slot, value in zip(robot.slots, body.values, strict=True):
        if slot.torque >= 0:
            shown[names[slot.torque]] = value
        if slot.unit == "angle" and slot.angle >= 0 and not math.isnan(value):
            shown[names[slot.angle]] = value
    return shown


class Driver:
    """An engine with its state, its clock and the world's answers.

    Attributes:
        now: Mission time.
        effects: Everything so far, in order.
        signals: What the sensors would show, SI, by the signal's name.
        taken: The branches of the mission that were taken, in order.
        doubting: Whether sensors must show what is possible. Where a test makes joints jump and
            motors draw no current they need not, and boards report as often as it likes.
        loss: Share of reports that the engine takes to be lost, where nothing is doubted.
    """

    def __init__(
        self,
        robot: RobotSpec,
        program: Program,
        *,
        nominal: bool = False,
        doubting: bool = False,
        declared: bool = False,
    ) -> None:
        if not doubting:
            boards = {
                number: replace(board, watched=WatchedSpec())
                for number, board in robot.boards.items()
            }
            robot = replace(robot, boards=boards, link=replace(robot.link, period_s=1e-9))
        self.robot = robot
        self.doubting = doubting
        self.loss = 0.0
        self.taken: list[BranchKey] = []
        self.engine = Engine(robot, program, nominal=nominal, taken=self.taken)
        self.now = 0.0
        upright = {"acc_z": 9.81} if "acc_z" in robot.vocabulary.numbers else {}
        # A part that holds alone while the other bends bears a torque, else it slides.
        wound = {"bend_torque_1": -0.7, "bend_torque_4": 0.7}
        gripping = {name: nm for name, nm in wound.items() if name in robot.vocabulary.numbers}
        self.signals: dict[str, float] = upright if declared else upright | gripping
        # The robot is where it is said to be: what sensors say of that is tested in test_seeing.
        body = None if declared else at_rest_in(robot, program.start_configuration)
        self.state, effects = self.engine.start(0.0, body=body)
        self.effects: list[fx.Effect] = list(effects)

    # --- what happens ---

    def give(self, event: ev.Event, at: float | None = None) -> list[fx.Effect]:
        """The event happens, now or at a later time; its own effects are returned."""
        if at is not None:
            assert at >= self.now, "time never goes back"
            self.now = at
        self.state, effects = self.engine.step(self.state, event, self.now)
        if not self.doubting and self.state.sensing.loss != self.loss:
            sensing = self.state.sensing._replace(loss=self.loss)
            self.state = self.state._replace(sensing=sensing)
        self.effects += effects
        return list(effects)

    def tick(self, at: float) -> list[fx.Effect]:
        return self.give(ev.Tick(), at)

    def accept(self, status: Any = "accepted", reason: str = "") -> list[fx.Effect]:
        """The newest array meets its fate."""
        return self.give(ev.SubmitResult(self.setpoints.setpoint_id, status, reason))

    def show(self, at: float | None = None, **signals: float) -> list[fx.Effect]:
        """Every board that measures one of the signals reports; the others keep their values."""
        self.signals |= signals
        self.now = self.now if at is None else at
        effects: list[fx.Effect] = []
        for board in self.robot.boards.values():
            told = {self.robot.vocabulary.numbers[target] for _, target, _ in board.channels}
            if told & signals.keys():
                effects += self.report(board.id)
        return effects

    def report(self, board: int, at: float | None = None) -> list[fx.Effect]:
        """One board reports what its signals show."""
        return self.give(self.frame(board), at)

    def report_all(self, at: float | None = None) -> list[fx.Effect]:
        self.now = self.now if at is None else at
        return [effect for board in self.robot.boards for effect in self.report(board)]

    def frame(self, board: int) -> ev.SensorFrame:
        """Raw counts, as the board's conversions read them back."""
        channels = self.robot.boards[board].channels
        width = 1 + max(place for place, _, _ in channels)
        values = [0.0] * width
        for place, target, scale in channels:
            name = self.robot.vocabulary.numbers[target]
            values[place] = self.signals.get(name, 0.0) / scale
        return ev.SensorFrame(board, tuple(values))

    def run(self, until: float, every: float = 0.1, **turning: float) -> None:
        """All boards report again and again; a signal in `turning` rises so much a second."""
        while self.now < until - 1e-9 and not self.ended:
            step = min(every, until - self.now)
            for name, rate in turning.items():
                self.signals[name] = self.signals.get(name, 0.0) + rate * step
            self.report_all(self.now + step)

    def obey(self, lasting: float = 0.1) -> None:
        """What was sent is accepted and done by the robot for a while, as its sensors tell."""
        if self.in_flight:
            self.accept()
        names, body = self.robot.vocabulary.numbers, self.state.robot
        self.signals |= joints_that_obey(self.robot, body)
        turning = {names[w.angle]: 3.0 * body.values[w.slot] for w in self.robot.wheels}
        self.run(self.now + lasting, every=lasting, **turning)

    def until(self, seen: Callable[[Driver], object], at_most: float = 30.0) -> None:
        """The robot obeys until something is seen."""
        give_up = self.now + at_most
        while not seen(self):
            assert self.now < give_up, "it never came"
            assert not self.ended, f"it ended before: {self.ended}"
            self.obey()

    def until_done(self, command: str, times: int = 1) -> None:
        """The robot obeys until the command is done, for this many times since the start."""
        self.until(lambda driver: driver.statuses.count((command, "done")) >= times)

    def until_sent(self, command: str, times: int = 1) -> None:
        """The robot obeys until the command's first array is in flight."""
        self.until(lambda driver: driver.statuses.count((command, "sent")) >= times)

    def until_waiting(self, phase: str) -> None:
        self.until(lambda driver: any(each.phase == phase for each in driver.of(fx.WaitArmed)))
        while self.in_flight:
            self.accept()

    # --- what is seen ---

    def of(self, kind: type[E]) -> list[E]:
        return [effect for effect in self.effects if isinstance(effect, kind)]

    @property
    def messages(self) -> list[str]:
        """What was said to the operator."""
        return [log.message for log in self.of(fx.Log)]

    @property
    def in_flight(self) -> bool:
        """Whether the fate of an array is open."""
        return self.state.robot.flight is not None

    @property
    def setpoints(self) -> fx.Setpoints:
        """The newest array."""
        return self.of(fx.Setpoints)[-1]

    @property
    def array(self) -> dict[str, float]:
        """The newest array by slot."""
        names = (slot.name for slot in self.robot.slots)
        return dict(zip(names, self.setpoints.values, strict=True))

    @property
    def nonzero(self) -> dict[str, float]:
        return {name: value for name, value in self.array.items() if value != 0}

    @property
    def states(self) -> dict[str, str]:
        return dict(zip(self.robot.regions, states_of(self.robot, self.state.robot), strict=True))

    @property
    def unconfirmed(self) -> set[str]:
        return set(unconfirmed(self.robot, self.state.robot))

    @property
    def statuses(self) -> list[tuple[str, str]]:
        return [(status.name, status.status) for status in self.of(fx.CommandStatus)]

    @property
    def last_status(self) -> fx.CommandStatus:
        return self.of(fx.CommandStatus)[-1]

    @property
    def phases(self) -> list[str]:
        return [change.phase for change in self.of(fx.PhaseChange)]

    @property
    def fired(self) -> list[str]:
        return [fired.trigger for fired in self.of(fx.TriggerFired)]

    @property
    def ended(self) -> fx.Ended | None:
        found = self.of(fx.Ended)
        return found[-1] if found else None

    @property
    def wake_at(self) -> float:
        found = self.of(fx.WakeAt)
        return found[-1].at_s if found else math.inf

    @property
    def faults(self) -> list[tuple[str, str]]:
        return [(fault.code, fault.handling) for fault in self.of(fx.Fault)]


def write_mission(folder: Path, body: str, robot: Path = PIRATE, name: str = "m.yaml") -> Path:
    """A mission file with its head written for it."""
    file = folder / name
    head = HEAD.format(robot=robot).replace("under_test", file.stem)
    file.write_text(head + body, encoding="utf-8")
    return file


def changed_newt(folder: Path, *swaps: tuple[str, str]) -> Path:
    """A copy of the small robot in whose profile something stands for something else."""
    robot = folder / "newt"
    shutil.copytree(NEWT, robot)
    profile = robot / "profile.yaml"
    text = profile.read_text(encoding="utf-8")
    for old, new in swaps:
        assert old in text, f"nothing to swap: {old}"
        text = text.replace(old, new, 1)
    profile.write_text(text, encoding="utf-8")
    return robot


def driver_of(
    path: Path,
    *,
    nominal: bool = False,
    doubting: bool = False,
    declared: bool = False,
    **options: Any,
) -> Driver:
    """Start an engine on a mission; with `declared` nothing of where the robot is is confirmed."""
    loaded = load_mission(path, **options)
    return Driver(
        loaded.robot, loaded.program, nominal=nominal, doubting=doubting, declared=declared
    )


IDLE = """\
start: idle
phases:
  idle:
    wait: [{operator: stop, go: stopped}]
    within: {time: 10 h, go: stopped}
ends:
  stopped: {succeed: Stopped}
"""
"""Does nothing by itself: the operator gives the commands."""

BOTH_CLAMPED = {
    "BendingState": "DoubleClamped",
    "FrontWheelsState": "Fixed",
    "RearWheelsState": "Fixed",
}
DRIVING_FORWARD = {
    "BendingState": "DoubleClamped",
    "FrontWheelsState": "DrivingForward",
    "RearWheelsState": "DrivingForward",
}
FRONT_CLAMPED = {"BendingState": "FrontClampedRearRelaxed", "FrontWheelsState": "Fixed"}
REAR_CLAMPED = {"BendingState": "RearClampedFrontRelaxed", "RearWheelsState": "Fixed"}


def command(driver: Driver, name: str) -> list[fx.Effect]:
    return driver.give(ev.OperatorCommand(name))
