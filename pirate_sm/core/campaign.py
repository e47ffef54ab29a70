"""Campaigns and scenes as they are written."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model.campaign import (
    Campaign,
    CampaignMission,
    DefectSet,
    Expectation,
    Expected,
    LineFaults,
    RunChoices,
    Scene,
    SceneStep,
    StartJitter,
    StoppingRule,
    TrueEnd,
    Value,
    ValueRange,
    Values,
)
