"""One episode: a robot under an agent's commands, with the mission paused as for an operator.

It takes place in a mission's robot and pipe, or in a robot and a pipe of their own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from math import inf
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from pirate_sm.api.arguments import is_number, path_of, prepared
from pirate_sm.api.stepping import abandoned_on_error
from pirate_sm.core import library
from pirate_sm.core.companion import entered
from pirate_sm.core.effects import CommandStatus, Effect, Ended, Fault
from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import OperatorCommand
from pirate_sm.core.generated_missions import by_hand
from pirate_sm.core.loading import LoadedMission, load_mission, load_pipe, load_robot
from pirate_sm.core.options import OPTIONS, Options
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import Numbers
from pirate_sm.lab.learning.picture import DrawnPipe, Image, drawn_pipe, picture
from pirate_sm.lab.learning.rewards import Outcome, StepMoment
from pirate_sm.running.runtime.pump import Pump
from pirate_sm.running.wiring import Prepared
from pirate_sm.simulation.backend import SimulatorBackend
from pirate_sm.simulation.physics import QuantityLayout

WAIT_S = 0.5
"""How long a wait is at most [D]: half the time for which a word of the detector is valid."""


class StepOutcome(NamedTuple):
    """How a step went: its outcome, the reason, and the codes of new faults."""

    outcome: Outcome
    reason: str
    faults: tuple[str, ...]


class Trial:
    """A robot under an agent's commands.

    Args:
        ready: The prepared run; nobody else uses it.
        backend: Its backend.
        limit_s: Mission time that no step passes.

    Attributes:
        robot: The robot as the engine knows it.

    Raises:
        BackendError: The backend has failed; likewise in all methods.
    """

    def __init__(self, ready: Prepared, backend: SimulatorBackend, limit_s: float) -> None:
        self.robot: RobotSpec = ready.engine.robot
        self._ready, self._backend, self._limit_s = ready, backend, limit_s
        layout = QuantityLayout(len(backend.robot.arcs))
        self._turned = backend.robot.physics.quantities[layout.block("wheel")]
        self._metres = [wheel.metres_per_rad for wheel in self.robot.wheels]
        self._status: CommandStatus | None = None
        self._faults: list[str] = []
        self._around: DrawnPipe | None = None
        self._pump = pump = Pump(
            ready.engine, backend, companions=ready.companions, tell=self._tell
        )
        with ExitStack() as stack:
            stack.enter_context(entered(ready.companions))
            stack.callback(pump.close)
            with self._guarded():
                pump.start(paused=True)
            self._advance(lambda state: not self._busy(state), limit_s)
            self._stack = stack.pop_all()

    def close(self) -> None:
        """Close the simulator; there is no robot to be made safe."""
        self._stack.close()

    @property
    def now_s(self) -> float:
        """Mission time."""
        return self._pump.now_s

    @property
    def ended(self) -> Ended | None:
        """How the run has ended; None while it is under way."""
        return self._pump.ended

    @property
    def gone(self) -> bool:
        """Whether the robot has left the pipe."""
        return self._backend.robot.gone

    @property
    def numbers(self) -> Numbers:
        """Every signal in the order of the vocabulary, SI; NaN is unknown."""
        return self._ready.engine.numbers(self._state)

    @property
    def words(self) -> tuple[str | None, ...]:
        """The state of each region, then the detector's word; None is unknown."""
        state = self._state
        return (*state.words[: len(self.robot.regions)], state.outside("detector"))

    @property
    def picture(self) -> Image:
        """Return a picture of the robot in its pipe, as it is now."""
        loaded, state = self._ready.loaded, self._state
        body = loaded.loaded_robot.profile.body
        holding = {self.robot.parts[part] for part in self.robot.held[state.robot.configuration]}
        parts = [wheel.part for wheel in body.wheels]
        held = [one == other and one in holding for one, other in pairwise(parts)]
        if self._around is None:
            self._around = drawn_pipe(loaded.pipe)
        places = self._ready.wheels() if self._ready.wheels is not None else ()
        return picture(places, held, body, self._around)

    @property
    def moment(self) -> StepMoment:
        """Where the robot is now."""
        *states, word = self.words
        rolled = zip(self._metres, self._turned.tolist(), strict=True)
        return StepMoment(
            self.now_s,
            dict(zip(self.robot.regions, (state or "" for state in states), strict=True)),
            word or "",
            dict(zip(self.robot.vocabulary.numbers, self.numbers, strict=True)),
            tuple(self._backend.robot.arcs_m),
            tuple(metres * angle for metres, angle in rolled),
        )

    def refusals(self) -> list[str]:
        """Return for each command why it would be refused now; empty where it would be taken."""
        state = self._state
        return [state.why_not_command(self.robot, i) for i in range(len(self.robot.commands))]

    def command(self, index: int) -> StepOutcome:
        """Give a command and let time pass until it is done or has failed, or there is a fault.

        A refused command costs the time of a wait, so that an episode ends in any case.
        """
        self._begin()
        name = self.robot.table.commands[index]
        with self._guarded():
            self._pump.give(OperatorCommand(name))
        status = self._status
        if status is not None and status.status == "refused":
            reason = status.reason
            self._pass()
            return StepOutcome("refused", reason, tuple(self._faults))
        self._advance(lambda state: bool(self._faults) or not self._busy(state), self._limit_s)
        return self._course("failed")

    def wait(self) -> StepOutcome:
        """Let time pass until the detector's word changes or there is a fault; 0.5 s at most."""
        self._begin()
        self._pass()
        return self._course("waited")

    def _begin(self) -> None:
        self._status, self._faults = None, []

    def _pass(self) -> None:
        word = self._state.outside("detector")

        def come(state: EngineState) -> bool:
            return bool(self._faults) or state.outside("detector") != word

        self._advance(come, min(self.now_s + WAIT_S, self._limit_s))

    def _course(self, otherwise: Outcome) -> StepOutcome:
        """Return how the step went; a command that time has cut short has the other outcome."""
        status, faults = self._status, tuple(self._faults)
        reason = status.reason if status is not None else ""
        if faults or self.ended is not None:
            return StepOutcome("fault", self.ended.message if self.ended else reason, faults)
        if status is None or otherwise == "waited":
            return StepOutcome(otherwise, reason, faults)
        return StepOutcome("done" if status.status == "done" else otherwise, reason, faults)

    def _advance(self, come: Callable[[EngineState], bool], limit_s: float) -> None:
        pump = self._pump
        with self._guarded():
            while pump.ended is None and not self._come(come) and pump.now_s < limit_s:
                pump.glide(limit_s)
                pump.take(*pump.wait(limit_s))

    def _come(self, come: Callable[[EngineState], bool]) -> bool:
        """Return whether that has come which is waited for; a run that ends is waited for."""
        return self._state.mission.ending is None and come(self._state)

    def _busy(self, state: EngineState) -> bool:
        moving = state.robot.motion is not None and not state.mission.suspended
        return moving or state.robot.awaited is not None or state.look is not None

    def _tell(self, effects: Sequence[Effect], now_s: float) -> None:
        for effect in effects:
            if isinstance(effect, CommandStatus):
                self._status = effect
            elif isinstance(effect, Fault):
                self._faults.append(effect.code)

    def _guarded(self) -> AbstractContextManager[None]:
        return abandoned_on_error(self._pump, self._backend.name)

    @property
    def _state(self) -> EngineState:
        state = self._pump.state
        assert state is not None  # the constructor has started the engine
        return state


# --- scenarios -----------------------------------------------------------------------------------


USUAL = "mitre_bend"
"""The mission whose robot, pipe and start are used where nothing is named."""

_BEHIND_M = 0.3
"""How far every wheel must come in a pipe that does not turn, where no place is named."""

OPTIONAL = ("defects", *(name for name, each in OPTIONS.items() if each.in_campaigns == "one"))
"""Options of runs that episodes take too: those by which simulated runs differ."""

_USUAL_OPTIONS: Options = {"start_jitter_m": 0.01, "friction_jitter": 0.1}

Name = str | PathLike[str]


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """Where and how episodes take place; the keyword arguments of ``gymnasium.make``.

    Attributes:
        mission: Name or file of a mission, whose robot, pipe and start count; None: the shipped
            bend, or, with both a robot and a pipe, no mission: the robot lies straight in the pipe.
        robot: Name or path of a robot, instead of the mission's; likewise ``pipe``.
        states: States of the robot at the start by region, instead of the mission's.
        backend: ``sim`` or ``physics``.
        reach_m: The place along the pipe that every wheel must reach; None: after the last bend
            by half a diameter, or 0.3 m ahead of the last wheel's start where nothing turns.
        time_limit_s: Mission time after which an episode is truncated.
        options: What else is as for :func:`pirate_sm.run`, see :data:`OPTIONAL`; ``gymnasium.make``
            takes each by its name.
    """

    mission: Name | None = None
    robot: Name | None = None
    pipe: Name | None = None
    states: Mapping[str, str] | None = None
    backend: str = "sim"
    reach_m: float | None = None
    time_limit_s: float = 180.0
    options: Options = field(default_factory=Options)

    def __post_init__(self) -> None:
        for name in ("time_limit_s", "reach_m"):
            value = getattr(self, name)
            if value is not None and (not is_number(value) or not 0 < value < inf):
                raise UsageError(f"{name}: expected a number above 0, got {value!r}")

    @cached_property
    def loaded(self) -> LoadedMission:
        """The mission, read once.

        Raises:
            LoadError: Everything that is wrong with the files.
            UsageError: There is no such file, or the states do not fit.
        """
        robot, pipe = (None if x is None else path_of(x) for x in (self.robot, self.pipe))
        if self.mission is not None or robot is None or pipe is None:
            file = library.find_mission(path_of(self.mission or USUAL))
            return load_mission(file, robot=robot, pipe=pipe, states=self.states)
        if self.states is not None:
            raise UsageError("states: name a mission; without one the robot lies straight")
        own = load_robot(library.find_robot(robot, Path.cwd()))
        shape, document = load_pipe(library.find_pipe(pipe, Path.cwd()))
        return by_hand(own, shape, shape.pipe or Path(document.name).stem)

    def prepared(self, seed: int) -> tuple[Prepared, SimulatorBackend]:
        """Return an episode's engine and its simulator, with the robot at its start.

        Raises:
            LoadError: Everything that is wrong with the files.
            UsageError: An option does not fit, or the backend simulates no robot.
        """
        options: Options = {**_USUAL_OPTIONS, **self.options}
        ready = prepared(self.loaded, self.backend, seed, check=False, yes=False, **options)
        if not isinstance(ready.backend, SimulatorBackend):
            raise UsageError(
                f"the backend {self.backend} has no simulated robot: take 'sim' or 'physics'"
            )
        return ready, ready.backend

    def place_to_reach(self, backend: SimulatorBackend) -> float:
        """Return the place that every wheel must reach, m along the pipe.

        Raises:
            UsageError: The pipe does not go that far.
        """
        bends, pipe = backend.robot.bends, self.loaded.pipe
        if self.reach_m is not None:
            if pipe is not None and self.reach_m >= (length_m := pipe.route().length_m):
                raise UsageError(
                    f"reach_m: {self.reach_m:g} m is not in the pipe, which is {length_m:g} m long"
                )
            return self.reach_m
        if not bends or pipe is None:
            return min(backend.robot.arcs_m) + _BEHIND_M
        last = bends[-1]
        return last.crossing_m + last.reach_m + pipe.diameter / 2
