"""Where episodes take place: a mission's robot and pipe, or a robot and a pipe of their own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from os import PathLike
from pathlib import Path

from pirate_sm.api.arguments import is_number, path_of, prepared
from pirate_sm.core.errors import UsageError
from pirate_sm.core.files import library
from pirate_sm.core.loading import LoadedMission, by_hand, load_mission, load_pipe, load_robot
from pirate_sm.core.options import OPTIONS, Options
from pirate_sm.running.wiring import Prepared
from pirate_sm.simulation.backend import SimulatorBackend

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
        reach_m: The place along the pipe that every wheel must reach; None: behind the last bend
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
