"""Find files of robots, missions and pipes by name; importing it is quick."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._loading import library, permissions
from pirate_sm.core._loading.library import PROFILE_FILE, find_mission, is_path, shown
from pirate_sm.core._loading.permissions import SIMULATED, is_below, is_device
