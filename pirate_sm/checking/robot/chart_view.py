"""A chart as seen by the rules: its file, its declarations and its table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from pirate_sm.checking.findings import Finding, at
from pirate_sm.checking.robot.guard_logic import ReachedCombinations
from pirate_sm.core.documents import Document, Place
from pirate_sm.core.loading import ChartOutline
from pirate_sm.core.robot import ChartTable


@dataclass(frozen=True)
class ChartView:
    """A chart that is being checked."""

    document: Document
    outline: ChartOutline
    table: ChartTable

    @cached_property
    def reached(self) -> ReachedCombinations:
        """Return the combinations of states that commands reach."""
        return ReachedCombinations(self.table)

    @cached_property
    def states(self) -> dict[str, tuple[str, ...]]:
        """Return the states of each region."""
        return dict(zip(self.outline.regions, self.outline.states, strict=True))

    def at(
        self, place: Place, code: str, message: str, *, related: Sequence[tuple[Place, str]] = ()
    ) -> Finding:
        """Return a finding at a place of the chart's file."""
        return at(self.document, place, code, message, related=related)
