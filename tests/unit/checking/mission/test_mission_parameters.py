"""Parameters that nothing uses are reported at their names; every way to use one counts."""

from __future__ import annotations

import pytest

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission.mission_parameters import unused_in
from pirate_sm.core import library
from pirate_sm.core.documents import parse_document, read_document
from pirate_sm.core.loading import validate
from pirate_sm.core.models import Mission

from ..robots import NEWT, ROOT

MISSION = """\
format: 1
mission: m
robot: newt
parameters:
  pause: {type: duration, default: 2 s, description: as long as $pause}
start: a
phases:
  a: {do: [STEP], wait: [{TRIGGER, go: e}], within: {time: WITHIN, go: e}}
ends:
  e: {succeed: "END"}
"""
DEFAULTS = {"STEP": "Rest", "TRIGGER": "when: x > 1", "WITHIN": "9 s", "END": "ok"}
MISSIONS = [
    *library.missions(),
    *sorted((ROOT / "docs" / "examples").glob("*.yaml")),
    NEWT / "patrol.yaml",
    NEWT / "take_hold.yaml",
]


def findings(text: str) -> tuple[Finding, ...]:
    document = parse_document(text, "m.yaml")
    return tuple(unused_in(validate(document, Mission), document))


def with_(**changes: str) -> str:
    text = MISSION
    for name, value in {**DEFAULTS, **changes}.items():
        text = text.replace(name, value)
    return text


@pytest.mark.parametrize("path", MISSIONS, ids=lambda path: path.stem)
def test_shipped_missions_use_their_parameters(path) -> None:
    document = read_document(path)

    assert not list(unused_in(validate(document, Mission), document))


@pytest.mark.parametrize(
    "changes",
    [
        {"TRIGGER": "when: x > $pause"},
        {"TRIGGER": "when: x > 1, held: $pause"},
        {"TRIGGER": "after: $pause"},
        {"WITHIN": "$pause"},
        {"END": "after {pause}"},
        {"STEP": "{log: 'for {pause}'}"},
        {"STEP": "{ask: 'for {pause}?'}"},
        {"STEP": "{ask: 'well?', timeout: $pause}"},
        {"STEP": "{command: Rest, timeout: $pause}"},
        {"STEP": "{command: Rest, retry: $pause}"},
        {"STEP": "{command: Rest, if: x > $pause}"},
        {"STEP": "{call: other, with: {time: $pause}}"},
        {"STEP": "{repeat: {times: $pause, do: [Rest]}}"},
        {"STEP": "{repeat: {times: 2, do: [{command: Rest, timeout: $pause}]}}"},
        {"STEP": "{choose: [{if: x > $pause, do: [Rest]}]}"},
        {"STEP": "{choose: [{if: x > 1, do: []}], else: [{log: '{pause}'}]}"},
    ],
    ids=str,
)
def test_every_way_to_use_a_parameter_counts(changes: dict[str, str]) -> None:
    assert findings(with_(**changes)) == ()


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"END": "after $pause"},
        {"STEP": "{log: 'pause, {cause}'}"},
        {"TRIGGER": "when: x > $pau"},
    ],
    ids=str,
)
def test_a_parameter_without_a_use_is_told_at_its_name(changes: dict[str, str]) -> None:
    (found,) = findings(with_(**changes))

    assert (found.code, str(found.place)) == ("parameter.unused", "m.yaml:5:3")
    assert "'pause'" in found.message


def test_each_one_is_reported() -> None:
    text = with_().replace("start: a", "  more: {type: count, default: 3}\nstart: a")

    assert [each.place.line for each in findings(text)] == [5, 6]
