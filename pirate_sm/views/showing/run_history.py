"""What has happened in a run so far, as far as the engine's state does not hold it."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from copy import copy
from typing import Any, NamedTuple

from pirate_sm.core import effects as fx
from pirate_sm.core.loading import TIME_LIMIT
from pirate_sm.core.robot import RobotSpec
from pirate_sm.views.showing.effect_lines import EffectLine, Teller

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
