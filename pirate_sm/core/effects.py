"""Effects: the closed set of the engine's outputs, each with what views show of it.

Only the runtime performs them. ``Setpoints`` moves the robot; the others report something.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import degrees, inf, isnan, nan
from typing import Any, Literal, NamedTuple, TypeAlias, TypeVar

from pirate_sm.core._model.unmet import Unmet as Unmet  # noqa: PLC0414 - handed out

Level: TypeAlias = Literal["info", "warning", "error"]
SpanKind: TypeAlias = Literal[
    "phase", "state", "unconfirmed", "done", "failed", "open", "wait", "word", "question"
]
MarkKind: TypeAlias = Literal[
    "trigger", "fault", "error", "warning", "skipped", "refused", "operator", "end"
]

_Effect = TypeVar("_Effect", bound=tuple[Any, ...])


class LaneSpan(NamedTuple):
    """An interval that an effect begins on a lane of the timeline, which ends the one before.

    Attributes:
        lane: Name of the lane.
        text: What is written there; empty: no interval begins.
        kind: What it looks like.
        about: Details, shown on hovering.
    """

    lane: str
    text: str
    kind: SpanKind
    about: str = ""


class LaneMark(NamedTuple):
    """A mark that an effect sets on a lane of the timeline; attributes as of an interval."""

    lane: str
    text: str
    kind: MarkKind
    about: str = ""


class Display(NamedTuple):
    """What views show of one effect.

    Attributes:
        kind: Type of its JSON line; empty: it has none.
        text: The effect in words, after its topic. Empty: it has no line, or one that depends on
            what came before.
        topic: What the line is about, in a word; empty: the kind.
        level: How much it matters; None: too little for a log.
        entry: What it puts on the timeline.
        rows: Its rows in its table; None: one row with its fields.
        fields: What its JSON line says; None: its fields.
    """

    kind: str = ""
    text: str = ""
    topic: str = ""
    level: Level | None = "info"
    entry: LaneSpan | LaneMark | None = None
    rows: Sequence[tuple[Any, ...]] | None = None
    fields: Mapping[str, Any] | None = None

    @property
    def about(self) -> str:
        """Return what its line is about, in a word."""
        return self.topic or self.kind


EFFECT_TABLES: dict[type[Any], tuple[str, tuple[str, ...]]] = {}
"""The table of each class of effects that has one: its name and its columns."""


def with_table(name: str, *columns: str) -> Callable[[type[_Effect]], type[_Effect]]:
    """Declare the table of a class of effects; its columns are by default the fields."""

    def declare(effect: type[_Effect]) -> type[_Effect]:
        EFFECT_TABLES[effect] = name, columns or effect._fields  # type: ignore[attr-defined]
        return effect

    return declare


def with_reason(text: str, reason: str) -> str:
    """Return the text, followed by a colon and the reason if there is one."""
    return f"{text}: {reason}" if reason else text


CommandState: TypeAlias = Literal["sent", "accepted", "refused", "done", "failed", "skipped"]
Outcome: TypeAlias = Literal["succeeded", "failed", "interrupted", "fault"]


@with_table("setpoints")
class Setpoints(NamedTuple):
    """An array of setpoints to be sent, which takes effect in all slots at once.

    Attributes:
        setpoint_id: Increases by one with each new array; a resent array keeps its id.
        values: One value per slot in wire order: a duty cycle -1..1 or an angle in rad, depending
            on the slot's unit in the profile.
    """

    setpoint_id: int
    values: tuple[float, ...]

    def display(self) -> Display:
        """Return what views show of it."""
        said = {"id": self.setpoint_id, "values": self.values}
        return Display("setpoints", rows=[(self.setpoint_id, *self.values)], fields=said)


@with_table("commands", "name", "status", "reason", "place")
class CommandStatus(NamedTuple):
    """The status of a command has changed.

    Attributes:
        name: The command.
        status: The new status.
        reason: Why it was refused or failed, or why it counts as done; may be empty.
        place: Its place in the mission file, ``file:line:col``; empty for an operator's command.
        unmet: What a failed command has awaited, and what the sensors showed instead. The reason
            says the same where these conditions are why it failed.
    """

    name: str
    status: CommandState
    reason: str = ""
    place: str = ""
    unmet: tuple[Unmet, ...] = ()

    def display(self) -> Display:
        """Return what views show of it."""
        said = {**self._asdict(), "place": self.place or None}
        if self.status != "failed":
            del said["unmet"]
        text = with_reason(f"{self.name} {self.status}", self.reason)
        level: Level = "warning" if self.status in ("refused", "failed") else "info"
        return Display("command", text, level=level, fields=said)


class StateChange(NamedTuple):
    """The robot's configuration or its unconfirmed regions have changed.

    Attributes:
        states: State name per region, in the order of the chart.
        unconfirmed: Regions whose state is commanded but not confirmed.
    """

    states: tuple[str, ...]
    unconfirmed: tuple[str, ...]

    def display(self) -> Display:
        """Return what views show of it."""
        return Display("state")


@with_table("phases")
class PhaseChange(NamedTuple):
    """The mission has entered a phase."""

    phase: str

    def display(self) -> Display:
        """Return what views show of it."""
        said = {"phase": self.phase, "status": "entered"}
        span = LaneSpan("phase", self.phase, "phase")
        return Display("phase", self.phase, entry=span, fields=said)


@with_table("waits", "phase", "trigger", "condition", "deadline_s")
class WaitArmed(NamedTuple):
    """A phase or a step has begun to wait.

    Attributes:
        phase: Name of the phase.
        triggers: Names of the triggers in listed order.
        conditions: The condition of each trigger, as in the file.
        deadline_s: Mission time at which ``within`` ends the wait; infinite without a limit.
        place: Where the wait stands, ``file:line:col``.
    """

    phase: str
    triggers: tuple[str, ...]
    conditions: tuple[str, ...]
    deadline_s: float
    place: str = ""

    @property
    def condition(self) -> str:
        """Return all that it waits for."""
        return " or ".join(self.conditions)

    def display(self) -> Display:
        """Return what views show of it."""
        waits = list(zip(self.triggers, self.conditions, strict=True))
        limit = f", at most until {self.deadline_s:.1f} s" if self.deadline_s < inf else ""
        return Display(
            "phase",
            f"for {self.condition}{limit}",
            "waits",
            entry=LaneSpan("waits for", self.condition, "wait", self.phase),
            rows=[(self.phase, *each, self.deadline_s) for each in waits],
            fields={
                "phase": self.phase,
                "status": "waiting",
                "triggers": [{"trigger": name, "condition": text} for name, text in waits],
                "deadline_s": self.deadline_s,
            },
        )


TAKEN = "taken by the operator"
"""Reason of a trigger fired by the operator, or by a script in place of an operator."""


@with_table("triggers")
class TriggerFired(NamedTuple):
    """A wait has ended.

    Attributes:
        phase: The phase that waited.
        trigger: Name of the trigger; ``within`` for the time limit.
        go: The next phase or end.
        reason: Why it fired.
        place: Where the wait stands, ``file:line:col``.
    """

    phase: str
    trigger: str
    go: str
    reason: str
    place: str = ""

    def seen(self, *, nominal: bool) -> TriggerFired:
        """Return it as views show it: in a trace only the script can skip a wait."""
        taken = nominal and self.reason == TAKEN
        return self._replace(reason="taken by the trace") if taken else self

    def display(self) -> Display:
        """Return what views show of it."""
        text = f"{self.reason} → {self.go}"
        mark = LaneMark("triggers", self.trigger, "trigger", text)
        return Display("trigger", text, entry=mark, fields=self._asdict())


@with_table("detector")
class Detected(NamedTuple):
    """The valid word of the detector has changed."""

    word: str

    def display(self) -> Display:
        """Return what views show of it."""
        return Display("detected", self.word, entry=LaneSpan("detector", self.word, "word"))


@with_table("environment")
class Environment(NamedTuple):
    """The properties of the pipe around the robot have changed by more than noise.

    Attributes:
        segment: ``Out``, ``Straight`` or ``Joint`` (thesis section 4-3-2); empty is unknown.
        roll_rad: Roll of the robot about the axis of the pipe, against the horizontal; NaN is
            unknown, as for the others.
        pitch_rad: Pitch of the pipe's axis, positive where it climbs ahead of the robot.
        diameter_m: Inner diameter, h + 2r (thesis eq. 3-2).
        joint: The joint that the robot is in, or the next one ahead: ``mitre``, ``elbow``, ``tee``,
            ``reducer`` or ``end``; empty is unknown.
        junction: Name of the tee that the joint is; empty is unknown or none.
        opening_roll_rad: Towards where the pipe turns or opens there: the roll about the direction
            of travel, against the front part's plane; 0 is towards side A of a robot in normal
            polarity.
        distance_m: Distance from the first wheel to the joint; negative behind it.
        diameter_ahead_m: Inner diameter behind the joint.
        run: Name of the run of the pipe that the first wheel is in; empty is unknown.
        arc_m: Place of the first wheel along the route.
    """

    segment: str
    roll_rad: float
    pitch_rad: float
    diameter_m: float
    joint: str = ""
    junction: str = ""
    opening_roll_rad: float = nan
    distance_m: float = nan
    diameter_ahead_m: float = nan
    run: str = ""
    arc_m: float = nan

    @property
    def measures(self) -> str:
        """Return what is known of roll, pitch, diameter and joint as text; empty if nothing is."""
        known = [
            f"{name} {degrees(angle):z.0f}°"
            for name, angle in (("roll", self.roll_rad), ("pitch", self.pitch_rad))
            if not isnan(angle)
        ]
        if not isnan(self.diameter_m):
            known.append(f"inner diameter {self.diameter_m * 1e3:.1f} mm")
        if self.joint:
            known.append(self._joint_words)
        return ", ".join(known)

    @property
    def _joint_words(self) -> str:
        words = " ".join(filter(None, (self.joint, self.junction)))
        if not isnan(self.distance_m):
            where = "ahead" if self.distance_m >= 0 else "back"
            words += f" {abs(self.distance_m) * 1e3:.0f} mm {where}"
        if not isnan(self.diameter_ahead_m):
            words += f", behind it {self.diameter_ahead_m * 1e3:.1f} mm"
        return words

    def display(self) -> Display:
        """Return what views show of it."""
        text = ", ".join(filter(None, (self.segment or "unknown", self.measures)))
        span = LaneSpan("pipe", self.segment, "word", self.measures)
        return Display("environment", text, "pipe", None, span)


@with_table("faults")
class Fault(NamedTuple):
    """A fault has been found.

    Attributes:
        code: Code of the fault, as missions write it.
        message: One sentence for the operator.
        handling: ``continue``, the target phase, or ``stop``.
        of: The boards, joints, wheels and parts that it is a fault of; empty: nobody's.
    """

    code: str
    message: str
    handling: str
    of: tuple[str, ...] = ()

    def display(self) -> Display:
        """Return what views show of it."""
        then = {"continue": "logged, the mission continues", "stop": "safe stop"}
        ending = then.get(self.handling, f"→ {self.handling}")
        return Display(
            "fault",
            f"{self.code}: {self.message} ({ending})",
            level="error" if self.handling == "stop" else "warning",
            entry=LaneMark("faults", self.code, "fault", f"{self.message} ({ending})"),
        )


@with_table("log")
class Log(NamedTuple):
    """A log line for the operator."""

    level: Level
    message: str

    def display(self) -> Display:
        """Return what views show of it."""
        if self.level == "info":
            return Display("log", self.message)
        mark = LaneMark("faults", self.message, self.level)
        return Display("log", self.message, self.level, self.level, mark)


@with_table("questions")
class Ask(NamedTuple):
    """The mission needs an answer from the operator.

    Attributes:
        question: The question; empty when the open question is withdrawn.
        choices: The possible answers; the first is the expected one.
    """

    question: str
    choices: tuple[str, ...]

    @property
    def answers(self) -> str:
        """Return its choices in words."""
        return " / ".join(self.choices)

    def display(self) -> Display:
        """Return what views show of it."""
        text = f"{self.question} ({self.answers})" if self.question else ""
        return Display(
            "log",
            text,
            "asks",
            entry=LaneSpan("operator", self.question, "question", self.answers),
            rows=[(self.question, self.answers)],
            fields={"level": "info", "message": text or "the question is withdrawn"},
        )


class WakeAt(NamedTuple):
    """The next deadline: without an event nothing changes before ``at_s``; infinite: never."""

    at_s: float

    def display(self) -> Display:
        """Return what views show of it."""
        return Display()


@with_table("end")
class Ended(NamedTuple):
    """The run has ended, after the safe stop.

    Attributes:
        outcome: How it ended.
        message: Why, in one sentence.
        end: Name of the mission's end; empty if it ended otherwise.
    """

    outcome: Outcome
    message: str
    end: str = ""

    def display(self) -> Display:
        """Return what views show of it."""
        return Display(
            "end",
            f"{self.outcome}: {self.message}",
            "ended",
            "info" if self.outcome == "succeeded" else "error",
            entry=LaneMark("phase", self.end or self.outcome, "end", self.message),
            fields={"outcome": self.outcome, "end": self.end or None, "message": self.message},
        )


Effect: TypeAlias = (
    Setpoints
    | CommandStatus
    | StateChange
    | PhaseChange
    | WaitArmed
    | TriggerFired
    | Detected
    | Environment
    | Fault
    | Log
    | Ask
    | WakeAt
    | Ended
)


def display_of(effect: Effect, *, nominal: bool = False) -> Display:
    """Return what views show of an effect of a run, or of a trace if ``nominal``."""
    return (effect.seen(nominal=nominal) if isinstance(effect, TriggerFired) else effect).display()
