"""A mission as the rules look at it: what is written, where it stands, what can happen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pirate_sm.checking.exploring.exploration_index import Explored
from pirate_sm.checking.mission.mission_places import Places
from pirate_sm.loading.mission import LoadedMission


@dataclass(frozen=True)
class MissionView:
    """A mission under examination.

    Attributes:
        loaded: The mission.
        places: Of its parts in its files.
        explored: What can happen, first as it is, then with steps left out that can never run.
        seen: That, and what can happen once other faults are mended.
    """

    loaded: LoadedMission
    places: Places
    explored: Sequence[Explored]
    seen: Sequence[Explored]

    @property
    def complete(self) -> bool:
        """Return whether all that can happen has been looked at."""
        return all(each.found.complete for each in self.seen)
