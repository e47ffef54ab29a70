"""A robot's statechart as a flat table of transitions between configurations.

The statechart library defines the semantics: :mod:`pirate_sm.core._loading.chart.exploration`
explores the chart with it and builds the table. The engine only looks transitions up.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

Configuration = tuple[str, ...]


@dataclass(frozen=True)
class ChartTable:
    """Every reachable configuration, and for each command the configuration that follows.

    Attributes:
        regions: Names of the parallel state machines.
        states: Per region the names of its states.
        commands: Names of the events.
        configurations: Every reachable combination, one state name per region.
        following: ``following[configuration][command]`` is an index into ``configurations``; the
            same index means that the chart does not move.
        refusals: ``refusals[configuration][command]`` is an index into ``reasons``; it says why
            the chart does not move.
        reasons: The distinct reasons; the first is empty.
    """

    regions: tuple[str, ...]
    states: tuple[tuple[str, ...], ...]
    commands: tuple[str, ...]
    configurations: tuple[Configuration, ...]
    following: tuple[tuple[int, ...], ...]
    refusals: tuple[tuple[int, ...], ...]
    reasons: tuple[str, ...]
    initial: int = 0
    _index: dict[Configuration, int] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        index = {states: number for number, states in enumerate(self.configurations)}
        object.__setattr__(self, "_index", index)

    @cached_property
    def command_index(self) -> Mapping[str, int]:
        """Return the index of each command by its name."""
        return {name: number for number, name in enumerate(self.commands)}

    def index_of(self, configuration: Configuration) -> int | None:
        """Return the index of a configuration, or None when it cannot be reached."""
        return self._index.get(configuration)

    def follow(self, configuration: int, command: int) -> int:
        """Return the configuration that the chart has after the command."""
        return self.following[configuration][command]

    def why_not(self, configuration: int, command: int) -> str:
        """Return why the chart does not move: the unmet conditions of the command."""
        return self.reasons[self.refusals[configuration][command]]
