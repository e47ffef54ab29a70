"""Describe an event sequence, with one sentence for each event."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from math import isnan
from typing import TypeAlias

from pirate_sm.checking.exploring.exploration import Exploration, ExploredStep
from pirate_sm.core.effects import CommandStatus, Effect, Ended, Fault, PhaseChange, TriggerFired
from pirate_sm.core.expressions import Vocabulary
from pirate_sm.core.units import format_quantity

Written: TypeAlias = Callable[[str, str], str]
"""Returns the name of a command as written in the step at a place, ``file:line:col``."""


def _as_it_is(place: str, command: str) -> str:
    return command


def story(found: Exploration, step: int, written: Written = _as_it_is) -> tuple[str, ...]:
    """Return the story of a step: one sentence for each event that leads to it."""
    return tuple(sentence(found, each, written) for each in found.path(step))


def sentence(found: Exploration, step: ExploredStep, written: Written = _as_it_is) -> str:
    """Return the event of a step and its consequences."""
    said = [_what(found, step, written), *_consequences(step.effects, written)]
    shown = _shown(
        found.robot.vocabulary.with_changes, step.moment.answer.numbers, step.moment.answer.words
    )
    if shown and not any(isinstance(each, TriggerFired) for each in step.effects):
        said[0] += f" (with {shown})"
    return "; ".join(part for part in said if part)


def _what(found: Exploration, step: ExploredStep, written: Written) -> str:
    """Return the event itself as a sentence."""
    state = found.nodes[step.source].state if step.source >= 0 else None
    motion = state.robot.motion if state else None
    name = written(motion.place, found.robot.commands[motion.command].name) if motion else ""
    place = f" ({motion.place})" if motion and motion.place else ""
    flight = state.robot.flight if state else None
    match step.move.kind:
        case "accepted":
            if flight is not None and flight.purpose == "gate":
                return f"{name}{place} is accepted"
            stops = flight is not None and flight.purpose == "stop"
            return "the wheels are stopped" if stops else "the setpoints are accepted"
        case "rejected":
            return f"the setpoints of {name}{place} are refused by the robot"
        case "failed":
            failed = f"{name}{place} is not done in time"
            return failed if name else "the torques are not borne in time"
        case "fault":
            of = ", ".join(getattr(step.move.event, "of", ()))
            return f"the fault {step.move.word}{of and f' of {of}'} comes up"
        case "answer":
            return f"the operator says '{step.move.word}'"
        case "time":
            return f"{name} is done" if name else "time passes"
        case other:
            return _ALWAYS[other]


_ALWAYS: Mapping[str, str] = {
    "start": "the mission begins",
    "sensors": "",
    "lasting": "sensors show now this and now that",
}


def _consequences(effects: Iterable[Effect], written: Written) -> Iterable[str]:
    for effect in effects:
        match effect:
            case TriggerFired():
                yield f"{effect.phase}: {effect.reason}, so {effect.go}"
            case PhaseChange():
                yield f"{effect.phase} begins"
            case CommandStatus(status="refused"):
                name = written(effect.place, effect.name)
                yield f"{name} ({effect.place}) is refused as {effect.reason}"
            case CommandStatus(status="skipped"):
                name = written(effect.place, effect.name)
                yield f"{name} ({effect.place}) is skipped, {effect.reason}"
            case Fault():
                yield effect.message
            case Ended():
                yield f"the mission has ended: {effect.message}"
            case _:
                pass


def _shown(
    vocabulary: Vocabulary, numbers: Mapping[str, float], words: Mapping[str, str | None]
) -> str:
    """Return the signals that the event requires, as text."""
    parts = [f"{name} = {_quantity(vocabulary, name, value)}" for name, value in numbers.items()]
    parts += [f"{name} = {word or 'unknown'}" for name, word in words.items()]
    return ", ".join(parts)


def _quantity(vocabulary: Vocabulary, name: str, value: float) -> str:
    shown = float(f"{value:.4g}")
    return "unknown" if isnan(value) else format_quantity(shown, vocabulary.dimension(name))
