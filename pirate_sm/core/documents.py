"""YAML files as plain data with the place of every value, and what is wrong with them."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._loading.problems import (
    Edit,
    LoadError,
    Path,
    Place,
    Problem,
    Problems,
    Severity,
    cut,
)
from pirate_sm.core._loading.references import FileKind, kind_of, kind_of_text, read_extended
from pirate_sm.core._loading.yaml.composer import YamlNode
from pirate_sm.core._loading.yaml.document import (
    LARGEST_FILE,
    Document,
    parse_document,
    read_document,
    read_text,
)
