"""Faults of an expression, with their places in its text."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from pirate_sm.errors import UsageError


@dataclass(frozen=True, slots=True)
class ExpressionFault:
    """One fault in an expression.

    Attributes:
        message: What is wrong, for users.
        offset: Its position in characters from the start of the expression.
        suggestion: The text that was probably meant; empty if unknown.
        length: Number of characters that it covers.
    """

    message: str
    offset: int
    suggestion: str = ""
    length: int = 1


class ExpressionError(UsageError):
    """Raised for an invalid expression; holds all its faults."""

    def __init__(self, faults: Iterable[ExpressionFault]) -> None:
        self.faults = tuple(sorted(faults, key=lambda fault: fault.offset))
        first = self.faults[0]
        self.message = first.message
        self.offset = first.offset
        self.suggestion = first.suggestion
        super().__init__("; ".join(_line(fault) for fault in self.faults))


def _line(fault: ExpressionFault) -> str:
    hint = f", did you mean '{fault.suggestion}'?" if fault.suggestion else ""
    return f"column {fault.offset + 1}: {fault.message}{hint}"
