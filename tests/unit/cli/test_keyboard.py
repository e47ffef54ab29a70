from __future__ import annotations

from collections.abc import Sequence
from math import inf

import pytest

from pirate_sm.cli.people import AllKeys, Operator, SharedKeys
from pirate_sm.cli.stepper import Stepper
from pirate_sm.core.effects import Ask, TriggerFired, WaitArmed
from pirate_sm.core.events import Answer, Event, Resume, Step


class Keyboard:
    def __init__(self) -> None:
        self.keys = ""

    def pressed(self) -> str:
        keys, self.keys = self.keys, ""
        return keys


@pytest.fixture
def keyboard() -> Keyboard:
    return Keyboard()


@pytest.fixture
def told() -> list[str]:
    return []


@pytest.fixture
def operator(keyboard: Keyboard, told: list[str]) -> Operator:
    return Operator(keyboard, {"drive": ("stop", "turn")}, told.append)


def heard(operator: Operator, now_s: float) -> Sequence[Event]:
    """What it says when the loop asks it."""
    operator.look(None, now_s)
    return operator.speak(now_s)


WAIT = WaitArmed("drive", ("halt", "back"), ("operator", "operator"), 60.0)
OTHER = WaitArmed("rest", ("halt",), ("after",), 60.0)


@pytest.mark.parametrize(
    ("keys", "answer"), [("1", "yes"), ("2", "no"), ("\n", "yes"), ("x2", "no"), ("91", "yes")]
)
def test_a_key_answers_a_question(
    operator: Operator, keyboard: Keyboard, told: list[str], keys: str, answer: str
) -> None:
    operator.react((Ask("Go on?", ("yes", "no")),), 3.0)
    assert operator.listening
    assert operator.due_s == 3.0
    assert heard(operator, 3.0) == ()

    keyboard.keys = keys
    assert heard(operator, operator.due_s) == (Answer(answer),)
    assert not operator.listening
    assert operator.due_s == inf
    assert told == ["Go on?  [1] yes  [2] no"]


@pytest.mark.parametrize("keys", ["", "0", "3", "y", "²"])
def test_other_keys_do_not(operator: Operator, keyboard: Keyboard, keys: str) -> None:
    operator.react((Ask("Go on?", ("yes", "no")),), 0.0)
    keyboard.keys = keys

    assert heard(operator, 0.0) == ()
    assert operator.listening


def test_what_was_typed_before_a_question_does_not_answer_it(
    operator: Operator, keyboard: Keyboard
) -> None:
    keyboard.keys = "1"
    operator.react((Ask("Go on?", ("yes", "no")),), 0.0)

    assert heard(operator, 0.0) == ()


def test_a_withdrawn_question_is_forgotten(operator: Operator, keyboard: Keyboard) -> None:
    operator.react((Ask("Go on?", ("yes",)), Ask("", ())), 0.0)

    assert not operator.listening
    assert operator.due_s == inf


def test_the_operators_triggers_are_on_offer_while_their_wait_lasts(
    operator: Operator, keyboard: Keyboard
) -> None:
    operator.react((WAIT,), 0.0)
    keyboard.keys = "\n"
    assert heard(operator, 0.0) == ()  # a trigger has no expected answer
    keyboard.keys = "2"
    assert heard(operator, 0.1) == (Answer("turn"),)

    operator.react((WAIT,), 1.0)
    operator.react((TriggerFired("drive", "halt", "next", ""), OTHER), 2.0)
    assert not operator.listening


def test_an_answer_is_kept_with_who_gave_it(operator: Operator, keyboard: Keyboard) -> None:
    operator.react((Ask("Go on?", ("yes", "no")),), 0.0)
    keyboard.keys = "2"

    told = operator.look(None, 0.0)

    assert [line.message for line in told] == ["answered 'no' (operator)"]


def test_several_sources_are_one_keyboard() -> None:
    keyboard, panel = Keyboard(), Keyboard()
    both = AllKeys([panel, keyboard])
    keyboard.keys, panel.keys = "1", "2"
    assert both.pressed() == "21"
    assert both.pressed() == ""


class _Mission:
    """A run whose mission is paused, or not."""

    def __init__(self) -> None:
        self.paused, self.ending = False, None

    @property
    def mission(self) -> _Mission:
        return self


@pytest.mark.parametrize(
    ("keys", "says"),
    [("r", Resume()), ("R", Resume()), (".", Step()), ("1\n", None), ("xr.", Resume()), ("", None)],
)
def test_keys_resume_a_paused_mission(keyboard: Keyboard, keys: str, says: Event | None) -> None:
    run = _Mission()
    stepper = Stepper(keyboard)
    stepper.follow(None, lambda: run)  # type: ignore[arg-type,return-value]
    stepper.react((), 1.0)
    assert (stepper.due_s, stepper.listening) == (inf, False)

    run.paused, keyboard.keys = True, "r"
    stepper.react((), 2.0)
    assert (stepper.due_s, stepper.listening) == (2.0, True)
    (line,) = stepper.look(run, 2.0)  # type: ignore[arg-type]
    assert "Ctrl-C" in line.message
    assert stepper.speak(2.0) == (), "keys from before the pause are no answer"

    keyboard.keys = keys
    assert stepper.look(run, 2.1) == ()  # type: ignore[arg-type]
    assert stepper.speak(2.1) == (() if says is None else (says,))

    run.paused = False
    stepper.react((), 3.0)
    assert (stepper.due_s, stepper.listening) == (inf, False)


def test_a_stop_during_the_pause_asks_no_more(keyboard: Keyboard) -> None:
    run = _Mission()
    stepper = Stepper(keyboard)
    stepper.follow(None, lambda: run)  # type: ignore[arg-type,return-value]
    run.paused = True
    stepper.react((), 2.0)
    run.ending = "so"  # type: ignore[assignment]
    stepper.react((), 2.1)
    assert not stepper.listening


def test_keys_of_a_paused_mission_are_neither_words_nor_answers(keyboard: Keyboard) -> None:
    shared = SharedKeys(keyboard, "abr", "r.")
    keyboard.keys = "aR.1"

    assert shared.stepper.pressed() == "R."
    assert shared.words.pressed() == "a"
    assert shared.answers.pressed() == "1"
