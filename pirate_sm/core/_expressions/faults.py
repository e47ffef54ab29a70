"""Faults of an expression, with their places in its text."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from pirate_sm.core.errors import UsageError


@dataclass(frozen=True, slots=True)
class ExpressionFault:
    """One fault in an expression.

    Attributes:
        message: What is wrong, for users.
        offset: Its position in characters from the start of the expression.
        suggestion: The text to write instead, with the blanks that it needs; empty if unknown.
        length: Number of characters that it covers.
        certain: Whether nothing else than the suggestion can have been meant.
    """

    message: str
    offset: int
    suggestion: str = ""
    length: int = 1
    certain: bool = False


class ExpressionError(UsageError):
    """Raised for an invalid expression; holds all its faults."""

    def __init__(self, faults: Iterable[ExpressionFault]) -> None:
        self.faults = tuple(sorted(faults, key=lambda fault: fault.offset))
        first = self.faults[0]
        self.message = first.message
        self.offset = first.offset
        self.suggestion = first.suggestion.strip()
        super().__init__("; ".join(_line(fault) for fault in self.faults))


def refusal(message: str, offset: int, suggestion: str = "", length: int = 1) -> ExpressionError:
    """Return the error for one fault."""
    return ExpressionError([ExpressionFault(message, offset, suggestion, length)])


def _line(fault: ExpressionFault) -> str:
    hint = f", did you mean '{fault.suggestion.strip()}'?" if fault.suggestion else ""
    return f"column {fault.offset + 1}: {fault.message}{hint}"
