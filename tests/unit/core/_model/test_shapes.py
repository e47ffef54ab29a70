"""What the models of mission, profile and pipe take by themselves, without a file."""

from __future__ import annotations

import math

import pytest
from pydantic import TypeAdapter, ValidationError

from pirate_sm.core._model.base import FaultCode, Name
from pirate_sm.core._model.mission import (
    CallStep,
    CommandStep,
    End,
    FaultHandler,
    Mission,
    Phase,
    Step,
)
from pirate_sm.core._model.pipe import Pipe
from pirate_sm.core._model.quantities import Parameter
from pirate_sm.core._model.robot.actuation import Duty, SlotSetpoint, Target
from pirate_sm.core._model.robot.signals import Serial, SetpointTopic, StateTopic
from pirate_sm.core._model.robot.simulation import Friction

SETPOINT = TypeAdapter(SlotSetpoint)
STEP = TypeAdapter(Step)


@pytest.mark.parametrize(
    ("text", "setpoint"),
    [
        ("60 %", Duty(0.6)),
        ("-100 %", Duty(-1.0)),
        ("0 %", Duty(0.0)),
        ("-45 deg", Target(math.radians(-45))),
        ("0 rad", Target(0.0)),
        ("keep", "keep"),
    ],
)
def test_a_setpoint_is_a_duty_an_angle_or_keep(text, setpoint):
    assert SETPOINT.validate_python(text) == setpoint
    again = SETPOINT.validate_python(SETPOINT.dump_python(setpoint))
    assert again == setpoint or again == pytest.approx(setpoint)


@pytest.mark.parametrize("text", ["60", 0.6, "101 %", "-200 %", "5 mm", "stay", "", None, True])
def test_anything_else_is_no_setpoint(text):
    with pytest.raises(ValidationError):
        SETPOINT.validate_python(text)


def test_a_bare_word_is_a_command():
    assert STEP.validate_python("Go") == CommandStep(command="Go")


def test_a_step_is_known_by_its_key():
    step = STEP.validate_python({"call": "other", "with": {"a": "$b", "n": 3}})

    assert isinstance(step, CallStep)
    assert step.arguments == {"a": "$b", "n": 3}


def test_a_step_of_two_kinds_is_none():
    with pytest.raises(ValidationError):
        STEP.validate_python({"command": "Go", "call": "other"})


def test_durations_and_counts_may_be_parameters():
    step = STEP.validate_python({"command": "Go", "timeout": "$t", "retry": "$n"})

    assert (step.timeout, step.retry) == (Parameter("t"), Parameter("n"))


@pytest.mark.parametrize(
    ("model", "data"),
    [
        (End, {}),
        (End, {"succeed": "a", "fail": "b"}),
        (FaultHandler, {"fault": "a.b"}),
        (FaultHandler, {"fault": "a.b", "go": "x", "then": "continue"}),
        (FaultHandler, {"fault": [], "go": "x"}),
        (Phase, {}),
        (Phase, {"go": "a", "within": {"time": 1.0, "go": "b"}}),
        (Phase, {"wait": [{"when": "true", "go": "a"}]}),
        (Phase, {"wait": [{"after": 1.0, "go": "a"}], "go": "b"}),
        (Phase, {"go": "a", "oops": 1}),
        (Friction, {"static": 0.1, "kinetic": 0.2}),
        (Pipe, {"diameter": 0.12, "segments": []}),
        (Pipe, {"diameter": -0.12, "segments": [{"straight": 1.0}]}),
        (Mission, {}),
    ],
)
def test_what_does_not_go_together_is_refused(model, data):
    with pytest.raises(ValidationError):
        model.model_validate(data)


def test_a_wait_with_a_time_of_its_own_needs_no_limit():
    phase = Phase.model_validate({"wait": [{"after": 1.0, "go": "a"}]})

    assert phase.within is None


def test_one_fault_may_stand_without_brackets():
    assert FaultHandler.model_validate({"fault": "a.b", "go": "x"}).fault == ("a.b",)


def test_a_model_cannot_be_changed():
    phase = Phase.model_validate({"go": "a"})

    with pytest.raises(ValidationError, match="frozen"):
        phase.go = "b"


@pytest.mark.parametrize(
    ("kind", "good", "bad"),
    [
        (Name, ["a", "A1_b"], ["", "1a", "a-b", "a b", "a" * 65, "ä", "a\n"]),
        (FaultCode, ["a.b", "a1.b_c.d"], ["a", "A.b", "a.", ".b", "a.b ", "a..b", "a.b\n"]),
    ],
)
def test_names_and_codes(kind, good, bad):
    adapter = TypeAdapter(kind)

    assert [adapter.validate_python(text) for text in good] == good
    for text in bad:
        with pytest.raises(ValidationError):
            adapter.validate_python(text)


@pytest.mark.parametrize(
    ("refresh_every", "stop_after", "message"),
    [
        (None, 0.5, "'stop_after' needs 'refresh_every'"),
        (0.26, 0.5, "at least two repeats must fit"),
        (0.25, 0.5, ""),
        (0.2, None, ""),
        (None, None, ""),
    ],
)
def test_refreshes_come_at_least_twice_before_the_firmware_stops(
    refresh_every: float | None, stop_after: float | None, message: str
) -> None:
    topic = SetpointTopic(topic="go", type="a/Go")
    state = StateTopic(topic="is", type="a/Is", layout="board")

    def made() -> Serial:
        return Serial(
            baud=57600, boot=1.0, echo_within=0.1, heartbeat_within=0.3, setpoints=topic,
            echo=topic, state=state, refresh_every=refresh_every, stop_after=stop_after,
        )  # fmt: skip

    if not message:
        assert made().stop_after == stop_after
        return
    with pytest.raises(ValidationError, match=message):
        made()
