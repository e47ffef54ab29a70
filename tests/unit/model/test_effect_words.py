"""The words for effects that all views share."""

from __future__ import annotations

import pytest

from pirate_sm.model import effect_words as words
from pirate_sm.model import effects as fx
from pirate_sm.model.events import Answer, Tick


@pytest.mark.parametrize(
    ("reason", "nominal", "told"),
    [
        (fx.TAKEN, True, "taken by the trace"),
        (fx.TAKEN, False, "taken by the operator"),
        ("force > 3 N", True, "force > 3 N"),
    ],
)
def test_in_a_trace_no_operator_takes_triggers(reason: str, nominal: bool, told: str) -> None:
    fired = fx.TriggerFired("wait", "go", "next", reason)

    assert words.trigger_reason(fired, nominal=nominal) == told


@pytest.mark.parametrize(
    ("handling", "told"),
    [("continue", "the mission goes on"), ("stop", "safe stop"), ("rescue", "→ rescue")],
)
def test_what_follows_from_a_fault_is_told(handling: str, told: str) -> None:
    assert words.handling_words(fx.Fault("motion.stuck", "It does not move", handling)) == told


def test_a_reason_stands_behind_a_colon_where_there_is_one() -> None:
    assert words.command_words(fx.CommandStatus("Hold", "done")) == "Hold done"
    assert words.command_words(fx.CommandStatus("Hold", "failed", "late")) == "Hold failed: late"


def test_a_question_names_its_answers() -> None:
    assert words.question_words(fx.Ask("Go on?", ("yes", "no"))) == "Go on? (yes / no)"


def test_every_field_has_its_name_but_empty_texts_have_none() -> None:
    done = fx.StateChange(("Held", "Free"), ())

    assert words.field_words(done) == "state change: states (Held, Free), unconfirmed ()"
    assert words.field_words(fx.CommandStatus("Hold", "done")) == (
        "command status: name Hold, status done"
    )
    assert words.field_words(Answer("yes")) == "answer: choice yes"
    assert (words.field_words(None), words.field_words(Tick())) == (
        "the start",
        "the passing of time",
    )
