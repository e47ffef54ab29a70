"""A value of the wrong kind is shown as it is to be written, where only one form can be meant."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pirate_sm.core._loading.problems import Problems
from pirate_sm.core._loading.yaml.document import parse_document
from pirate_sm.core._loading.yaml.validation import try_validate, validate
from pirate_sm.core._model.mission import Mission

MISTAKES = Path(__file__).parents[4] / "mistakes" / "bases"


def form(at: str, wrong: str) -> tuple[str, list[str]]:
    """Return the text of a mission whose part `at` is `wrong`, and the forms that are shown."""
    text = (MISTAKES / "drive.yaml").read_text(encoding="utf-8")
    lines = re.sub(rf"(?m){at}", lambda _: wrong, text, count=1)
    assert lines != text
    document = parse_document(lines, "drive.yaml")
    problems = Problems(document)
    try_validate(document, Mission, problems)
    return lines, [each.expected.strip("`") for each in problems.errors if each.code == "kind"]


@pytest.mark.parametrize(
    ("at", "wrong", "shown"),
    [
        (r"do: \[Brake\]", "do: Brake", "do: [Brake]"),
        (r"do: \[Brake\]", "do: 'Brake,  ToggleLighting,'", "do: [Brake, ToggleLighting]"),
        (r"do: \[Brake\]", "do: Brake ToggleLighting", "do: [Brake, ToggleLighting]"),
        (r"within: .*", "within: 20 s", "within: {time: 20 s, go: …}"),
        (r"wait: .*", "wait: {after: 20 s, go: halt}", "wait: [{after: 20 s, go: halt}]"),
        (r"arrived: \{.*", "arrived: success", "arrived: {succeed: success}"),
        (r"go: arrived", "go: [arrived]", "go: arrived"),
        (r"way: \{.*", "way: 200 mm", "way: {type: length, default: 200 mm}"),
        (
            r"on_fault:\n.*\n.*",
            "on_fault: {wheel.dead: continue, robot.stuck: regrip}",
            "on_fault: [{fault: wheel.dead, then: continue}, {fault: robot.stuck, go: regrip}]",
        ),
    ],
)
def test_a_value_of_the_wrong_kind_is_shown_as_it_is_to_be_written(
    at: str, wrong: str, shown: str
) -> None:
    text, forms = form(at, wrong)
    assert forms == [shown]
    document = parse_document(text.replace(wrong, shown.replace("…", "halt")), "drive.yaml")
    validate(document, Mission)


@pytest.mark.parametrize(
    ("at", "wrong"),
    [
        (r"arrived: \{.*", "arrived: Driven"),  # succeeded or failed?
        (r"halt: \{.*", "halt: Brake"),  # a step, the next phase?
        (r"go: arrived", "go: [arrived, halt]"),
        (r"way: \{.*", "way: 200"),  # of which type?
        (r"starts_in: .*", "starts_in: Unclamped"),  # of which region?
        (r"do: \[Brake\]", "do: {}"),
        (r"do: \[Brake\]", "do: ''"),
        (r"do: \[Brake\]", "do: ','"),
        (r"do: \[Brake\]", "do: 'log: 5'"),
        (r"do: \[Brake\]", "do: 'Brake, 5 s'"),
        (r"wait: .*", "wait: {}"),
    ],
)
def test_no_form_is_shown_where_several_may_be_meant(at: str, wrong: str) -> None:
    assert form(at, wrong)[1] == [""]


@pytest.mark.parametrize(("longer", "most"), [(0, 25), (480_000, 2)])
def test_a_large_document_is_validated_a_few_times_only(longer: int, most: int) -> None:
    phases = "".join(f"  p{n}: {{do: [Brake], wait: {{after: 2 s, go: e}}}}\n" for n in range(25))
    head = f"format: 1\nmission: m\n# {'x' * longer}\nrobot: r\nstart: p0\nphases:\n"
    document = parse_document(f"{head}{phases}ends: {{e: {{succeed: ok}}}}\n", "m.yaml")
    problems = Problems(document)

    try_validate(document, Mission, problems)

    shown = [each.expected for each in problems.errors]
    assert len(shown) == 25
    assert sum(map(bool, shown)) == most
