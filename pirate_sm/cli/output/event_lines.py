"""A run as lines: one readable line per event, or JSON Lines for programs (``docs/output.md``)."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from math import isfinite, isnan
from typing import TYPE_CHECKING, Any, TextIO

from pirate_sm import __version__
from pirate_sm.cli.errors import say
from pirate_sm.cli.output.terminal import columns_of, wrapped
from pirate_sm.core import effects as fx
from pirate_sm.core.effects import Effect, Ended, Setpoints, Unmet
from pirate_sm.core.engine import EngineState, Evidence
from pirate_sm.core.events import ALPHABET_VERSION, Truth
from pirate_sm.core.models import SIMULATORS
from pirate_sm.core.options import USUAL
from pirate_sm.core.visible import visible
from pirate_sm.running.runtime.ending import StopRequests
from pirate_sm.running.runtime.scripted_events import Answered
from pirate_sm.running.wiring import Order, Prepared
from pirate_sm.views.showing.effect_lines import UNCONFIRMED, Teller, away, left_state, summary

if TYPE_CHECKING:
    from pirate_sm.robot.backends.serial.link.health import LinkHealth
    from pirate_sm.running.runtime.loop import MissionRun


# --- the run that is shown ----------------------------------------------------------------------


class ObservedRun:
    """The present state of a run; ``run`` is set once it exists."""

    def __init__(self, prepared: Prepared) -> None:
        self.prepared = prepared
        self.robot = prepared.loaded.robot
        self.run: MissionRun | None = None
        self._sent: tuple[float, ...] = ()
        self._driven_from_m: float | None = None
        self._ended: Ended | None = None

    @property
    def now_s(self) -> float:
        """Mission time, s."""
        return self.run.now_s if self.run else 0.0

    @property
    def state(self) -> EngineState | None:
        """The engine's state, None before it began."""
        return self.run.state if self.run else None

    def truth(self) -> Truth | None:
        """Return the robot's true position, if it is known."""
        return self.prepared.truth() if self.prepared.truth else None

    def note(self, effects: Sequence[Effect]) -> None:
        """Note what was sent last, and the end."""
        for effect in effects:
            if isinstance(effect, Setpoints):
                self._sent = effect.values
                if self._driven_from_m is None and self.robot.travel(effect.values):
                    truth = self.truth()
                    self._driven_from_m = truth.distance_m if truth else None
            elif isinstance(effect, Ended):
                self._ended = effect

    def left(self) -> str:
        """Return in what state a run that did not succeed left the robot; empty otherwise."""
        ended, state, link = self._ended, self.state, self.prepared.link
        if ended is None or ended.outcome == "succeeded" or state is None:
            return ""
        return left_state(self.prepared.engine, state, self._sent, link() if link else None)

    def odometry_m(self) -> float | None:
        """Return the distance that the wheels have rolled, m, if it is measured."""
        return self._measured(self.robot.odometry)

    def bound_m(self) -> float | None:
        """Return how far the robot may be from that distance, m, if the mission reads it."""
        return None if self.odometry_m() is None else self._measured(self.robot.bound)

    def _measured(self, index: int) -> float | None:
        if self.state is None or index < 0 or self.prepared.engine.nominal:
            return None
        value = self.state.sensing.numbers[index]
        return None if isnan(value) else value

    def distance_m(self) -> float | None:
        """Return how far the robot has truly moved since it first drove, m, if it is known.

        Odometry counts from there too. Before, clamping moves the middle of the wheels by some
        20 mm, because a robot that folds is shorter.
        """
        truth = self.truth()
        return truth.distance_m - (self._driven_from_m or 0.0) if truth else None

    def summary(self, ended: Ended, now_s: float) -> str:
        """Return how the run ended and how far the robot moved, in one line."""
        return summary(ended, now_s, self.distance_m(), self.odometry_m(), self.bound_m())


# --- for people ---------------------------------------------------------------------------------


_INDENT = 22
"""Where the text of a line begins, after its time and its topic."""


class EventLines:
    """Writes a line for each event; if quiet, only how it ended and left the robot."""

    def __init__(self, out: TextIO, observed: ObservedRun, *, quiet: bool = False) -> None:
        self._out = out
        self._observed = observed
        self._quiet = quiet
        nominal = observed.prepared.engine.nominal
        self._teller = Teller(observed.robot, with_setpoints=nominal, nominal=nominal)

    def begin(self) -> None:
        """Write what is about to run."""
        if not self._quiet:
            for notice in headline(self._observed), *self._observed.prepared.notices:
                self._write(0.0, "run", notice)
            self._out.flush()

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """Write the latest effects, and flush them."""
        self._observed.note(effects)
        for effect in effects:
            if isinstance(effect, Ended):
                there = self._observed
                text = there.summary(effect, now_s)
                left = there.left()
                if self._quiet:
                    mission = there.prepared.loaded.mission.mission
                    for said in filter(None, (text, left)):
                        self._out.write(f"{mission}: {visible(said)}\n")
                else:
                    self._write(now_s, "end", text)
                    if left:
                        self._write(now_s, "robot", left)
            elif self._quiet:
                if isinstance(effect, Answered) and effect.level == "warning":
                    say(f"warning: {effect.message}")
            else:
                for topic, text in self._teller.lines(effect):
                    self._write(now_s, topic, text)
        self._out.flush()

    def _write(self, now_s: float, topic: str, text: str) -> None:
        line = f"{now_s:9.3f}  {topic:<9}  {visible(text)}"
        self._out.write(f"{wrapped(line, columns_of(self._out), _INDENT)}\n")


class SaysWhyItWaits:
    """Prints on standard error why a stop has to wait, for a run without a view."""

    def __init__(self, link: Callable[[], LinkHealth], requests: StopRequests) -> None:
        self._link = link
        self._requests = requests
        self._explained = False

    def pulse(self, now_s: float) -> None:
        """Print once that a stop waits for the link."""
        stop = self._requests.stop
        if stop is not None and not self._explained and (why := away(self._link(), stopping=True)):
            self._explained = True
            say(f"{stop.reason}: {why}; a second signal ends it immediately")

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """Print that the port stays open because the robot has not confirmed its stop."""
        if any(isinstance(each, Ended) for each in effects) and not self._link().stopped:
            say(f"{UNCONFIRMED}: waiting for it before the port is closed")


def headline(observed: ObservedRun) -> str:
    """Return mission, robot, pipe and backend in one line."""
    order, loaded = observed.prepared.order, observed.prepared.loaded
    pipe = f" in {loaded.pipe_name}" if loaded.pipe_name else ""
    return f"{loaded.mission.mission} on {loaded.robot.name}{pipe}, {how_it_runs(order)}"


def how_it_runs(order: Order) -> str:
    """Return the backend and its particular options."""
    fidelity = "" if order.fidelity == USUAL else f", {order.fidelity}"
    ways = dict.fromkeys(SIMULATORS, f"seed {order.seed}{fidelity}") | {"serial": str(order.port)}
    how = ways.get(order.backend, "ideal")
    defects = f", defects: {', '.join(order.defects)}" if order.defects else ""
    return f"{order.backend} ({how}{defects})"


# --- for programs -------------------------------------------------------------------------------


FORMAT = 1
"""Changes when a reader of the lines would have to."""

_DIGITS = 6


class JsonLines:
    """Writes each effect as one line; they are flushed together as they happen."""

    def __init__(self, out: TextIO, observed: ObservedRun) -> None:
        self._out = out
        self._observed = observed
        self._regions = observed.robot.regions
        self._answered = False

    def begin(self) -> None:
        """Write what is about to run as the first line."""
        order, loaded = self._observed.prepared.order, self._observed.prepared.loaded
        self._write(
            0.0,
            "start",
            {
                "format": FORMAT,
                "alphabet": ALPHABET_VERSION,
                "version": __version__,
                "mission": loaded.mission.mission,
                "robot": loaded.robot.name,
                "polarity": loaded.robot.polarity,
                "pipe": loaded.pipe_name or None,
                "backend": order.backend,
                "detector": self._observed.prepared.detector,
                "ideal": self._observed.prepared.engine.nominal,
                "seed": order.seed,
                "defects": list(order.defects),
                "parameters": dict(loaded.parameters),
                "from": order.start_phase,
                "slots": [{"name": s.name, "unit": s.unit} for s in loaded.robot.slots],
                "files": dict(loaded.files),
            },
        )
        for notice in self._observed.prepared.notices:
            self._write(0.0, "log", {"level": "info", "message": notice})
        self._out.flush()

    def see(self, effects: Sequence[fx.Effect], now_s: float) -> None:
        """Write a line for each effect, and flush them."""
        for effect in effects:
            line = self._object(effect)
            if line is not None and not self._is_known(effect):
                self._write(now_s, *line)
        self._out.flush()

    def _is_known(self, effect: fx.Effect) -> bool:
        """Return whether a question is withdrawn only because it was just answered."""
        if isinstance(effect, fx.Ask):
            known, self._answered = self._answered and not effect.question, False
            return known
        self._answered = self._answered or isinstance(effect, Answered)
        return False

    def _write(self, now_s: float, kind: str, rest: dict[str, Any]) -> None:
        line = {"t": _plain(now_s), "type": kind, **rest}
        text = json.dumps(line, ensure_ascii=False, allow_nan=False)
        if not text.isprintable():  # it may be shown on a terminal, where that would hide the rest
            text = json.dumps(line, allow_nan=False)
        self._out.write(f"{text}\n")

    def _object(self, effect: fx.Effect) -> tuple[str, dict[str, Any]] | None:
        """Return the type of an effect's line and what it says; None where there is no line."""
        display = fx.display_of(effect, nominal=self._observed.prepared.engine.nominal)
        said = effect._asdict() if display.fields is None else {**display.fields}
        if isinstance(effect, fx.Ended):
            there = self._observed
            said |= {
                "sim_time_s": there.now_s,
                "distance_m": there.distance_m(),
                "odometry_m": there.odometry_m(),
                "bound_m": there.bound_m(),
            }
        elif isinstance(effect, fx.StateChange):
            named = dict(zip(self._regions, effect.states, strict=True))
            said = {"state": named, "unconfirmed": effect.unconfirmed} | self._evidence()
        return (display.kind, _plain(said)) if display.kind else None

    def _evidence(self) -> dict[str, Any]:
        """Return what has shown each state and clamp; empty without sensors."""
        state, names = self._observed.state, (*self._regions, *self._observed.robot.parts)
        shown = dict(zip(names, state.proofs if state else (), strict=False))
        return {"evidence": shown} if shown else {}


def _plain(value: Any) -> Any:
    """Return a value for JSON: numbers to six digits, None for NaN and infinity."""
    if isinstance(value, float):
        return round(value, _DIGITS) if isfinite(value) else None
    if isinstance(value, Unmet | Evidence):
        value = value._asdict()
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    return list(map(_plain, value)) if isinstance(value, tuple | list) else value
