"""A mission as seen by the rules: its content, its places, and what can happen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.checking.exploring.exploration_index import Explored
from pirate_sm.checking.mission.mission_places import Places
from pirate_sm.checking.pipe.pipe_view import PipeView
from pirate_sm.loading.mission import LoadedMission


@dataclass(frozen=True)
class MissionView:
    """A mission that is being checked.

    Attributes:
        loaded: The mission.
        places: The places of its parts.
        conditions: Decides which conditions can be true together.
        explored: Explorations: of the mission as it is, then without steps that can never run.
        seen: These, and explorations with other faults corrected.
        in_pipe: The course of the mission in its pipe; None without one.
    """

    loaded: LoadedMission
    places: Places
    conditions: Conditions
    explored: Sequence[Explored]
    seen: Sequence[Explored]
    in_pipe: PipeView | None = None

    @property
    def complete(self) -> bool:
        """Return whether the exploration was complete."""
        return all(each.found.complete for each in self.seen)
