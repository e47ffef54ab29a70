"""JSON Lines: an interface for programs, described in ``docs/output.md``."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from math import isfinite
from typing import Any, TextIO

from pirate_sm import __version__
from pirate_sm.cli.output.observed_run import ObservedRun
from pirate_sm.model import effects as fx
from pirate_sm.model.events import ALPHABET_VERSION
from pirate_sm.runtime.companions import Answered
from pirate_sm.showing.telling import told_reason

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
        """The first line says what is about to run."""
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
        """A line for each effect has been handed to whoever reads."""
        for effect in effects:
            make = _LINES.get(type(effect))
            if make is not None and not self._is_known(effect):
                self._write(now_s, *make(self, effect))
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

    def _state(self, it: fx.StateChange) -> tuple[str, dict[str, Any]]:
        states = dict(zip(self._regions, it.states, strict=True))
        return "state", {"state": states, "unconfirmed": list(it.unconfirmed)}

    def _end(self, it: fx.Ended) -> tuple[str, dict[str, Any]]:
        there = self._observed
        return "end", {
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


def _command(_: JsonLines, it: fx.CommandStatus) -> tuple[str, dict[str, Any]]:
    place = it.place or None
    return "command", {
        "name": it.name, "status": it.status, "reason": it.reason, "place": place,
    }  # fmt: skip


def _setpoints(_: JsonLines, it: fx.Setpoints) -> tuple[str, dict[str, Any]]:
    return "setpoints", {"id": it.setpoint_id, "values": [_number(v) for v in it.values]}


def _phase(_: JsonLines, it: fx.PhaseChange) -> tuple[str, dict[str, Any]]:
    return "phase", {"phase": it.phase, "status": "entered"}


def _wait(_: JsonLines, it: fx.WaitArmed) -> tuple[str, dict[str, Any]]:
    triggers = zip(it.triggers, it.conditions, strict=True)
    return "phase", {
        "phase": it.phase,
        "status": "waiting",
        "triggers": [{"trigger": name, "condition": text} for name, text in triggers],
        "deadline_s": _number(it.deadline_s),
    }


def _trigger(lines: JsonLines, it: fx.TriggerFired) -> tuple[str, dict[str, Any]]:
    nominal = lines._observed.prepared.engine.nominal
    return "trigger", {**it._asdict(), "reason": told_reason(it, nominal=nominal)}


def _detected(_: JsonLines, it: fx.Detected) -> tuple[str, dict[str, Any]]:
    return "detected", {"word": it.word}


def _environment(_: JsonLines, it: fx.Environment) -> tuple[str, dict[str, Any]]:
    return "environment", {
        "segment": it.segment,
        "roll_rad": _number(it.roll_rad),
        "pitch_rad": _number(it.pitch_rad),
        "diameter_m": _number(it.diameter_m),
    }


def _fault(_: JsonLines, it: fx.Fault) -> tuple[str, dict[str, Any]]:
    return "fault", it._asdict()


def _log(_: JsonLines, it: fx.Log) -> tuple[str, dict[str, Any]]:
    return "log", {"level": it.level, "message": it.message}


def _ask(_: JsonLines, it: fx.Ask) -> tuple[str, dict[str, Any]]:
    if not it.question:
        return "log", {"level": "info", "message": "the question is withdrawn"}
    return "log", {"level": "info", "message": f"{it.question} ({' / '.join(it.choices)})"}


_LINES: dict[type, Callable[[JsonLines, Any], tuple[str, dict[str, Any]]]] = {
    fx.Setpoints: _setpoints,
    fx.CommandStatus: _command,
    fx.StateChange: JsonLines._state,
    fx.PhaseChange: _phase,
    fx.WaitArmed: _wait,
    fx.TriggerFired: _trigger,
    fx.Detected: _detected,
    fx.Environment: _environment,
    fx.Fault: _fault,
    fx.Log: _log,
    Answered: _log,
    fx.Ask: _ask,
    fx.Ended: JsonLines._end,
}
