"""What moves the robot without a mission: a key that is held, and series of confirmed commands."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Sequence
from math import degrees, inf, isnan, nan
from threading import Lock
from typing import NamedTuple

from rich.text import Text

from pirate_sm.core.companion import CompanionBase
from pirate_sm.core.effects import CommandStatus, Effect, Ended, Fault, Log
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import Event, GoTo, OperatorCommand
from pirate_sm.core.robot import RobotSpec
from pirate_sm.views.console.availability import arrows_for, ways
from pirate_sm.views.showing.snapshot import Snapshot
from pirate_sm.views.showing.text_styles import MUTED, line

# --- by hand ------------------------------------------------------------------------------------


LOOK_EVERY_S = 0.02
"""The longest delay of a stop after a key, and of a command after the one before."""

FIRST_REPEAT_S = 0.8
"""Keyboards repeat a key that is held for the first time after 0.25 s to 0.75 s."""

NEXT_REPEAT_S = 0.35
"""Keyboards repeat it every 20 ms to 100 ms from then on; the rest is for a slow connection."""

SPEEDS = (0.2, 0.4, 0.6, 0.8, 1.0)
"""Shares of the speed of a drive."""

LIMITS_M = (inf, 0.05, 0.1, 0.2, 0.5, nan)
"""Distances after which a drive stops; NaN is before the joint ahead."""

JOINT_CLEARANCE_M = 0.06
"""A drive stops this far before a joint, and warns of one at twice the distance [decided]."""

_AT_STOP = 0.98
"""A joint at this share of its end stop's angle is on it [decided]."""

_OFF_STOP = 0.95
"""Below this share it has come off it again [decided]."""


class SaidPlace(NamedTuple):
    """Where somebody has said that the first wheel is, m along the route, and what it had come."""

    said_m: float = nan
    came_m: float = nan


class HandDriving(CompanionBase):
    """A companion of the console's runs that stops what is driven by hand.

    A terminal reports no release of a key. A key counts as held until its repeats stay away, which
    the run's thread notices, so a console that hangs stops the robot too.

    Args:
        latest: Returns the newest snapshot.
        factor: Mission seconds per second of the wall clock.

    Attributes:
        speed: The share of the speed of the next drive.
        limit_m: One of ``LIMITS_M``.
        place: Where the robot is, as somebody has said.
    """

    def __init__(self, latest: Callable[[], Snapshot], factor: float = 1.0) -> None:
        self.speed, self.limit_m, self.place = 1.0, inf, SaidPlace()
        self._latest, self._factor = latest, factor
        self._pressed = self._held = ""
        self._until_s = self._deaf_s = -inf
        self._from_m = nan
        self._braking = False
        self._due_s = -inf
        self._warned: set[str] = set()
        self._says: list[Event] = []

    # --- from the console's thread ------------------------------------------------------------

    def press(self, command: str) -> None:
        """Drive while the key of this command is held: call it for the key and each repeat."""
        self._pressed = command

    def holds(self, command: str) -> bool:
        """Return whether the key of this command is held and drives."""
        return self._held == command

    def release(self) -> None:
        """Stop if a key was held, because it can have been released unseen."""
        self._braking, self._pressed = self._braking or bool(self._held), ""

    def faster(self, steps: int) -> None:
        """Choose the next speed; a drive under way keeps its own."""
        at = SPEEDS.index(self.speed) + steps
        self.speed = SPEEDS[min(max(at, 0), len(SPEEDS) - 1)]

    def other_limit(self) -> None:
        """Choose the next limit."""
        at = next(n for n, each in enumerate(LIMITS_M) if str(each) == str(self.limit_m))
        self.limit_m = LIMITS_M[(at + 1) % len(LIMITS_M)]

    def lines(self) -> list[Text]:
        """Return how fast and how far the next drive by hand goes, for people."""
        far = "no limit" if self.limit_m == inf else f"{self.limit_m * 1e3:.0f} mm"
        far = "to the joint" if isnan(self.limit_m) else far
        keys = ("↑↓ drive ", MUTED), f"{self.speed:.0%}", (" (+ -), ", MUTED), far, (" (=)", MUTED)
        here_m = place_m(self._latest(), self.place)
        unknown = "–" if isnan(self.place.said_m) else "not known"
        here = unknown if isnan(here_m) else f"{here_m:.2f} m"
        return [line(*keys), line(("wheel 1 at ", MUTED), here, (" (@: type it)", MUTED))]

    def why_not(self, command: str) -> str:
        """Return why this command cannot be given with the limit; empty if it can."""
        snapshot = self._latest()
        way = ways(snapshot.scene.robot).get(command, 0)
        if not way or not isnan(self.limit_m):
            return ""
        if way < 0:
            return "a joint behind is not watched: choose a distance"
        known = not isnan(joint_ahead_m(snapshot, self.place))
        return "" if known else "the distance to the joint is not known: choose a distance"

    # --- from the run's thread ----------------------------------------------------------------

    @property
    def due_s(self) -> float:
        """At once after a key; else at the next look."""
        return -inf if self._pressed else self._due_s

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Find out what is to be said now: a drive, a brake, a warning."""
        self._due_s = now_s + LOOK_EVERY_S
        self._says.clear()
        snapshot = self._latest()
        robot, by_hand = snapshot.scene.robot, state.mission.paused
        drives = any(state.robot.latest[slot] for slot in robot.safe_zero)
        self._hear(robot, state, now_s)
        if not (drives and by_hand):
            self._from_m, self._braking = nan, False
            self._held = self._held if now_s < self._until_s else ""
            self._warned.discard("joint")
            return self._warn(snapshot, ()) if by_hand else ()
        if isnan(self._from_m):
            self._from_m = snapshot.odometry_m
        ahead_m = joint_ahead_m(snapshot, self.place)
        if self._held and now_s >= self._until_s:
            self._braking = True
        came_m = abs(snapshot.odometry_m - self._from_m)
        why = self._why_to_stop(came_m, ahead_m)
        logs = []
        if why and not self._braking:
            self._braking, self._deaf_s = True, now_s + FIRST_REPEAT_S * self._factor
            chosen = self.limit_m <= came_m  # by the operator, who needs no alarm
            logs.append(Log("info" if chosen else "warning", f"the drive stops: {why}"))
        if self._braking:
            self._held = ""
            self._brake(robot, state)
        forward = robot.travel(state.robot.latest) > 0
        near = (ahead_m,) if forward and ahead_m < 2 * JOINT_CLEARANCE_M else ()
        return [*logs, *self._warn(snapshot, near)]

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the drive or the brake."""
        return tuple(self._says)

    def _hear(self, robot: RobotSpec, state: EngineState, now_s: float) -> None:
        """Begin or keep up the drive whose key was pressed."""
        command, self._pressed = self._pressed, ""
        if not command:
            return
        if now_s < self._deaf_s:  # still held since it was stopped
            self._deaf_s = now_s + FIRST_REPEAT_S * self._factor
        elif command == self._held:
            self._until_s = now_s + NEXT_REPEAT_S * self._factor
        elif not state.why_not_command(robot, robot.table.command_index[command]):
            self._held, self._until_s = command, now_s + FIRST_REPEAT_S * self._factor
            self._braking = False
            self._says.append(OperatorCommand(command, self.speed))

    def _brake(self, robot: RobotSpec, state: EngineState) -> None:
        brake = arrows_for(robot)["left"]
        if not state.why_not_command(robot, robot.table.command_index[brake], at_once=True):
            self._says.append(OperatorCommand(brake, at_once=True))

    def _why_to_stop(self, came_m: float, ahead_m: float) -> str:
        if isnan(self.limit_m):
            near = not ahead_m > JOINT_CLEARANCE_M
            return f"the joint is {ahead_m * 1e3:.0f} mm ahead" if near else ""
        if self.limit_m == inf or came_m < self.limit_m:
            return ""
        unknown = isnan(came_m)
        return f"it has come {'an unknown way' if unknown else f'{came_m * 1e3:.0f} mm'}"

    def _warn(self, snapshot: Snapshot, near: Sequence[float]) -> Sequence[Log]:
        """Return a warning for each thing that has newly become so."""
        stops = on_stops(snapshot, self._warned)
        now = {f"{name} is on its end stop at {angle}": name for name, angle in stops}
        now |= {f"a joint of the pipe is {each * 1e3:.0f} mm ahead": "joint" for each in near}
        kept = {"joint"} if "joint" in self._warned else set()
        new = [text for text, what in now.items() if what not in self._warned]
        self._warned = {*now.values(), *kept}
        return [Log("warning", text) for text in new]


def place_m(snapshot: Snapshot, place: SaidPlace) -> float:
    """Return where the first wheel is by what somebody has said and odometry since, m; or NaN."""
    return place.said_m + came_m(snapshot) - place.came_m


def is_still(snapshot: Snapshot) -> bool:
    """Return whether nothing moves, and nothing but the operator can move anything."""
    state, robot = snapshot.state, snapshot.scene.robot
    if state is None or not state.mission.paused or state.robot.motion or state.robot.awaited:
        return False
    return not any(state.robot.latest[slot] for slot in robot.safe_zero)


def came_m(snapshot: Snapshot) -> float:
    """Return what the odometer has counted in the whole session, m; NaN where unknown."""
    return snapshot.before_m + snapshot.odometry_m


def joint_ahead_m(snapshot: Snapshot, place: SaidPlace) -> float:
    """Return how far the next joint of the pipe is ahead of the first wheel, m; NaN if unknown."""
    state, route = snapshot.state, snapshot.scene.route
    reported_m = state.surveyed.reported.distance_m if state is not None else nan
    if reported_m >= 0:  # less is a joint behind
        return reported_m
    if route is None:
        return nan
    here_m = place_m(snapshot, place)
    ahead = [each.arc_m - each.before_m - here_m for each in route.joints]
    return nan if isnan(here_m) else min((each for each in ahead if each >= 0), default=inf)


def on_stops(snapshot: Snapshot, known: Container[str] = ()) -> Iterator[tuple[str, str]]:
    """Yield each joint of the robot that is on its end stop, with its angle in words.

    One that is known to be there must come farther away, since its sensor is noisy.
    """
    for motor in snapshot.scene.anatomy.joints:
        angle_rad = snapshot.signals.get(motor.value, nan)
        share = _OFF_STOP if motor.name in known else _AT_STOP
        if motor.limit and abs(angle_rad) >= share * motor.limit:
            yield motor.name, f"{degrees(angle_rad):.0f}°"


# --- series of commands -------------------------------------------------------------------------


BY_OPERATOR = "the operator has stopped it"
RUN_OVER = "the run has ended"


class CommandSeries(NamedTuple):
    """A series of commands and its progress; immutable.

    Attributes:
        commands: Names of the commands.
        then: The hand-back of the mission after the last of them.
        done: Number of done commands.
        given: Whether the next one has been given.
        stopped: Why the series has stopped; empty while it continues.
        handed_back: Whether all are done and the mission has been handed back.
    """

    commands: tuple[str, ...]
    then: GoTo
    done: int = 0
    given: bool = False
    stopped: str = ""
    handed_back: bool = False

    @property
    def active(self) -> bool:
        """Whether the series continues."""
        return not self.stopped and not self.handed_back

    @property
    def current(self) -> str:
        """The next or present command; empty after the last."""
        return self.commands[self.done] if self.done < len(self.commands) else ""


class Giver(CompanionBase):
    """A companion of the console's runs that gives a series of commands.

    A command follows when the one before is done. A refusal, a failure or a fault stops the series,
    and so does any other request of the operator.

    Attributes:
        series: The newest series; None before the first.
    """

    def __init__(self) -> None:
        self.series: CommandSeries | None = None
        self._lock = Lock()  # a request to stop must not be lost while the next command is given
        self._busy = True
        self._due_s = -inf

    # --- from the console's thread ------------------------------------------------------------

    def give(self, commands: Sequence[str], then: GoTo) -> None:
        """Begin a series; abandon the current one."""
        with self._lock:
            self._due_s = -inf
            self.series = CommandSeries(tuple(commands), then)

    def stop(self, why: str = BY_OPERATOR) -> None:
        """Give no further command; a command under way runs until it is done."""
        with self._lock:
            series = self.series
            if series is not None and series.active:
                self.series = series._replace(stopped=why)

    # --- from the run's thread ----------------------------------------------------------------

    @property
    def due_s(self) -> float:
        """Soon while a series is under way; else infinite."""
        return self._due_s if self.series is not None and self.series.active else inf

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Note the end of the command under way, and any event that stops the series."""
        for effect in effects:
            series = self.series
            if series is None or not series.active:
                return
            match effect:
                case CommandStatus(name=series.current, place="") if series.given:
                    self._note(effect)
                case Fault():
                    self.stop(f"{effect.code}: {effect.message}")
                case Ended():
                    self.stop(RUN_OVER)
                case _:
                    pass

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Find out whether the next command would be accepted now."""
        robot = state.robot
        under_way = robot.motion is not None and not state.mission.suspended
        self._busy = under_way or robot.awaited is not None
        self._due_s = now_s + LOOK_EVERY_S
        return ()

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the next command when the one before is done; at the end the hand-back."""
        with self._lock:
            series = self.series
            if series is None or not series.active or series.given or self._busy:
                return ()
            if series.current:
                self.series = series._replace(given=True)
                return (OperatorCommand(series.current),)
            self.series = series._replace(handed_back=True)
            return (series.then,)

    def _note(self, status: CommandStatus) -> None:
        if status.status == "done":
            with self._lock:
                series = self.series
                if series is not None and series.given:
                    self.series = series._replace(done=series.done + 1, given=False)
        elif status.status in ("failed", "refused", "skipped"):
            reason = f": {status.reason}" if status.reason else ""
            self.stop(f"{status.name} {status.status}{reason}")
