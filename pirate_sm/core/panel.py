"""Control panels as they are written."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model import panel
from pirate_sm.core._model.panel import (
    AnswerButton,
    Button,
    CommandButton,
    Panel,
    RunAction,
    RunButton,
    WordButton,
)
