"""What views draw: one moment of a run, wherever it comes from; nothing in it changes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import nan
from typing import TYPE_CHECKING

from pirate_sm.engine.engine import Engine
from pirate_sm.engine.evidence import Evidence
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.state import EngineState
from pirate_sm.geometry.route import Route
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.loading.mission.manual_mission import BY_HAND
from pirate_sm.model.true_position import Truth
from pirate_sm.showing.robot_anatomy import Anatomy
from pirate_sm.showing.run_history import Story

if TYPE_CHECKING:
    from pirate_sm.backends.serial.health import LinkHealth


@dataclass(frozen=True)
class Scene:
    """What stays the same while one mission is at hand.

    Attributes:
        loaded: The mission.
        engine: What runs it, or ran it.
        anatomy: What the robot is made of.
        backend: What it runs on.
    """

    loaded: LoadedMission
    engine: Engine
    anatomy: Anatomy
    backend: str

    @property
    def robot(self) -> RobotSpec:
        """Return the robot."""
        return self.loaded.robot

    @cached_property
    def route(self) -> Route | None:
        """Return the route through the pipe; None without a pipe."""
        return self.loaded.pipe.route() if self.loaded.pipe is not None else None

    @property
    def mission(self) -> str:
        """Return the name of the mission; empty while there is none."""
        name = self.loaded.mission.mission
        return "" if name == BY_HAND else name


@dataclass(frozen=True)
class Snapshot:
    """One moment.

    Attributes:
        now_s: Mission time; of a recording, time since its run began.
        state: The engine's; None before it has begun.
        story: What has happened.
        truth: Where the robot is; None where that is not known.
        reckoned: Whether that is reckoned from odometry, not known.
        link: How the link is; None where there is none.
        trends: The last values of the signals that the anatomy follows, oldest first.
        over: Whether nothing can happen any more.
        before_m: What the odometer had counted in the runs before this one.
        ahead_s: How much more than ``now_s`` the clock showed that the engine was given.
    """

    scene: Scene
    now_s: float
    state: EngineState | None
    story: Story
    truth: Truth | None = None
    reckoned: bool = False
    link: LinkHealth | None = None
    trends: Mapping[str, tuple[float, ...]] | None = None
    over: bool = False
    before_m: float = 0.0
    ahead_s: float = 0.0

    @property
    def engine_s(self) -> float:
        """Return the time that those in the engine's state are compared with."""
        return self.now_s + self.ahead_s

    @cached_property
    def signals(self) -> Mapping[str, float]:
        """Return every signal in SI, NaN where unknown."""
        return {} if self.state is None else self.scene.engine.signals(self.state)

    @cached_property
    def evidence(self) -> Mapping[str, Evidence]:
        """Return what has shown each state, clamp and signal; its times are those of the engine."""
        return {} if self.state is None else self.scene.engine.evidence(self.state)

    @property
    def odometry_m(self) -> float:
        """Return what the odometer has counted in this run; NaN where unknown."""
        place = self.scene.robot.odometry
        return nan if self.state is None or place < 0 else self.state.sensing.numbers[place]
