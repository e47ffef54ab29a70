"""What a chart file declares: regions, states, events and guards, each with its place."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from pirate_sm.loading.problems import Path


class WrittenTransition(NamedTuple):
    """A transition as it is written: several events may lead the same way."""

    events: tuple[str, ...]
    target: str
    guard: str
    path: Path


@dataclass(frozen=True)
class StateNode:
    """A state as it is written; a compound one has others inside.

    Attributes:
        name: With that of its region.
    """

    name: str
    initial: bool
    path: Path
    moves: tuple[WrittenTransition, ...] = ()
    inner: tuple[StateNode, ...] = ()

    @property
    def short_name(self) -> str:
        """Return the name without that of the region."""
        return self.name.partition(".")[2]

    @property
    def first(self) -> StateNode:
        """Return the state that is entered with this one: itself, unless others are inside."""
        return next((each.first for each in self.inner if each.initial), self)

    @property
    def leaves(self) -> tuple[StateNode, ...]:
        """Return the states inside that have no others inside; itself if it is one."""
        return tuple(leaf for each in self.inner for leaf in each.leaves) or (self,)

    def walk(self) -> Iterator[StateNode]:
        """Yield this state and all that are inside, in the order of the file."""
        yield self
        for each in self.inner:
            yield from each.walk()

    def chains(self) -> Iterator[tuple[StateNode, ...]]:
        """Yield each leaf with the states around it, from the inside out."""
        if not self.inner:
            yield (self,)
        for each in self.inner:
            yield from ((*chain, self) for chain in each.chains())


@dataclass(frozen=True)
class Transition:
    """Where an event leads from a state without others inside.

    Attributes:
        source: The state, named as in the file.
        target: The state that is entered in the end, likewise.
        guard: As it is written.
        owner: The state that has the transition in the file: the source, or one around it.
        tree: The guard for looking at, compound states in it written out; None without one.
    """

    region: str
    source: str
    event: str
    target: str
    guard: str
    path: Path
    owner: str
    tree: ast.expr | None = field(compare=False)


@dataclass(frozen=True)
class ChartOutline:
    """What a chart file declares.

    Attributes:
        top: Name of the parallel state that holds the regions.
        states: Of each region those that have no others inside.
        initial: Of each region the one of them that it begins in.
        transitions: Each for each state in which it counts, what is written inside first.
        commands: Every event name, in the order of the file.
        nodes: Of each region the states as they are written.
    """

    top: str
    regions: tuple[str, ...]
    states: tuple[tuple[str, ...], ...]
    initial: tuple[str, ...]
    transitions: tuple[Transition, ...]
    commands: tuple[str, ...]
    nodes: tuple[tuple[StateNode, ...], ...]

    def place_of(self, region: str, state: str) -> Path:
        """Return where a state stands in the file."""
        inside = self.nodes[self.regions.index(region)]
        every = (node for each in inside for node in each.walk())
        return next(node.path for node in every if node.name == f"{region}.{state}")
