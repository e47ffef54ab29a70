"""Pipes as they are written: segments, runs, networks."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model.pipe import Blockage, FrictionStretch, Pipe, PipeFile, Turns
from pirate_sm.core._model.pipe_runs import PipeRun, Straight
