"""The declarations of a chart file: regions, states, events and guards, with their places."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from pirate_sm.core._loading.problems import Path


class WrittenTransition(NamedTuple):
    """A transition as written in the file, with one or several events."""

    events: tuple[str, ...]
    target: str
    guard: str
    path: Path


@dataclass(frozen=True)
class StateNode:
    """A state as written in the file; a compound state contains others.

    Attributes:
        name: Its name, prefixed by that of its region.
    """

    name: str
    initial: bool
    path: Path
    moves: tuple[WrittenTransition, ...] = ()
    inner: tuple[StateNode, ...] = ()

    @property
    def short_name(self) -> str:
        """Return the name without the region."""
        return self.name.partition(".")[2]

    @property
    def first(self) -> StateNode:
        """Return the leaf that is entered with this state; itself if it is a leaf."""
        return next((each.first for each in self.inner if each.initial), self)

    @property
    def leaves(self) -> tuple[StateNode, ...]:
        """Return the leaves inside this state; itself if it is a leaf."""
        return tuple(leaf for each in self.inner for leaf in each.leaves) or (self,)

    def walk(self) -> Iterator[StateNode]:
        """Yield this state and all states inside it, in the order of the file."""
        yield self
        for each in self.inner:
            yield from each.walk()

    def chains(self) -> Iterator[tuple[StateNode, ...]]:
        """Yield each leaf with its enclosing states, innermost first."""
        if not self.inner:
            yield (self,)
        for each in self.inner:
            yield from ((*chain, self) for chain in each.chains())


@dataclass(frozen=True)
class ChartTransition:
    """A transition of one leaf state on one event.

    Attributes:
        source: The leaf, named as in the file.
        target: The leaf that is entered, named as in the file.
        guard: The guard as written.
        owner: The state that declares the transition: the source or a state that encloses it.
        tree: The parsed guard with compound states expanded; None without one.
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
    """The declarations of a chart file.

    Attributes:
        top: Name of the parallel state that holds the regions.
        states: The leaf states of each region.
        initial: The initial leaf of each region.
        transitions: The transitions of every leaf, those of inner states first.
        commands: All event names, in the order of the file.
        nodes: The states of each region as written.
    """

    top: str
    regions: tuple[str, ...]
    states: tuple[tuple[str, ...], ...]
    initial: tuple[str, ...]
    transitions: tuple[ChartTransition, ...]
    commands: tuple[str, ...]
    nodes: tuple[tuple[StateNode, ...], ...]

    def place_of(self, region: str, state: str) -> Path:
        """Return the path of a state in the file."""
        inside = self.nodes[self.regions.index(region)]
        every = (node for each in inside for node in each.walk())
        return next(node.path for node in every if node.name == f"{region}.{state}")
