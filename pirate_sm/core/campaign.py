"""Campaigns and scenes as they are written."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model.campaign import (
    Campaign,
    CampaignMission,
    DefectSet,
    Expectation,
    RunChoices,
    StoppingRule,
    TrueEnd,
    Value,
    ValueRange,
    Values,
)
from pirate_sm.core._model.scene import Expected, Scene, SceneStep
from pirate_sm.core._model.variations import LineFaults, StartJitter
