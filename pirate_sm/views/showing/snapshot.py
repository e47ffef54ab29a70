"""What views draw: one moment of a run, with what has happened so far; nothing in it changes."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite, isnan, nan
from typing import TYPE_CHECKING, Any, NamedTuple

from pirate_sm.core import effects as fx
from pirate_sm.core.engine import Engine, EngineState, Evidence
from pirate_sm.core.events import Truth
from pirate_sm.core.generated_missions import BY_HAND
from pirate_sm.core.geometry import Route
from pirate_sm.core.loading import TIME_LIMIT, LoadedMission
from pirate_sm.core.robot import RobotSpec
from pirate_sm.running.wiring import Prepared
from pirate_sm.views.showing.effect_lines import EffectLine, Teller
from pirate_sm.views.showing.robot_anatomy import Anatomy, anatomy_of

if TYPE_CHECKING:
    from pirate_sm.robot.backends.serial.link.health import LinkHealth


# --- what has happened so far -------------------------------------------------------------------


_KEPT = 300

ENDED = "ended"
"""Topic of the line that says how a mission ended."""

_ALARMING = {"fault", "warning", "error", ENDED}


class Visit(NamedTuple):
    """A phase and when it was entered."""

    phase: str
    since_s: float


class NumberedLine(NamedTuple):
    """A line, when it was shown, and its number."""

    number: int
    now_s: float
    line: EffectLine


class RunStory(NamedTuple):
    """What had happened by some moment.

    Attributes:
        phase: Where the mission is.
        spent_s: How long it has been in each phase that it has left.
        setpoints: The newest array; empty before the first.
        changed: Slots that the newest array changed.
        lines: How many lines there were.
        recent: The last lines.
        banner: The last of them that says how a mission ended.
        ended: How it ended.
        passed: Places of the waits that one of their triggers has ended, not their time limit.
        alarms: The last lines about something wrong or how a mission ended, oldest first.
        stopped: Whether a run was stopped, and no command has been accepted since.
        faults: When each fault was last found, by its code and message.
        stopped_in_phase: Where the mission was when it was stopped or failed; empty once it runs.
    """

    phase: Visit = Visit("", 0.0)
    spent_s: Mapping[str, float] = {}
    setpoints: tuple[float, ...] = ()
    changed: frozenset[int] = frozenset()
    lines: int = 0
    recent: tuple[NumberedLine, ...] = ()
    banner: NumberedLine | None = None
    ended: fx.Ended | None = None
    passed: frozenset[str] = frozenset()
    alarms: tuple[NumberedLine, ...] = ()
    stopped: bool = False
    faults: Mapping[tuple[str, str], float] = {}
    stopped_in_phase: str = ""


class Memory:
    """Follows what happens.

    Attributes:
        story: What has happened so far; replaced, never changed.
    """

    def __init__(
        self, robot: RobotSpec, *, nominal: bool = False, quiet: Container[str] = ()
    ) -> None:
        """Begin before anything has happened.

        Args:
            robot: Whose run it is.
            nominal: Whether it is a trace.
            quiet: Messages of ends that need no banner.
        """
        self._nominal = nominal
        self._quiet = quiet
        self._teller = Teller(robot, with_setpoints=False, short=True, nominal=nominal)
        self.story = RunStory()

    def begin(self, robot: RobotSpec, *, same_mission: bool = False) -> None:
        """Begin another mission; the lines and alarms so far stay, and how the last one ended.

        Args:
            robot: Whose run it is.
            same_mission: Whether it is that of the run before, whose phases and waits stay too.
        """
        self._teller = Teller(robot, with_setpoints=False, short=True, nominal=self._nominal)
        ended = self.story.ended
        left: dict[str, Any] = {"phase": Visit("", 0.0), "changed": frozenset(), "ended": None}
        if not same_mission or ended is None or ended.outcome == "succeeded":
            left |= {"spent_s": {}, "stopped_in_phase": "", "passed": frozenset()}
        self._note(**left)

    def see(self, effects: Sequence[fx.Effect], now_s: float) -> None:
        """Take in the effects."""
        for effect in effects:
            self._take_in(effect, now_s)
            for line in self._teller.lines(effect):
                self.tell(line, now_s)
            if isinstance(effect, fx.Ended):
                quiet = effect.outcome == "interrupted" and effect.message in self._quiet
                topic = "console" if quiet else ENDED
                self._note(stopped=not quiet and effect.outcome != "succeeded")
                self.tell(EffectLine(topic, f"{effect.outcome}: {effect.message}"), now_s)

    def tell(self, line: EffectLine, now_s: float) -> None:
        """Add a line to those that were shown."""
        story = self.story
        shown = NumberedLine(story.lines + 1, now_s, line)
        self._note(lines=shown.number, recent=(*story.recent, shown)[-_KEPT:])
        if line.topic in _ALARMING:
            self._note(alarms=(*story.alarms, shown)[-_KEPT:])
        if line.topic == ENDED:
            self._note(banner=shown)

    def lose(self, from_s: float, until_s: float) -> None:
        """Forget where the mission is: nothing is known of it between these times."""
        self.tell(
            EffectLine("recording", f"damaged: nothing is known until {until_s:.1f} s"), from_s
        )
        self._leave(from_s)
        self._note(phase=Visit("", until_s))

    def twin(self) -> Memory:
        """Return a copy that continues independently."""
        twin = copy(self)
        twin._teller = copy(self._teller)
        return twin

    def _note(self, **news: Any) -> None:
        self.story = self.story._replace(**news)

    def _take_in(self, effect: fx.Effect, now_s: float) -> None:
        story = self.story
        match effect:
            case fx.PhaseChange():
                self._enter(effect.phase, now_s)
            case fx.WaitArmed() if effect.phase != story.phase.phase:
                self._enter(effect.phase, now_s)  # back from a mission that it called
            case fx.TriggerFired() if effect.trigger != TIME_LIMIT:
                self._note(passed=story.passed | {effect.place})
            case fx.CommandStatus(status="sent" | "accepted"):
                self._note(stopped=False)
            case fx.Fault():
                self._note(faults={**story.faults, (effect.code, effect.message): now_s})
            case fx.Setpoints():
                before = story.setpoints or (0.0,) * len(effect.values)
                pairs = zip(before, effect.values, strict=True)
                changed = frozenset(i for i, (old, new) in enumerate(pairs) if old != new)
                self._note(setpoints=effect.values, changed=changed)
            case fx.Ended():
                self._note(stopped_in_phase=story.phase.phase or story.stopped_in_phase)
                self._leave(now_s)
                self._note(ended=effect)
            case _:
                pass

    def _enter(self, phase: str, now_s: float) -> None:
        story = self.story
        if story.stopped_in_phase and phase == next(iter(story.spent_s), ""):  # from the start
            self._note(spent_s={}, passed=frozenset())
        self._leave(now_s)
        self._note(phase=Visit(phase, now_s), stopped_in_phase="")

    def _leave(self, now_s: float) -> None:
        name, since_s = self.story.phase
        if name:
            spent_s = self.story.spent_s
            self._note(spent_s={**spent_s, name: spent_s.get(name, 0.0) + now_s - since_s})


# --- one moment ---------------------------------------------------------------------------------


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
        reckoned: Whether that is estimated from odometry, not known.
        link: How the link is; None where there is none.
        trends: The last values of the signals that the anatomy follows, oldest first.
        over: Whether nothing can happen any more.
        before_m: What the odometer had counted in the runs before this one.
        held_s: How long the run has made no newer snapshot, beyond what is usual; else 0.
        left: How long the run will still take by earlier runs, in words; empty if unknown.
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
    left: str = ""

    @property
    def engine_s(self) -> float:
        """Return the time that those in the engine's state are compared with."""
        return self.now_s + self.ahead_s

    @property
    def untouched(self) -> bool:
        """Return whether the mission has not begun, in this run or in one that it resumes."""
        state, program = self.state, self.scene.loaded.program
        if state is None or program.goes_on:
            return False
        return state.mission.pc == program.start and not state.mission.begun

    @property
    def stopped_in(self) -> str:
        """Return the phase in which the mission was stopped; empty once it continues elsewhere."""
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
        During a silence mission time is stopped: what was shown is as much older as nothing has
        been heard, counted from the last report.
        """
        shown_s = self._reported_s.get(name, nan)
        if isnan(shown_s):
            shown_s = self._shown_s(name)
        now_s = self.engine_s
        if self.unheard_s and self.state is not None:
            now_s = min(now_s, max(self.state.sensing.heard_s, default=now_s))
        if not isfinite(shown_s) or (self.over and self.link is not None):
            return nan
        return max(now_s - shown_s, 0.0) + self.unheard_s

    def _shown_s(self, name: str) -> float:
        return self.evidence[name].at_s if name in self.evidence else nan

    def is_fresh(self, signal: str) -> bool:
        """Return whether a signal is that of the current moment."""
        age_s = self.age_s(signal)
        return self.live and not age_s > self.scene.robot.link.stale_after_s

    def is_shown(self, region: str) -> bool:
        """Return whether a state has been shown since the controller was last connected to."""
        found = self.evidence.get(region)
        same = (
            found is None or self.state is None or found.connection == self.state.sensing.connection
        )
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
                    if not self._shown_s(name) > at_s + self.ahead_s:
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


# --- moments of a run under way ----------------------------------------------------------------


TREND_EVERY_S = 0.5
TREND_LENGTH = 120


def sent_name(slot: int) -> str:
    """Return under what name the setpoints of a slot are; no signal has such a name."""
    return f"setpoint {slot}"


class Trends:
    """The last values of the signals that a robot's anatomy follows, and of its motors' setpoints.

    Attributes:
        latest: They, oldest first, NaN where unknown; replaced, never changed.
    """

    def __init__(self) -> None:
        self._due_s = -inf
        self.latest: Mapping[str, tuple[float, ...]] = {}

    def look(self, scene: MissionScene, state: EngineState, now_s: float) -> None:
        """Note another value of each, when it is time."""
        if now_s < self._due_s:
            return
        self._due_s = now_s + TREND_EVERY_S
        signals = dict(scene.engine.signals(state))
        signals |= {sent_name(slot): sent for slot, sent in enumerate(state.robot.latest)}
        self.latest = {
            name: (*self.latest.get(name, ()), value)[-TREND_LENGTH:]
            for name in (*scene.anatomy.followed, *map(sent_name, scene.anatomy.slots))
            if (value := signals.get(name)) is not None
        }


def scene_of(prepared: Prepared) -> MissionScene:
    """Return what stays the same in a run."""
    loaded = prepared.loaded
    anatomy = anatomy_of(loaded.loaded_robot.profile, loaded.robot)
    return MissionScene(loaded, prepared.engine, anatomy, prepared.order.backend)


def snapshot_of(
    scene: MissionScene,
    prepared: Prepared,
    state: EngineState | None,
    now_s: float,
    story: RunStory,
    trends: Trends,
    *,
    over: bool = False,
    before_m: float = 0.0,
) -> Snapshot:
    """Return this moment of a run, with what its backend knows of place and link."""
    truth, reckoned = None, False
    if prepared.truth is not None:
        truth = prepared.truth()
    elif prepared.reckoned is not None:
        truth, reckoned = prepared.reckoned(), True
    link = prepared.link() if prepared.link and state is not None else None
    left = prepared.forecast.left(now_s) if prepared.forecast and not over else ""
    given = scene, now_s, state, story, truth, reckoned, link, trends.latest, over, before_m
    return Snapshot(*given, left=left)
