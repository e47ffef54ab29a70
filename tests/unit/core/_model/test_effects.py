"""What views show of each effect."""

from __future__ import annotations

from typing import get_args

import pytest

from pirate_sm.core import effects as fx
from pirate_sm.core.effects import EFFECT_TABLES


@pytest.mark.parametrize(
    ("reason", "nominal", "text"),
    [
        (fx.TAKEN, True, "taken by the trace → next"),
        (fx.TAKEN, False, "taken by the operator → next"),
        ("force > 3 N", True, "force > 3 N → next"),
    ],
)
def test_in_a_trace_no_operator_takes_triggers(reason: str, nominal: bool, text: str) -> None:
    fired = fx.TriggerFired("wait", "go", "next", reason)

    assert fx.display_of(fired, nominal=nominal).text == text


@pytest.mark.parametrize(
    ("handling", "ending", "level"),
    [
        ("continue", "logged, the mission continues", "warning"),
        ("stop", "safe stop", "error"),
        ("rescue", "→ rescue", "warning"),
    ],
)
def test_a_fault_says_what_follows(handling: str, ending: str, level: str) -> None:
    display = fx.Fault("motion.stuck", "It does not move", handling).display()

    assert display.text == f"motion.stuck: It does not move ({ending})"
    assert display.level == level


def test_a_reason_follows_a_colon() -> None:
    assert fx.CommandStatus("Hold", "done").display().text == "Hold done"
    assert fx.CommandStatus("Hold", "failed", "late").display().text == "Hold failed: late"


def test_a_question_names_its_answers() -> None:
    assert fx.Ask("Go on?", ("yes", "no")).display().text == "Go on? (yes / no)"
    assert fx.Ask("", ()).display().text == ""


def test_each_effect_but_states_and_deadlines_has_a_table_of_its_own() -> None:
    without = {fx.StateChange, fx.WakeAt}

    assert EFFECT_TABLES.keys() == set(get_args(fx.Effect)) - without
    assert len(dict(EFFECT_TABLES.values())) == len(EFFECT_TABLES)
