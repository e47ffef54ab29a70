"""The engine's alphabet is closed: every event and effect is frozen, comparable and known."""

from __future__ import annotations

import inspect
import typing

import pytest

from pirate_sm.core import effects
from pirate_sm.core._model import events

MEASURED = ("segment", "roll_rad", "pitch_rad", "diameter_m")

BESIDES = {events.FrameBlock, events.Rows, effects.Display, effects.LaneMark, effects.LaneSpan}
"""Classes beside the alphabet: many frames at once, and what views show of an effect."""

AHEAD = ("joint", "junction", "opening_roll_rad", "distance_m", "diameter_ahead_m", "run", "arc_m")
"""What both environment reports have of the joint ahead, and of the place on the route."""


def classes(module) -> set[type]:
    return {
        value
        for value in vars(module).values()
        if inspect.isclass(value) and value.__module__ == module.__name__
    } - BESIDES


@pytest.mark.parametrize(("module", "union"), [(events, events.Event), (effects, effects.Effect)])
def test_the_union_names_every_class_of_its_module(module, union):
    assert set(typing.get_args(union)) == classes(module)


@pytest.mark.parametrize("kind", sorted(classes(events) | classes(effects), key=str))
def test_each_is_frozen_and_says_what_it_is(kind):
    assert issubclass(kind, tuple), "immutable, compared by value"
    assert kind.__doc__
    for name in kind._fields:
        assert getattr(kind, name) is not None


def test_the_alphabet_is_what_its_version_says():
    # Who changes a line here changes ALPHABET_VERSION too: recordings tell them apart by it.
    letters = {kind.__name__: kind._fields for kind in classes(events) | classes(effects)}

    assert events.ALPHABET_VERSION == 12
    assert letters == {
        "Abort": ("reason",),
        "Answer": ("choice",),
        "Ask": ("question", "choices"),
        "Breakpoints": ("at", "by"),
        "CommandFailed": ("reason",),
        "CommandStatus": ("name", "status", "reason", "place", "unmet"),
        "Detected": ("word",),
        "DetectorWord": ("word", "valid_for_s", "by"),
        "Ended": ("outcome", "message", "end"),
        "Environment": (*MEASURED, *AHEAD),
        "EnvironmentReport": (
            "segment",
            "roll_rad",
            "pitch_rad",
            "diameter_m",
            "valid_for_s",
            *AHEAD,
        ),
        "Fault": ("code", "message", "handling", "of"),
        "FaultReport": ("code", "message", "away_s", "of"),
        "GoTo": ("phase", "states", "unconfirmed", "by", "until"),
        "Log": ("level", "message"),
        "OperatorCommand": ("command", "share", "at_once"),
        "Observation": ("text", "place_m"),
        "OutsideNumber": ("signal", "value", "age_s"),
        "Pause": ("by",),
        "PhaseChange": ("phase",),
        "Resume": ("by", "until"),
        "SensorFrame": ("board", "values"),
        "Setpoints": ("setpoint_id", "values"),
        "SignalReport": ("numbers", "words"),
        "Skip": ("trigger",),
        "StateChange": ("states", "unconfirmed"),
        "Step": ("by",),
        "SubmitResult": ("setpoint_id", "status", "reason"),
        "Tick": (),
        "TriggerFired": ("phase", "trigger", "go", "reason", "place"),
        "WaitArmed": ("phase", "triggers", "conditions", "deadline_s", "place"),
        "WakeAt": ("at_s",),
    }
