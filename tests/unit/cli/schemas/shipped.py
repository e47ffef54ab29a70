"""The files that are shipped, each with the kind of schema that it must fit."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema

from pirate_sm.cli.schema_files import KINDS
from pirate_sm.core.documents import read_document

ROOT = Path(__file__).resolve().parents[4]
TEMPLATES = ROOT / "pirate_sm" / "cli" / "templates"

MISSIONS = [
    *sorted((ROOT / "sequences").glob("*.yaml")),
    *sorted((ROOT / "docs" / "examples").glob("*.yaml")),
]
PIPES = sorted((ROOT / "sequences" / "pipes").glob("*.yaml"))
CAMERAS = sorted((ROOT / "cameras").glob("*.yaml"))
ROBOTS = sorted(path.parent for path in (ROOT / "hardware_profiles").glob("*/profile.yaml"))
PANELS = sorted((ROOT / "panels").glob("*.yaml"))
NEWT = ROOT / "tests" / "robots" / "newt"


def of_robot(kind: str, path: Path) -> tuple[str, Path]:
    """The kind of a profile or chart, which may extend another one."""
    return (f"{kind}_extension" if "\nextends: " in path.read_text("utf-8") else kind), path


SHIPPED = [
    *(("mission", path) for path in MISSIONS),
    *(("pipe", path) for path in PIPES),
    *(("camera", path) for path in CAMERAS),
    *(of_robot("profile", robot / "profile.yaml") for robot in ROBOTS),
    *(of_robot("chart", robot / "chart.yaml") for robot in ROBOTS),
    *(("panel", path) for path in PANELS),
]

OF_NEWT = [
    ("mission", NEWT / "patrol.yaml"),
    ("pipe", NEWT / "elbow.yaml"),
    ("profile", NEWT / "profile.yaml"),
    ("chart", NEWT / "chart.yaml"),
    ("panel", NEWT / "pedals.yaml"),
]


@cache
def validator(kind: str) -> jsonschema.Draft7Validator:
    """Return the validator of the schema of a kind of file."""
    return jsonschema.Draft7Validator(KINDS[kind]())


def data_of(path: Path) -> Any:
    return read_document(path).data


def complaints(schema: jsonschema.Draft7Validator, data: Any) -> list[str]:
    return [f"{error.json_path}: {error.message}" for error in schema.iter_errors(data)]


def committed(path: Path) -> Any:
    return json.loads(path.read_text("utf-8"))


def named(case: Any) -> str:
    return str(case.relative_to(ROOT)) if isinstance(case, Path) else str(case)
