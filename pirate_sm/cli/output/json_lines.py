"""JSON Lines: an interface for programs, described in ``docs/output.md``."""

from __future__ import annotations

import json
from collections.abc import Sequence
from math import isfinite
from typing import Any, TextIO

from pirate_sm import __version__
from pirate_sm.cli.output.observed_run import ObservedRun
from pirate_sm.core import effects as fx
from pirate_sm.core.effects import Unmet
from pirate_sm.core.engine import Evidence
from pirate_sm.core.events import ALPHABET_VERSION
from pirate_sm.running.runtime.scripted_events import Answered

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
        """Whether a question is withdrawn only because of the answer that was just written."""
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
