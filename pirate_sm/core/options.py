"""The options of a run, declared once, and the text of defects; importing it is quick."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model.defect_text import KEYS, as_text, keys_of, number_of, numbers_of
from pirate_sm.core._model.fidelity import USUAL, Fidelity
from pirate_sm.core._model.run_options import (
    DIFFERS,
    JITTER,
    OPTIONS,
    OTHERS,
    GivenOptions,
    Options,
    RunOption,
    written,
)
