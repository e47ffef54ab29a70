"""JSON Lines: an interface for programs, described in ``docs/output.md``."""

from __future__ import annotations

import json
from collections.abc import Sequence
from math import isfinite
from typing import Any, TextIO

from pirate_sm import __version__
from pirate_sm.cli.situation import Situation
from pirate_sm.model import effects as fx
from pirate_sm.model.events import ALPHABET_VERSION
from pirate_sm.runtime.companions import Answered
from pirate_sm.showing.telling import told_reason

FORMAT = 1
"""Changes when a reader of the lines would have to."""

_DIGITS = 6

_WITHDRAWN = "the question is withdrawn"


class JsonLines:
    """Writes each effect as one line; they are flushed together as they happen."""

    def __init__(self, out: TextIO, situation: Situation) -> None:
        self._out = out
        self._situation = situation
        self._regions = situation.robot.regions
        self._answered = False

    def begin(self) -> None:
        """The first line says what is about to run."""
        order, loaded = self._situation.prepared.order, self._situation.prepared.loaded
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
                "detector": self._situation.prepared.detector,
                "ideal": self._situation.prepared.engine.nominal,
                "seed": order.seed,
                "defects": list(order.defects),
                "parameters": dict(loaded.parameters),
                "from": order.start_phase,
                "slots": [{"name": s.name, "unit": s.unit} for s in loaded.robot.slots],
                "files": dict(loaded.files),
            },
        )
        for notice in self._situation.prepared.notices:
            self._write(0.0, "log", {"level": "info", "message": notice})
        self._out.flush()

    def see(self, effects: Sequence[fx.Effect], now_s: float) -> None:
        """A line for each effect has been handed to whoever reads."""
        for effect in effects:
            kind, rest = self._line(effect)
            if kind and not self._is_known(effect):
                self._write(now_s, kind, rest)
        self._out.flush()

    def _is_known(self, effect: fx.Effect) -> bool:
        """Whether a question only goes away because of the answer that was just told."""
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

    def _line(self, effect: fx.Effect) -> tuple[str, dict[str, Any]]:  # noqa: C901 - one case each
        """Return the type of an effect's line, empty where it has none, and what stands in it."""
        match effect:
            case fx.Setpoints(setpoint_id, values):
                return "setpoints", {"id": setpoint_id, "values": [_number(v) for v in values]}
            case fx.CommandStatus():
                return "command", {**effect._asdict(), "place": effect.place or None}
            case fx.StateChange(states, unconfirmed):
                named = dict(zip(self._regions, states, strict=True))
                return "state", {"state": named, "unconfirmed": list(unconfirmed)}
            case fx.PhaseChange(phase):
                return "phase", {"phase": phase, "status": "entered"}
            case fx.WaitArmed():
                return "phase", _waiting(effect)
            case fx.TriggerFired():
                nominal = self._situation.prepared.engine.nominal
                reason = told_reason(effect, nominal=nominal)
                return "trigger", {**effect._asdict(), "reason": reason}
            case fx.Detected(word):
                return "detected", {"word": word}
            case fx.Environment(segment):
                measures = {name: _number(getattr(effect, name)) for name in effect._fields[1:]}
                return "environment", {"segment": segment, **measures}
            case fx.Fault():
                return "fault", effect._asdict()
            case fx.Log(level, message):
                return "log", {"level": level, "message": message}
            case fx.Ask(question, choices):
                asked = f"{question} ({' / '.join(choices)})" if question else _WITHDRAWN
                return "log", {"level": "info", "message": asked}
            case fx.Ended():
                return "end", self._end(effect)
            case fx.WakeAt():
                return "", {}

    def _end(self, it: fx.Ended) -> dict[str, Any]:
        there = self._situation
        return {
            "outcome": it.outcome,
            "end": it.end or None,
            "message": it.message,
            "sim_time_s": _number(there.now_s),
            "distance_m": _number(there.distance_m()),
            "odometry_m": _number(there.odometry_m()),
        }


def _number(value: float | None) -> float | None:
    """JSON knows no NaN and no infinity; six digits are below any wire's resolution."""
    return round(value, _DIGITS) if value is not None and isfinite(value) else None


def _waiting(it: fx.WaitArmed) -> dict[str, Any]:
    triggers = zip(it.triggers, it.conditions, strict=True)
    return {
        "phase": it.phase,
        "status": "waiting",
        "triggers": [{"trigger": name, "condition": text} for name, text in triggers],
        "deadline_s": _number(it.deadline_s),
    }
