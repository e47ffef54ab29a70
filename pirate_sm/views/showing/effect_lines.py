"""Lines to read: effects, and in what state a run has left the robot."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import takewhile
from math import ceil, degrees, isfinite, isnan
from typing import TYPE_CHECKING, NamedTuple

from pirate_sm.core import effects as fx
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.robot import (
    DECLARED,
    Mark,
    RobotSpec,
    SlotSpec,
    at_rest_in,
    confirmed_parts,
    verdict,
)

if TYPE_CHECKING:
    from pirate_sm.robot.backends.serial.link.health import LinkHealth


# --- effects ------------------------------------------------------------------------------------


class EffectLine(NamedTuple):
    """One line: what it is about in a word, and what is said about it."""

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
        """Return the lines about one effect; none where nothing has changed for an operator."""
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


# --- the robot that is left ---------------------------------------------------------------------


def left_state(
    engine: Engine, state: EngineState | None, sent: tuple[float, ...], link: LinkHealth | None
) -> str:
    """Return in what state a run has left the robot: its wheels and what holds it.

    Args:
        engine: The engine of the run.
        state: The engine's state at the end; None if it has not begun.
        sent: The last array that was sent; empty if none was.
        link: How the link is; None where there is none.
    """
    robot = engine.robot
    if not sent:
        return "nothing was sent: the robot is as it was"
    if state is None:
        return "what holds the robot is not known"
    accepted = state.robot.flight is None and state.robot.values == sent
    if link is not None:  # it also knows what became of an array sent past the engine
        accepted = link.stopped and (accepted or not state.mission.ended)
    stopped = not any(sent[slot] for slot in robot.safe_zero)
    wheels = "wheels set to zero" if stopped else "the wheels may TURN: no safe array was sent"
    if not accepted:
        wheels = f"{wheels}, NOT confirmed by the robot"
    held = [
        f"{robot.parts[part]} clamped ({_by_what(engine, state, part)})"
        for part in sorted(robot.held[state.robot.configuration])
    ]
    return "; ".join([wheels, *(held or ["no part is clamped"])])


def _by_what(engine: Engine, state: EngineState, part: int) -> str:
    """Return what shows that a part is clamped, at the end and not only when it was clamped."""
    if engine.nominal:
        return "without sensors"
    robot, body = engine.robot, state.robot
    rest, mark = at_rest_in(robot, body.configuration).values, Mark("part", part, DECLARED)
    seen = verdict(robot, rest, body, mark, state.sensing.numbers, engine.program.diameter_m)
    if seen.agrees and part in confirmed_parts(robot, body):
        return "confirmed by sensors"
    proof = engine.evidence(state)[robot.parts[part]]
    if proof.source != "sensor":
        return "NOT confirmed by sensors"
    now_s = max(state.sensing.checked_s, proof.at_s)  # an answer may have come after all frames
    return f"{proof.in_words(now_s)}, NOT seen by them now"
