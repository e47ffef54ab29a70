"""What the parser takes fits the schema, and what it refuses for its shape does not."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from typing import Annotated, Any

import jsonschema
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pydantic import BaseModel, Field, TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from pirate_sm.core import units
from pirate_sm.core._model import quantities
from pirate_sm.core._model.robot.actuation import SlotSetpoint
from pirate_sm.core.documents import Problems, parse_document
from pirate_sm.core.loading import outline_chart
from pirate_sm.core.models import Mission, PipeFile, Profile

from .shipped import OF_NEWT, SHIPPED, complaints, data_of, validator

MODELS: dict[str, type[BaseModel]] = {"mission": Mission, "pipe": PipeFile, "profile": Profile}
FILES = [(kind, data_of(path)) for kind, path in [*SHIPPED, *OF_NEWT]]
CHARTS = [data for kind, data in FILES if kind == "chart"]
SMALL = [(kind, data) for kind, data in FILES if kind in ("mission", "pipe")]
PROFILES = [(kind, data) for kind, data in FILES if kind == "profile"]

VALUES = st.sampled_from([
    None, True, False, 0, 1, -1, 3, 0.5, -2.5, "", "x", "two words", "a.b", "12", "true", "$p", "$",
    "5 mm", "-3 s", "0 s", "10 deg", "60 %", "1 Nm/rad", "5 parsec", "keep", "normal", "skip",
    "continue", [], ["x"], [1], [{}], {}, {"x": "y"}, {"command": "Go"},
    {"after": "1 s", "go": "x"},
]).map(copy.deepcopy)  # fmt: skip
KEYS = st.sampled_from(
    ["x", "1x", "if", "go", "wait", "within", "do", "on_failure", "description", "fault", "then",
     "succeed", "fail", "command", "log", "retry", "default", "kind", "for", "torque", "mitre",
     "always", "expect", "within_steps", "after", "limit", "signal", "rate_of", "slot"]
)  # fmt: skip


@st.composite
def broken(draw: st.DrawFn, files: list[tuple[str, Any]]) -> tuple[str, Any]:
    """A shipped file with one to three things changed."""
    kind, whole = draw(st.sampled_from(files))
    data = copy.deepcopy(whole)
    for _ in range(draw(st.integers(1, 3))):
        holders = list(_holders(data))
        holder = draw(st.sampled_from(holders))
        change = draw(st.sampled_from(["put", "put", "drop", "add", "rename", "twice"]))
        place = draw(st.sampled_from(list(_places(holder)))) if holder else None
        if place is None or change == "add":
            _add(holder, draw(KEYS), draw(VALUES))
        elif change == "put":
            holder[place] = draw(VALUES)
        elif change == "drop":
            del holder[place]
        elif isinstance(holder, dict):
            holder[draw(KEYS)] = holder.pop(place)
        else:
            holder.append(copy.deepcopy(holder[place]))
    return kind, data


def _holders(node: Any) -> Iterator[Any]:
    if isinstance(node, dict | list):
        yield node
        for each in node.values() if isinstance(node, dict) else node:
            yield from _holders(each)


def _places(holder: Any) -> Any:
    return holder if isinstance(holder, dict) else range(len(holder))


def _add(holder: Any, key: str, value: Any) -> None:
    if isinstance(holder, dict):
        holder[key] = value
    else:
        holder.append(value)


def beyond_a_schema(error: ErrorDetails) -> bool:
    """Whether no schema can tell: a limit in SI, or one value that is held against another."""
    kind, said = error["type"], error["msg"]
    limits = ("greater_than", "greater_than_equal", "less_than", "less_than_equal")
    return (
        (kind in limits and isinstance(error["input"], str))
        or (kind == "quantity" and said.startswith(("expected at most", "expected at least")))
        or (kind == "value_error" and ("friction" in said or "a duty cycle lies" in said))
    )


def refusals(model: type[BaseModel], data: Any) -> list[ErrorDetails]:
    try:
        model.model_validate(data, context=dict(quantities.FROM_FILE), by_alias=True, by_name=False)
    except ValidationError as error:
        return error.errors(include_url=False)
    return []


def agree(kind: str, data: Any) -> None:
    refused = refusals(MODELS[kind], data)
    said = complaints(validator(kind), data)
    if not refused:
        assert said == []
    elif not all(beyond_a_schema(error) for error in refused):
        assert said != [], refused


@pytest.mark.thorough
@settings(max_examples=300, deadline=None)
@given(broken(SMALL))
def test_parser_and_schema_agree_on_missions_and_pipes(case: tuple[str, Any]) -> None:
    agree(*case)


@pytest.mark.thorough
@settings(max_examples=60, deadline=None)
@given(broken(PROFILES))
def test_parser_and_schema_agree_on_profiles(case: tuple[str, Any]) -> None:
    agree(*case)


@pytest.mark.thorough
@settings(max_examples=100, deadline=None)
@given(broken([("chart", data) for data in CHARTS]))
def test_parser_and_schema_agree_on_charts(case: tuple[str, Any]) -> None:
    _, data = case
    problems = Problems(parse_document(json.dumps(data), "chart.yaml"))
    outline_chart(parse_document(json.dumps(data), "chart.yaml"), problems)
    # What a name refers to, or a guard says, no schema can tell.
    referring = ("chart.target", "chart.guard", "chart.initial")
    shape = [
        each
        for each in problems.errors
        if each.code not in referring and not each.message.startswith("a state of ")
    ]
    said = complaints(validator("chart"), data)
    if not problems.errors:
        assert said == []
    elif shape:
        assert said != [], shape


FAMILIES = {
    "length": quantities.Length,
    "angle": quantities.Angle,
    "duration": quantities.Duration,
    "speed": quantities.Speed,
    "torque": quantities.Torque,
    "stiffness": quantities.Stiffness,
    "acceleration": quantities.Acceleration,
    "ratio": quantities.Ratio,
    "duration or parameter": quantities.DurationOrParameter,
    "count or parameter": quantities.CountOrParameter,
    "any quantity": quantities.AnyQuantity,
    "setpoint": SlotSetpoint,
}
NUMBERS = st.sampled_from(["0", "-0", "5", "+5", "-5", ".5", "5.", "1e3", "1.e-3", "-0.0e5", "0e9"])
GAPS = st.sampled_from(["", " ", "  ", "\t"])
UNITS = st.lists(
    st.tuples(
        st.sampled_from([*units.UNITS, "parsec", ""]), st.sampled_from(["", "", "", "^2", "^-1"])
    ).map("".join),
    min_size=1, max_size=3,
)  # fmt: skip
SIGNS = st.sampled_from(["/", "*", "·", " / ", " * "])


@st.composite
def written(draw: st.DrawFn) -> str:
    """A number with a unit of one to three factors, most of them wrong for what is wanted."""
    first, *others = draw(UNITS)
    unit = first + "".join(draw(SIGNS) + factor for factor in others)
    return draw(GAPS) + draw(NUMBERS) + draw(GAPS) + unit + draw(GAPS)


@pytest.mark.thorough
@pytest.mark.parametrize("family", FAMILIES)
@settings(max_examples=150, deadline=None)
@given(text=written())
@example(text="5")
@example(text="51/s")
@example(text="5 1/s")
@example(text="$p")
@example(text="$1")
@example(text="keep")
@example(text=" 60 %")
def test_a_quantity_is_written_as_the_parser_reads_it(family: str, text: str) -> None:
    _compare(FAMILIES[family], text)


@settings(max_examples=100, deadline=None)
@given(
    kind=st.sampled_from([quantities.Length, quantities.Speed, quantities.Ratio]),
    limit=st.sampled_from(["gt", "ge"]),
    text=written(),
)
def test_a_limit_at_zero_is_in_the_pattern(kind: Any, limit: str, text: str) -> None:
    _compare(Annotated[kind, Field(**{limit: 0})], text)


def _compare(kind: Any, text: str) -> None:
    adapter = TypeAdapter(kind)
    pattern = jsonschema.Draft7Validator(adapter.json_schema())
    try:
        adapter.validate_python(text, context=dict(quantities.FROM_FILE))
    except ValidationError:
        # With three factors or an exponent only the parser knows what the dimension is.
        beyond = "^" in text or sum(text.count(sign) for sign in "/*·") > 1 or "%" in text
        assert beyond or not pattern.is_valid(text)
    else:
        assert pattern.is_valid(text)


@pytest.mark.parametrize(
    "keys",
    [
        {},
        {"segments": None},
        {"segments": [{"straight": "1 m"}], "runs": {"a": {"segments": [{"straight": "1 m"}]}}},
        {"segments": [{"straight": "1 m"}], "routes": {"x": ["a"]}},
        {
            "runs": {"a": {"segments": [{"straight": "1 m"}]}},
            "patches": [{"from": "1 m", "to": "2 m", "friction": 0.3}],
        },
    ],
)
def test_both_refuse_a_pipe_that_has_no_form_or_two(keys: dict[str, Any]) -> None:
    data = {"format": 1, "pipe": "x", "diameter": "120 mm", **keys}

    assert refusals(PipeFile, data)
    agree("pipe", data)
