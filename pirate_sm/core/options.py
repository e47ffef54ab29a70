"""The options of a run, declared once, and the text of defects; importing it is quick."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model.run_options import (
    DEFECT_KEYS,
    DIFFERS,
    JITTER,
    OPTIONS,
    OTHERS,
    USUAL,
    Fidelity,
    GivenOptions,
    Options,
    RunOption,
    defect_as_text,
    keys_of_defect,
    written,
)
