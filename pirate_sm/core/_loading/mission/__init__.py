"""Load a mission with its robot, its pipe and the missions it calls, as one program."""

from __future__ import annotations

from pirate_sm.core._loading.mission.loader import TOLERABLE, LoadedMission, load_mission

__all__ = ["TOLERABLE", "LoadedMission", "load_mission"]
