"""What has happened in a run so far, as far as the engine's state does not hold it."""

from __future__ import annotations

from collections import deque
from collections.abc import Container, Mapping, Sequence
from copy import copy
from typing import NamedTuple

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.loading.mission.wait_writer import TIME_LIMIT
from pirate_sm.model import effects as fx
from pirate_sm.showing.effect_lines import Line, Teller

_KEPT = 300

ENDED = "ended"
"""Topic of the line that says how a mission ended."""

_ALARMING = {"fault", "warning", "error", ENDED}


class Visit(NamedTuple):
    """A phase and when it was entered."""

    phase: str
    since_s: float


class NumberedLine(NamedTuple):
    """A line, when it was told, and the how many-th it is."""

    number: int
    now_s: float
    line: Line


class Story(NamedTuple):
    """What had happened by some moment; attributes as of :class:`Memory`."""

    phase: Visit
    spent_s: Mapping[str, float]
    wait: tuple[fx.WaitArmed, float] | None
    question: fx.Ask | None
    setpoints: tuple[float, ...]
    recent: tuple[NumberedLine, ...]
    ended: fx.Ended | None
    banner: NumberedLine | None = None
    passed: frozenset[str] = frozenset()
    alarms: tuple[NumberedLine, ...] = ()
    stopped: bool = False
    faults: Mapping[tuple[str, str], float] = {}
    stopped_in_phase: str = ""


class Memory:
    """What has happened so far.

    Attributes:
        phase: Where the mission is.
        spent_s: How long it has been in each phase that it has left.
        wait: What it waits for, and since when; None while it does not.
        question: What the operator is asked; None while nothing is.
        setpoints: The newest array; empty before the first.
        changed: Slots that the newest array changed.
        recent: The last lines.
        banner: The last of them that says how a mission ended.
        ended: How it ended.
        passed: Places of the waits that one of their triggers has ended, not their time limit.
        alarms: The last lines that tell of something wrong or how a mission ended, oldest first.
        stopped: Whether a run was stopped, and no command has been accepted since.
        faults: When each fault was last found, by its code and message; replaced, never changed.
        stopped_in_phase: Where the mission was when it was stopped or failed; empty once it runs.
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
        self.phase = Visit("", 0.0)
        self.spent_s: dict[str, float] = {}
        self.wait: tuple[fx.WaitArmed, float] | None = None
        self.setpoints: tuple[float, ...] = ()
        self.changed: frozenset[int] = frozenset()
        self.recent: deque[NumberedLine] = deque(maxlen=_KEPT)
        self.banner: NumberedLine | None = None
        self.question: fx.Ask | None = None
        self.ended: fx.Ended | None = None
        self.passed: frozenset[str] = frozenset()
        self.alarms: tuple[NumberedLine, ...] = ()
        self.stopped = False
        self.faults: Mapping[tuple[str, str], float] = {}
        self.stopped_in_phase = ""
        self._told = 0

    def begin(self, robot: RobotSpec, *, same_mission: bool = False) -> None:
        """Begin another mission; the lines and alarms so far stay, and how the last one ended.

        Args:
            robot: Whose run it is.
            same_mission: Whether it is that of the run before, whose phases and waits stay too.
        """
        fresh = Memory(robot, nominal=self._nominal, quiet=self._quiet)
        undone = same_mission and self.ended is not None and self.ended.outcome != "succeeded"
        phases = ("spent_s", "stopped_in_phase", "passed") if undone else ()
        for name in (
            "recent",
            "_told",
            "banner",
            "alarms",
            "stopped",
            "faults",
            "setpoints",
            *phases,
        ):
            setattr(fresh, name, getattr(self, name))
        self.__dict__.update(fresh.__dict__)

    def see(self, effects: Sequence[fx.Effect], now_s: float) -> None:
        """Take in the effects."""
        for effect in effects:
            self._note(effect, now_s)
            if isinstance(effect, fx.CommandStatus) and effect.status in ("sent", "accepted"):
                self.stopped = False
            if isinstance(effect, fx.Fault):
                self.faults = {**self.faults, (effect.code, effect.message): now_s}
            for line in self._teller.lines(effect):
                self.tell(line, now_s)
            if isinstance(effect, fx.Ended):
                quiet = effect.outcome == "interrupted" and effect.message in self._quiet
                topic = "console" if quiet else ENDED
                self.stopped = not quiet and effect.outcome != "succeeded"
                self.tell(Line(topic, f"{effect.outcome}: {effect.message}"), now_s)

    def tell(self, line: Line, now_s: float) -> None:
        """Add a line to those that were shown."""
        self._told += 1
        told = NumberedLine(self._told, now_s, line)
        self.recent.append(told)
        if line.topic in _ALARMING:
            self.alarms = (*self.alarms, told)[-_KEPT:]
        if line.topic == ENDED:
            self.banner = told

    def lose(self, from_s: float, until_s: float) -> None:
        """Forget where the mission is: nothing is known of it between these times."""
        self.tell(Line("recording", f"damaged: nothing is known until {until_s:.1f} s"), from_s)
        self._leave(from_s)
        self.phase, self.wait, self.question = Visit("", until_s), None, None

    def story(self) -> Story:
        """Return all of it as it is now, in a form that does not change."""
        now = {name: getattr(self, name) for name in Story._fields}
        return Story(**{**now, "spent_s": {**self.spent_s}, "recent": tuple(self.recent)})

    def twin(self) -> Memory:
        """Return a copy that goes on independently."""
        twin = copy(self)
        twin._teller, twin.recent, twin.spent_s = (
            copy(self._teller),
            self.recent.copy(),
            {**self.spent_s},
        )
        return twin

    def _note(self, effect: fx.Effect, now_s: float) -> None:
        match effect:
            case fx.PhaseChange():
                self._enter(effect.phase, now_s)
                self.wait = self.question = None
            case fx.Ask():
                self.question = effect if effect.question else None
            case fx.WaitArmed():
                if effect.phase != self.phase.phase:  # back from a mission that it called
                    self._enter(effect.phase, now_s)
                self.wait = effect, now_s
            case fx.TriggerFired():
                self.wait = None
                if effect.trigger != TIME_LIMIT:
                    self.passed |= {effect.place}
            case fx.Setpoints():
                before = self.setpoints or (0.0,) * len(effect.values)
                pairs = zip(before, effect.values, strict=True)
                self.changed = frozenset(i for i, (old, new) in enumerate(pairs) if old != new)
                self.setpoints = effect.values
            case fx.Ended():
                self.stopped_in_phase = self.phase.phase or self.stopped_in_phase
                self._leave(now_s)
                self.ended, self.wait, self.question = effect, None, None
            case _:
                pass

    def _enter(self, phase: str, now_s: float) -> None:
        if self.stopped_in_phase and phase == next(iter(self.spent_s), ""):  # from the start
            self.spent_s, self.passed = {}, frozenset()
        self._leave(now_s)
        self.phase, self.stopped_in_phase = Visit(phase, now_s), ""

    def _leave(self, now_s: float) -> None:
        name, since_s = self.phase
        if name:
            self.spent_s[name] = self.spent_s.get(name, 0.0) + now_s - since_s
