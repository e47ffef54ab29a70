"""What views draw: one moment of a run, wherever it comes from; nothing in it changes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite, isnan, nan
from typing import TYPE_CHECKING

from pirate_sm.core.engine import NOTHING, Engine, EngineState, Evidence
from pirate_sm.core.geometry import Route
from pirate_sm.core.loading import BY_HAND, LoadedMission
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.simulation import Truth
from pirate_sm.views.showing.robot_anatomy import Anatomy
from pirate_sm.views.showing.run_history import RunStory

if TYPE_CHECKING:
    from pirate_sm.robot.backends.serial.link.health import LinkHealth


@dataclass(frozen=True)
class MissionScene:
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
        held_s: How long the run has made no newer snapshot, beyond what is usual; else 0.
        ahead_s: How much more than ``now_s`` the clock showed that the engine was given.
    """

    scene: MissionScene
    now_s: float
    state: EngineState | None
    story: RunStory
    truth: Truth | None = None
    reckoned: bool = False
    link: LinkHealth | None = None
    trends: Mapping[str, tuple[float, ...]] | None = None
    over: bool = False
    before_m: float = 0.0
    ahead_s: float = 0.0
    held_s: float = 0.0

    @property
    def engine_s(self) -> float:
        """Return the time that those in the engine's state are compared with."""
        return self.now_s + self.ahead_s

    @property
    def untouched(self) -> bool:
        """Return whether the mission has not begun, in this run or in one that it goes on from."""
        state, program = self.state, self.scene.loaded.program
        if state is None or program.goes_on:
            return False
        return state.mission.pc == program.start and not state.mission.begun

    @property
    def stopped_in(self) -> str:
        """Return the phase in which the mission was stopped; empty once it goes on elsewhere."""
        return self.story.stopped_in_phase if self.untouched else ""

    @property
    def unheard_s(self) -> float:
        """Return how long nothing has come from the robot; 0 while reports come."""
        silent_s = self.link.silent_s if self.link is not None and self.link.trouble else 0.0
        return silent_s + self.held_s

    @property
    def live(self) -> bool:
        """Return whether the robot reports; a simulator always does."""
        return not self.unheard_s and not (self.over and self.link is not None)

    @cached_property
    def _reported_s(self) -> Mapping[str, float]:
        """Return when the board of each signal last reported; others need every wheel's board."""
        if self.state is None or self.scene.engine.nominal:
            return {}
        robot, heard_s = self.scene.robot, self.state.sensing.heard_s
        names, boards = robot.vocabulary.numbers, robot.boards.values()
        wheels_s = min((heard_s[at] for at in robot.wheel_boards), default=inf)
        found = {name: wheels_s for name in names if name not in robot.outside}
        return found | {names[at]: heard_s[it.position] for it in boards for at in it.numbers}

    def age_s(self, name: str) -> float:
        """Return how long ago a state, clamp or signal was shown, s; NaN if it never was.

        Also NaN after the end, since a snapshot does not know how long ago that was.
        During a silence mission time stands still: what was shown is as much older as nothing has
        been heard, counted from the last report.
        """
        shown_s = self._reported_s.get(name, nan)
        if isnan(shown_s):
            shown_s = self.evidence.get(name, NOTHING).at_s
        now_s = self.engine_s
        if self.unheard_s and self.state is not None:
            now_s = min(now_s, max(self.state.sensing.heard_s, default=now_s))
        if not isfinite(shown_s) or (self.over and self.link is not None):
            return nan
        return max(now_s - shown_s, 0.0) + self.unheard_s

    def is_fresh(self, signal: str) -> bool:
        """Return whether a signal is that of the present moment."""
        age_s = self.age_s(signal)
        return self.live and not age_s > self.scene.robot.link.stale_after_s

    def is_shown(self, region: str) -> bool:
        """Return whether a state has been shown since the controller was last connected to."""
        found = self.evidence.get(region)
        same = found is None or self.state is None or found.connection == self.state.connection
        return self.live and same

    @cached_property
    def doubts(self) -> Mapping[str, str]:
        """Return the faults against states that nothing has shown since, by region.

        A rule of the robot contradicts the states that its condition names.
        """
        found: dict[str, str] = {}
        for rule in self.scene.robot.faults:
            at_s = self.story.faults.get((rule.code, rule.message))
            if at_s is not None:
                for name in rule.when.names.intersection(self.scene.robot.regions):
                    if not self.evidence.get(name, NOTHING).at_s > at_s + self.ahead_s:
                        found[name] = f"{rule.code}: {rule.message}"
        return found

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
