"""One readable line per event."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, TextIO

from pirate_sm.cli.errors import say
from pirate_sm.cli.output.observed_run import ObservedRun
from pirate_sm.cli.output.terminal import columns_of, wrapped
from pirate_sm.core.effects import Effect, Ended
from pirate_sm.core.options import USUAL
from pirate_sm.core.simulation import SIMULATORS
from pirate_sm.core.visible import visible
from pirate_sm.running.runtime.ending import StopRequests
from pirate_sm.running.runtime.scripted_events import Answered
from pirate_sm.running.wiring import Order
from pirate_sm.views.showing.effect_lines import UNCONFIRMED, Teller, away, summary

if TYPE_CHECKING:
    from pirate_sm.robot.backends.serial.link.health import LinkHealth


_INDENT = 22
"""Where the text of a line begins, behind its time and its topic."""


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
                ways = there.distance_m(), there.odometry_m(), there.bound_m()
                text = summary(effect, now_s, *ways)
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
