"""What happens in a run, as lines of a log."""

from __future__ import annotations

from typing import Literal, NamedTuple

from pirate_sm.model import effects as fx

Level = Literal["info", "warning", "error"]

LEVELS: dict[Level, int] = {"info": 2, "warning": 3, "error": 4}
"""Numbers of ``foxglove.Log``."""


class Told(NamedTuple):
    """A line; ``file`` and ``line`` are its place in the mission, empty and 0 without one."""

    level: Level
    text: str
    file: str = ""
    line: int = 0


def told(effect: fx.Effect) -> Told | None:  # noqa: C901 - one case each
    """What there is to say about an effect; None where a log has no use for it."""
    match effect:
        case fx.Log():
            return Told(effect.level, effect.message)
        case fx.CommandStatus(name, status, reason, place):
            level: Level = "warning" if status in ("refused", "failed") else "info"
            return Told(level, _with(f"{name} {status}", reason), *_place(place))
        case fx.PhaseChange(phase):
            return Told("info", f"phase {phase}")
        case fx.WaitArmed(phase, triggers):
            return Told("info", f"{phase} waits for {', '.join(triggers) or 'its time limit'}")
        case fx.TriggerFired(_, trigger, go, reason):
            return Told("info", _with(f"{trigger}: on to {go}", reason))
        case fx.Detected(word):
            return Told("info", f"detected {word}")
        case fx.Fault(code, message, handling):
            return Told("error" if handling == "stop" else "warning", f"{code}: {message}")
        case fx.Ask(question, choices) if question:
            return Told("info", f"{question} ({' / '.join(choices)})")
        case fx.Ended(outcome, message):
            return Told("info" if outcome == "succeeded" else "error", _with(outcome, message))
        case fx.Setpoints() | fx.StateChange() | fx.Environment() | fx.Ask() | fx.WakeAt():
            return None


def _with(text: str, reason: str) -> str:
    return f"{text}: {reason}" if reason else text


def _place(place: str) -> tuple[str, int]:
    """File and line of ``file:line:col``."""
    file, _, rest = place.rpartition(":")[0].rpartition(":")
    return (file, int(rest)) if rest.isdigit() else ("", 0)
