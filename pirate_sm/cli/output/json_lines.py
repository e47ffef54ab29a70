"""JSON Lines: an interface for programs, described in ``docs/output.md``."""

from __future__ import annotations

import json
from collections.abc import Sequence
from math import isfinite
from typing import Any, TextIO, assert_never

from pirate_sm import __version__
from pirate_sm.cli.output.observed_run import ObservedRun
from pirate_sm.model import effects as fx
from pirate_sm.model.effect_words import question_words, trigger_reason
from pirate_sm.model.events import ALPHABET_VERSION
from pirate_sm.model.unmet import Unmet
from pirate_sm.runtime.first_choice import Answered

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
        line = {"t": _number(now_s), "type": kind, **rest}
        text = json.dumps(line, ensure_ascii=False, allow_nan=False)
        if not text.isprintable():  # it may be shown on a terminal, where that would hide the rest
            text = json.dumps(line, allow_nan=False)
        self._out.write(f"{text}\n")

    def _object(self, effect: fx.Effect) -> tuple[str, dict[str, Any]] | None:
        """Return the type of an effect's line and what it says; None where there is no line."""
        match effect:
            case fx.Ended(outcome, message, end):
                there = self._observed
                return "end", {
                    "outcome": outcome,
                    "end": end or None,
                    "message": message,
                    "sim_time_s": _number(there.now_s),
                    "distance_m": _number(there.distance_m()),
                    "odometry_m": _number(there.odometry_m()),
                    "bound_m": _number(there.bound_m()),
                }
            case fx.StateChange(states, unconfirmed):
                named = dict(zip(self._regions, states, strict=True))
                said = {"state": named, "unconfirmed": list(unconfirmed)}
                return "state", said | self._evidence()
            case fx.TriggerFired():
                nominal = self._observed.prepared.engine.nominal
                reason = trigger_reason(effect, nominal=nominal)
                return "trigger", {**effect._asdict(), "reason": reason}
            case fx.Ask(question):
                message = question_words(effect) if question else "the question is withdrawn"
                return "log", {"level": "info", "message": message}
            case _:
                return _object(effect)

    def _evidence(self) -> dict[str, Any]:
        """Return what has shown each state and clamp; empty without sensors."""
        state, names = self._observed.state, (*self._regions, *self._observed.robot.parts)
        found = zip(names, state.proofs if state else (), strict=False)
        shown = {name: {**it._asdict(), "at_s": _number(it.at_s)} for name, it in found}
        return {"evidence": shown} if shown else {}


def _number(value: float | None) -> float | None:
    """Return the number to six digits; None for NaN and infinity, which JSON does not know."""
    return round(value, _DIGITS) if value is not None and isfinite(value) else None


def _command(effect: fx.CommandStatus) -> dict[str, Any]:
    """Return what a command's line says; only that of a failed one has ``unmet``."""
    said = {**effect._asdict(), "place": effect.place or None}
    del said["unmet"]
    if effect.status == "failed":
        said["unmet"] = [_unmet(each) for each in effect.unmet]
    return said


def _unmet(it: Unmet) -> dict[str, Any]:
    return {
        name: _number(value) if isinstance(value, float) else value
        for name, value in it._asdict().items()
    }


def _object(effect: fx.Effect) -> tuple[str, dict[str, Any]] | None:
    """Return the type of an effect's line and what it says, where that is in the effect alone."""
    match effect:
        case fx.Setpoints(setpoint_id, values):
            return "setpoints", {"id": setpoint_id, "values": [_number(each) for each in values]}
        case fx.CommandStatus():
            return "command", _command(effect)
        case fx.PhaseChange(phase):
            return "phase", {"phase": phase, "status": "entered"}
        case fx.WaitArmed(phase, triggers, conditions, deadline_s):
            waits = zip(triggers, conditions, strict=True)
            return "phase", {
                "phase": phase,
                "status": "waiting",
                "triggers": [{"trigger": name, "condition": text} for name, text in waits],
                "deadline_s": _number(deadline_s),
            }
        case fx.Environment():
            found = effect._asdict().items()
            said = {name: it if isinstance(it, str) else _number(it) for name, it in found}
            return "environment", said
        case fx.Detected():
            return "detected", effect._asdict()
        case fx.Fault():
            return "fault", effect._asdict()
        case fx.Log():
            return "log", effect._asdict()
        case fx.Ask() | fx.WakeAt() | fx.Ended() | fx.StateChange() | fx.TriggerFired():
            return None
    assert_never(effect)
