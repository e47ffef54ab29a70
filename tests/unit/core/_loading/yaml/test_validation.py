"""Every error of a model becomes a problem with a place and words for a person."""

from __future__ import annotations

import json
from enum import Enum
from typing import Annotated, Any, Literal, TypeAlias

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, field_validator
from pydantic_core import PydanticCustomError

from pirate_sm.core._loading.problems import LoadError, Problem, Problems
from pirate_sm.core._loading.yaml.document import parse_document
from pirate_sm.core._loading.yaml.validation import try_validate, validate
from pirate_sm.core._model.quantities import (
    Angle,
    Count,
    Duration,
    DurationOrParameter,
    Flag,
    Length,
    Number,
    Parameter,
)


class Frozen(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)


class Gear(Enum):
    LOW = "low"
    HIGH = "high"


class CommandStep(Frozen):
    command: str
    condition: Annotated[str | None, Field(alias="if")] = None
    timeout: DurationOrParameter | None = None
    retry: Count = 0


class CallStep(Frozen):
    call: str
    arguments: Annotated[dict[str, str], Field(alias="with")] = {}


class RepeatStep(Frozen):
    repeat: Count
    do: tuple[Step, ...]


def step_kind(value: Any) -> str | None:
    if isinstance(value, str):
        return "name"
    words = ("command", "call", "repeat")
    return next((word for word in words if isinstance(value, dict) and word in value), None)


Step: TypeAlias = Annotated[
    Annotated[str, Tag("name")]
    | Annotated[CommandStep, Tag("command")]
    | Annotated[CallStep, Tag("call")]
    | Annotated[RepeatStep, Tag("repeat")],
    Discriminator(step_kind),
]
RepeatStep.model_rebuild()


class Straight(Frozen):
    straight: Annotated[Length, Field(gt=0)]


class Mitre(Frozen):
    mitre: Angle
    radius: Length = 0.0


class Bang(Frozen):
    kind: Literal["bang"]
    loud: Flag = False


class Whisper(Frozen):
    kind: Literal["whisper"]


class Mission(Frozen):
    mission: str
    format: Literal[1] = 1
    side: Literal["left", "right"] = "left"
    gear: Gear = Gear.LOW
    name: Annotated[str, Field(pattern=r"^[a-z]+$", min_length=1)] = "x"
    limit: Annotated[Duration, Field(gt=0, le=600)] = 60.0
    factor: Number = 1.0
    share: float = 0.5
    on: Flag = True
    do: tuple[Step, ...] = ()
    pipe: str | Annotated[tuple[Straight | Mitre, ...], Field(min_length=1)] = "none"
    phases: dict[str, CommandStep] = {}
    noise: Annotated[Bang | Whisper, Discriminator("kind")] | None = None
    pair: tuple[int, str] = (1, "")
    odd: int = 1
    custom: str = ""

    @field_validator("odd")
    @classmethod
    def _is_odd(cls, value: int) -> int:
        if value % 2 == 0:
            raise ValueError("must be odd")
        return value

    @field_validator("custom")
    @classmethod
    def _has_no_x(cls, value: str) -> str:
        if "x" in value:
            raise PydanticCustomError("no-x", "no x here", {"suggestion": value.strip("x")})
        return value


def faults(text: str) -> tuple[Problem, ...]:
    with pytest.raises(LoadError) as raised:
        validate(parse_document("mission: m\n" + text, "m.yaml"), Mission)
    return raised.value.problems


def fault(text: str) -> Problem:
    problems = faults(text)
    assert len(problems) == 1, [found.message for found in problems]
    return problems[0]


class Written(Frozen):
    """Values of each kind that is often written as another one."""

    count: Count = 1
    number: Number = 1.0
    share: float = 0.5
    switch: Flag = True
    names: tuple[Annotated[str, Field(pattern=r"^[a-z]+$")], ...] = ()
    lengths: tuple[Length, ...] = ()


def problems_of(text: str) -> tuple[Problem, ...]:
    try:
        validate(parse_document(text, "m.yaml"), Written)
    except LoadError as error:
        return error.problems
    return ()


@given(
    st.sampled_from(sorted(Written.model_fields)),
    st.text("0123456789.eE+-_x ", max_size=6)
    | st.text("ab, 12m:", max_size=8)
    | st.sampled_from(["on", "No", "1e3", "1920.0", ".inf", "0x1f", "1e999", "−5", "٣", "a, b"]),
)
@example("count", "1e3")
@example("count", "-1")
@example("count", "1920.0")
@example("number", "1e3")
@example("number", "−5")
@example("number", ".inf")
@example("names", "a, b")
@example("lengths", "2 m")
@example("lengths", "0,2 m")
def test_whatever_is_surely_meant_is_valid_where_it_is_written(key: str, value: str) -> None:
    text = json.dumps({key: value}, ensure_ascii=False)
    for problem in problems_of(text):
        if problem.edit is not None and problem.edit.safe:
            begin, end = problem.edit.place.column - 1, problem.edit.end_column - 1
            assert problems_of(text[:begin] + problem.edit.text + text[end:]) == ()


@pytest.mark.parametrize(
    ("key", "value", "meant"),
    [
        ("count", "12", "12"),
        ("count", "1e3", ""),
        ("count", "1920.0", ""),
        ("count", "−5", ""),
        ("names", "a, b", "[a, b]"),
        ("names", "a b", "[a, b]"),
        ("lengths", "2 m", "[2 m]"),
        ("lengths", "0,2 m", ""),
    ],
)
def test_only_what_fits_is_surely_meant(key: str, value: str, meant: str) -> None:
    [problem] = problems_of(json.dumps({key: value}))

    assert (problem.edit.text if problem.edit and problem.edit.safe else "") == meant


def test_a_sound_document_becomes_its_model() -> None:
    text = """\
mission: bend
limit: 2 min
on: false
do: [Halt, {command: Go, if: path > 1 m, timeout: $patience}, {repeat: 2, do: [{call: x}]}]
pipe: [{straight: 1.0 m}, {mitre: 90 deg}]
noise: {kind: whisper}
"""
    mission = validate(parse_document(text, "m.yaml"), Mission)

    assert mission.limit == 120.0
    name, command, repeat = mission.do
    assert name == "Halt"
    assert command == CommandStep(
        command="Go", condition="path > 1 m", timeout=Parameter("patience")
    )
    assert isinstance(repeat, RepeatStep)
    assert repeat.do == (CallStep(call="x"),)
    assert isinstance(mission.pipe[0], Straight)


@pytest.mark.parametrize(
    ("text", "line", "column", "message", "suggestion"),
    [
        ("limti: 3 s", 2, 1, "unknown key 'limti'", "limit"),
        ("format: 2", 2, 9, "this program reads format 1, and this is format 2", ""),
        ("side: Left", 2, 7, "expected one of left, right, got the text 'Left'", "left"),
        ("gear: hihg", 2, 7, "expected one of low, high, got the text 'hihg'", "high"),
        ("gear: [low]", 2, 7, "expected one of low, high, got a list", ""),
        ("name: 12", 2, 7, "expected text, got the number 12", ""),
        ("name: ~", 2, 7, "expected text, got nothing", ""),
        ("name: ''", 2, 7, "this is empty", ""),
        ("name: A-B", 2, 7, "the text 'A-B' does not fit", ""),
        ("limit: 3", 2, 8, "expected a duration such as '2 s', got '3' without a unit", ""),
        ("limit: 3 mm", 2, 8, "expected a duration such as '2 s', got '3 mm', a length", ""),
        ("limit: 3 sec", 2, 8, "expected a duration such as '2 s', got '3 sec' (unknown unit"
         " 'sec' in '3 sec')", "3 s"),
        ("limit: -1 s", 2, 8, "expected more than 0 s, got '-1 s'", ""),
        ("limit: 1 h", 2, 8, "expected at most 600 s, got '1 h'", ""),
        ("factor: fast", 2, 9, "expected a bare number such as 0.6, got 'fast'", ""),
        ("share: half", 2, 8, "expected a number, got the text 'half'", ""),
        ("on: off", 2, 5, "expected true or false, got the text 'off'", "false"),
        ("do: Halt", 2, 5, "expected a list, got the text 'Halt'", ""),
        ("do:\n  - 3", 3, 5, "expected one of name, command, call, repeat, got the number 3", ""),
        ("do:\n  - {comand: Go}", 3, 5,
         "expected one of name, command, call, repeat, got 'comand'", "command"),
        ("do: [{command: Go, iff: x}]", 2, 20, "unknown key 'iff'", "if"),
        ("do: [{command: Go, condition: x}]", 2, 20, "unknown key 'condition'", ""),
        ("do: [{call: Go, with: [x]}]", 2, 23, "expected a mapping, got a list", ""),
        ("do: [{call: [Go]}]", 2, 13, "expected text, got a list", ""),
        ("do: [{command: Go, retry: 1.5}]", 2, 27, "expected a whole number, got the number 1.5",
         ""),
        ("do: [{command: Go, retry: '2'}]", 2, 27, "expected a whole number, got the text '2'",
         "2"),
        ("do: [{repeat: 2, do: [{repeat: 1, do: [{call: 3}]}]}]", 2, 47,
         "expected text, got the number 3", ""),
        ("do: [{repeat: 2}]", 2, 6, "the key 'do' is missing", ""),
        ("pipe: 3", 2, 7, "expected text or a list, got the number 3", ""),
        ("pipe: []", 2, 7, "this is empty", ""),
        ("pipe: [{straight: 0 m}]", 2, 19, "expected more than 0 m, got '0 m'", ""),
        ("pipe: [{miter: 90 deg}]", 2, 9, "unknown key 'miter'", "mitre"),
        ("pipe: [{mitre: 90 deg, radius: 3}]", 2, 32,
         "expected a length such as '120 mm', got '3' without a unit", ""),
        ("phases:\n  one: {}", 3, 3, "the key 'command' is missing", ""),
        ("phases:\n  one: Halt", 3, 8, "expected a mapping, got the text 'Halt'", ""),
        ("noise: {kind: bnag}", 2, 15, "expected one of bang, whisper, got 'bnag'", "bang"),
        ("noise: {}", 2, 1, "expected one of bang, whisper, got a mapping", ""),
        ("noise: {kind: bang, loud: yes}", 2, 27, "expected true or false, got the text 'yes'",
         "true"),
        ("pair: [1, 2]", 2, 11, "expected text, got the number 2", ""),
        ("odd: 2", 2, 6, "must be odd", ""),
        ("custom: xax", 2, 9, "no x here", "a"),
    ],
)  # fmt: skip
def test_an_error_says_where_and_what(
    text: str, line: int, column: int, message: str, suggestion: str
) -> None:
    found = fault(text)

    assert found.message == message
    assert (found.place.line, found.place.column) == (line, column)
    assert found.suggestion == suggestion


def test_all_errors_come_at_once_in_the_order_of_the_file() -> None:
    problems = faults("side: up\ndo: [{command: 1, retry: -1}]\nlimti: 3 s\nodd: 4")

    assert [found.place.line for found in problems] == [2, 3, 3, 4, 5]


def test_a_missing_key_is_missed_where_its_mapping_stands() -> None:
    with pytest.raises(LoadError) as raised:
        validate(parse_document("\nside: left", "m.yaml"), Mission)

    assert str(raised.value).startswith("m.yaml:2:1: the key 'mission' is missing")


def test_a_misspelt_key_is_not_missing_as_well() -> None:
    with pytest.raises(LoadError) as raised:
        validate(parse_document("mision: left", "m.yaml"), Mission)

    assert [found.suggestion for found in raised.value.problems] == ["mission"]


def test_what_is_no_mapping_at_all_is_said() -> None:
    with pytest.raises(LoadError, match=r"m.yaml:1:1: expected a mapping, got a list"):
        validate(parse_document("- a", "m.yaml"), Mission)


def test_text_that_a_comma_cut_is_explained() -> None:
    problems = faults("do: [{command: Go, if: eye in (a, b)}]")

    assert any("in quotes" in found.expected for found in problems)


def test_very_many_errors_are_cut() -> None:
    problems = faults("do: [" + "{}, " * 5_000 + "]")

    assert len(problems) == 201
    assert any(found.message == "4800 more errors are not shown" for found in problems)


def test_a_part_of_a_document_can_be_taken() -> None:
    document = parse_document("pipes:\n  - {straight: 1 m}\n  - {straight: 1 s}\n", "m.yaml")
    problems = Problems()

    assert try_validate(document, Straight, problems, ("pipes", 0)) == Straight(straight=1.0)
    assert try_validate(document, Straight, problems, ("pipes", 1)) is None
    assert [str(found.place) for found in problems.all] == ["m.yaml:3:16"]


SCALARS = st.one_of(
    st.none(), st.booleans(), st.integers(-9, 9), st.sampled_from(["left", "3 s", "Go", "bang"])
)
KEYS = st.sampled_from(
    ["mission", "side", "limit", "do", "command", "call", "with", "repeat", "pipe", "straight",
     "mitre", "phases", "noise", "kind", "pair", "odd", "what"]
)  # fmt: skip
DATA = st.recursive(
    SCALARS,
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(KEYS, inner, max_size=5)),
    max_leaves=20,
)


@given(st.dictionaries(KEYS, DATA, max_size=8))
def test_whatever_is_wrong_has_a_place_in_the_file(data: dict[str, Any]) -> None:
    text = json.dumps(data, indent=1)
    document = parse_document(text, "m.yaml")
    problems = Problems()
    model = try_validate(document, Mission, problems)

    assert (model is None) == bool(problems.errors)
    for found in problems.all:
        assert 1 <= found.place.line <= len(document.lines)
        assert found.message
