"""Effects as lines for a person."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import takewhile
from math import ceil, degrees, isfinite, isnan
from typing import TYPE_CHECKING, NamedTuple

from pirate_sm.core import effects as fx
from pirate_sm.core.robot import RobotSpec, SlotSpec

if TYPE_CHECKING:
    from pirate_sm.robot.backends.serial.link.health import LinkHealth


class EffectLine(NamedTuple):
    """One line: what it is about in a word, and what there is to say."""

    topic: str
    text: str


class Teller:
    """Turns effects into lines; remembers what it has said so that it tells changes only."""

    def __init__(
        self, robot: RobotSpec, *, with_setpoints: bool, short: bool = False, nominal: bool = False
    ) -> None:
        """Begin with nothing said.

        Args:
            robot: Whose slots and regions they are.
            with_setpoints: Whether setpoints are shown.
            short: Whether regions are named without the ending that they share.
            nominal: Whether it is a trace, where no operator takes a trigger but its script.
        """
        self._robot = robot
        self._labels = shortened(robot.regions) if short else list(robot.regions)
        self._with_setpoints = with_setpoints
        self._nominal = nominal
        self._values: tuple[float, ...] = (0.0,) * len(robot.slots)
        self._states: tuple[str, ...] = ()
        self._unconfirmed: tuple[str, ...] = ()

    def lines(self, effect: fx.Effect) -> list[EffectLine]:
        """Return the lines about one effect; none where nothing has changed for a person."""
        if isinstance(effect, fx.StateChange):
            return self._state(effect)
        if isinstance(effect, fx.Setpoints):
            return self._setpoints(effect)
        said, place = fx.display_of(effect, nominal=self._nominal), getattr(effect, "place", "")
        if not said.text or isinstance(effect, fx.Ended):
            return []
        where = f" ({place})" if place and said.level == "warning" else ""
        return [EffectLine(said.about, f"{said.text}{where}")]

    def _state(self, it: fx.StateChange) -> list[EffectLine]:
        before = self._states or it.states
        first = not self._states
        changes = []
        for index, (old, new) in enumerate(zip(before, it.states, strict=True)):
            region, label = self._robot.regions[index], self._labels[index]
            doubtful = region in it.unconfirmed
            mark = " (unconfirmed)" if doubtful else ""
            if old != new:
                changes.append(f"{label} {old} → {new}{mark}")
            elif first:
                changes.append(f"{label} {new}{mark}")
            elif doubtful != (region in self._unconfirmed):
                changes.append(f"{label} {new} {'unconfirmed' if doubtful else 'confirmed'}")
        self._states, self._unconfirmed = it.states, it.unconfirmed
        return [EffectLine("state", ", ".join(changes))] if changes else []

    def _setpoints(self, it: fx.Setpoints) -> list[EffectLine]:
        if not self._with_setpoints:
            return []
        changes = changed_setpoints(self._robot.slots, self._values, it.values)
        self._values = it.values
        return [EffectLine("setpoints", f"#{it.setpoint_id} {', '.join(changes) or 'unchanged'}")]


def changed_setpoints(
    slots: tuple[SlotSpec, ...], before: tuple[float, ...], values: tuple[float, ...]
) -> list[str]:
    """Return the slots whose setpoint is new, by name and with its unit."""
    return [
        f"{slot.name} {setpoint(slot, new)}"
        for slot, old, new in zip(slots, before, values, strict=True)
        if old != new
    ]


def setpoint(slot: SlotSpec, value: float) -> str:
    """Return a setpoint as people read it: duty cycle in per cent, angle in degrees."""
    if isnan(value):  # kept, and not measured yet
        return "–"
    return f"{degrees(value):z.1f}°" if slot.unit == "angle" else f"{value * 100:.3g} %"


def summary(
    ended: fx.Ended,
    now_s: float,
    distance_m: float | None,
    odometry_m: float | None,
    bound_m: float | None,
) -> str:
    """Return how a run ended, in one line."""
    ways = []
    if distance_m is not None:
        ways.append(f"moved {distance_m:z.2f} m")
    if odometry_m is not None and bound_m is not None:
        ways.append(f"odometer {odometry_m * 1000:z.0f} ± {ceil(bound_m * 1000)} mm")
    elif odometry_m is not None:
        ways.append(f"odometer {odometry_m:z.2f} m")
    way = f" ({', '.join(ways)})" if ways else ""
    # The message says by what a run was interrupted.
    outcome = "stopped" if ended.outcome == "interrupted" else ended.outcome
    return f"{outcome} after {now_s:.1f} s{way}: {ended.message}"


UNCONFIRMED = "the robot has not confirmed that it stopped"


def away(link: LinkHealth, *, stopping: bool = False, moving: bool = False) -> str:
    """Return since when nothing is known of the robot, and what it may be doing; empty: nothing.

    Args:
        link: The state of the link.
        stopping: Whether a stop waits for it.
        moving: Whether a command was under way.
    """
    if not link.trouble:
        return ""
    waits = ""
    if stopping and link.patience_s:
        waits = f"; a stop waits for it, given up in {link.patience_s:.0f} s"
    said = f"no word for {link.silent_s:.1f} s; {_may_move(link, moving=moving)}"
    return f"{said}{waits} ({link.trouble})"


def _may_move(link: LinkHealth, *, moving: bool) -> str:
    """Return what may move while nothing is heard, and what the operator can do about it."""
    if link.stopped and not moving:
        return "its wheels stood when it was last heard"
    what = "a joint" if link.stopped else "wheels"
    if link.silent_s >= link.switch_stops_s:
        has = f"its dead man's switch has stopped the {'joints' if link.stopped else what}"
        return f"{has}, unless its controller hangs or is starting again: then cut power"
    turning = "moving" if link.stopped else "turning"
    if isfinite(link.switch_stops_s):
        left_s = link.switch_stops_s - link.silent_s
        return f"{what} may be {turning}, for {left_s:.1f} s until its dead man's switch stops it"
    return f"{what} may be {turning}: cut power"


def shortened(names: Sequence[str]) -> list[str]:
    """Return the names without the ending that all of them share."""
    endings = zip(*map(reversed, names), strict=False)
    shared = sum(1 for _ in takewhile(lambda letters: len(set(letters)) == 1, endings))
    return [name[: len(name) - shared] or name for name in names]
