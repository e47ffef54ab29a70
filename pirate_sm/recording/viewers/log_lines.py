"""Effects as lines of a ``foxglove.Log``."""

from __future__ import annotations

from typing import Literal, NamedTuple

from pirate_sm.model import effects as fx
from pirate_sm.model.effect_words import (
    command_words,
    fault_words,
    question_words,
    with_reason,
)

Level = Literal["info", "warning", "error"]

LEVELS: dict[Level, int] = {"info": 2, "warning": 3, "error": 4}
"""Level numbers of ``foxglove.Log``."""


class LogLine(NamedTuple):
    """A line; ``file`` and ``line`` are its place in the mission, empty and 0 without one."""

    level: Level
    text: str
    file: str = ""
    line: int = 0


def log_line(effect: fx.Effect) -> LogLine | None:  # noqa: C901 - one case each
    """Return the log line of an effect; None if it has none."""
    level: Level
    match effect:
        case fx.Log():
            return LogLine(effect.level, effect.message)
        case fx.CommandStatus(status=status, place=place):
            level = "warning" if status in ("refused", "failed") else "info"
            return LogLine(level, command_words(effect), *_place(place))
        case fx.PhaseChange(phase):
            return LogLine("info", f"phase {phase}")
        case fx.WaitArmed(phase, triggers):
            return LogLine("info", f"{phase} waits for {', '.join(triggers) or 'its time limit'}")
        case fx.TriggerFired(_, trigger, go, reason):
            return LogLine("info", with_reason(f"{trigger}: on to {go}", reason))
        case fx.Detected(word):
            return LogLine("info", f"detected {word}")
        case fx.Fault(handling=handling):
            return LogLine("error" if handling == "stop" else "warning", fault_words(effect))
        case fx.Ask(question=question) if question:
            return LogLine("info", question_words(effect))
        case fx.Ended(outcome, message):
            level = "info" if outcome == "succeeded" else "error"
            return LogLine(level, with_reason(outcome, message))
        case fx.Setpoints() | fx.StateChange() | fx.Environment() | fx.Ask() | fx.WakeAt():
            return None


def _place(place: str) -> tuple[str, int]:
    """Return file and line of ``file:line:col``."""
    file, _, rest = place.rpartition(":")[0].rpartition(":")
    return (file, int(rest)) if rest.isdigit() else ("", 0)
