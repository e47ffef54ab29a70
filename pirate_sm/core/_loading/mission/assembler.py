"""Assemble instructions with labels as targets, and resolve the labels to indexes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from pirate_sm.core._engine.mission.program import HandlerSpec, Instruction
from pirate_sm.core._loading.mission.scope import Handlers, Label
from pirate_sm.core._loading.problems import Path, Problems

MOST_INSTRUCTIONS = 20_000
"""Largest number of instructions, with repeats unrolled and calls inlined."""


class TooLongError(Exception):
    """Raised when the program exceeds ``MOST_INSTRUCTIONS``."""

    def __init__(self) -> None:
        self.by: tuple[Problems, Path] | None = None  # the outermost repeat


@dataclass
class Assembly:
    """The program being written."""

    _kinds: list[type[Any]] = field(default_factory=list)
    _fields: list[dict[str, Any]] = field(default_factory=list)
    _handlers: list[Handlers] = field(default_factory=list)
    _phases: list[str] = field(default_factory=list)
    _turns: list[str] = field(default_factory=list)

    @property
    def length(self) -> int:
        """Return the present number of instructions."""
        return len(self._kinds)

    def mark(self, label: Label) -> None:
        """Set the label to the next instruction."""
        label.index = len(self._kinds)

    def emit(
        self, kind: type[Any], phase: str, handlers: Handlers, /, *, turn: str = "", **fields: Any
    ) -> None:
        """Add an instruction; its fields may hold labels, also inside tuples.

        Args:
            kind: Class of the instruction.
            phase: The phase that it belongs to.
            handlers: Fault handlers in force.
            turn: The round of a repeat, such as ``2 of 4``; empty outside repeats.
            fields: Its fields.

        Raises:
            TooLongError: The program is too long.
        """
        if len(self._kinds) >= MOST_INSTRUCTIONS:
            raise TooLongError
        self._kinds.append(kind)
        self._fields.append(fields)
        self._handlers.append(handlers)
        self._phases.append(phase)
        self._turns.append(turn)

    def finished(
        self,
    ) -> tuple[
        tuple[Instruction, ...],
        tuple[tuple[HandlerSpec, ...], ...],
        tuple[str, ...],
        tuple[str, ...],
    ]:
        """Return the instructions, and the handlers, phase and round of each, without labels."""
        instructions = tuple(
            kind(**{name: _resolved(value) for name, value in fields.items()})
            for kind, fields in zip(self._kinds, self._fields, strict=True)
        )
        handlers = tuple(
            tuple(
                HandlerSpec(code, _resolved(label), name, of, place)
                for code, label, name, of, place in each
            )
            for each in self._handlers
        )
        return instructions, handlers, tuple(self._phases), tuple(self._turns)


def _resolved(value: Any) -> Any:
    if isinstance(value, Label):
        return value.index
    if isinstance(value, tuple):
        items = [_resolved(item) for item in value]
        return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
    return value
