"""The schemas that are committed are those of the models, and what is shipped fits them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from pirate_sm.cli.schema_files import KINDS, MODELINE, mission_schema_text, schema_text
from pirate_sm.core.loading import load_robot

from .shipped import (
    NEWT,
    OF_NEWT,
    ROBOTS,
    ROOT,
    SHIPPED,
    TEMPLATES,
    committed,
    complaints,
    data_of,
    named,
    validator,
)

COMMITTED = [
    *((ROOT / "schemas" / f"{kind}.schema.json") for kind in KINDS),
    *(robot / "mission.schema.json" for robot in ROBOTS),
]


@pytest.mark.parametrize("kind", KINDS)
def test_the_committed_schema_is_that_of_the_models(kind: str) -> None:
    text = (ROOT / "schemas" / f"{kind}.schema.json").read_text("utf-8")
    assert text == schema_text(kind), "run `make schemas`"


@pytest.mark.parametrize("robot", ROBOTS, ids=named)
def test_the_committed_schema_of_missions_is_that_of_the_robot(robot: Path) -> None:
    text = (robot / "mission.schema.json").read_text("utf-8")
    assert text == mission_schema_text(load_robot(robot)), "run `make schemas`"


@pytest.mark.parametrize("path", COMMITTED, ids=named)
def test_a_schema_is_one_of_draft_7(path: Path) -> None:
    jsonschema.Draft7Validator.check_schema(committed(path))


@pytest.mark.parametrize("path", COMMITTED, ids=named)
def test_every_key_has_a_hover_text(path: Path) -> None:
    assert [key for key, about in _properties(committed(path)) if not about] == []


@pytest.mark.parametrize(("kind", "path"), [*SHIPPED, *OF_NEWT], ids=named)
def test_a_shipped_file_fits_its_schema(kind: str, path: Path) -> None:
    assert complaints(validator(kind), data_of(path)) == []


@pytest.mark.parametrize(("kind", "path"), SHIPPED, ids=named)
def test_the_first_line_of_a_shipped_file_leads_to_its_schema(kind: str, path: Path) -> None:
    first = path.read_text("utf-8").splitlines()[0]

    assert first.startswith(MODELINE)
    schema = (path.parent / first.removeprefix(MODELINE)).resolve()
    assert schema in COMMITTED
    assert schema.name == f"{kind}.schema.json"
    assert complaints(jsonschema.Draft7Validator(committed(schema)), data_of(path)) == []


@pytest.mark.parametrize("path", sorted(TEMPLATES.rglob("*.yaml")), ids=named)
def test_a_template_has_such_a_line_too(path: Path) -> None:
    assert path.read_text("utf-8").startswith("$modeline\n")


def _properties(node: Any) -> Iterator[tuple[str, str]]:
    """Each key with its description; conditions on keys say nothing of their own."""
    if isinstance(node, list):
        for each in node:
            yield from _properties(each)
        return
    if not isinstance(node, dict):
        return
    for name, value in node.items():
        if name == "properties":
            for key, about in value.items():
                yield key, about.get("description", "")
                yield from _properties(about)
        elif name not in ("if", "then", "else", "oneOf", "default", "examples"):
            yield from _properties(value)


def newt_schema() -> jsonschema.Draft7Validator:
    import json  # noqa: PLC0415

    return jsonschema.Draft7Validator(json.loads(mission_schema_text(load_robot(NEWT))))


def test_the_schema_of_a_robot_knows_its_commands_and_states() -> None:
    schema = newt_schema()
    data = data_of(NEWT / "patrol.yaml")
    assert complaints(schema, data) == []

    for step in ("HoldNoze", {"command": "HoldNoze"}, {"repeat": {"times": 2, "do": ["Jump"]}}):
        phase = {"do": [step], "go": next(iter(data["ends"]))}
        assert complaints(schema, data | {"phases": {data["start"]: phase}})
    assert complaints(schema, data | {"starts_in": {"Grip": "NoseHeld"}}) == []
    assert complaints(schema, data | {"starts_in": {"Grip": "NoseHold"}})
    assert complaints(schema, data | {"starts_in": {"Grap": "NoseHeld"}})
