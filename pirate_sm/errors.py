"""The exceptions that this package raises.

    PirateError                 exit code 4: a fault in this program
    ├── UsageError              exit code 2: invalid input of a person; nothing has moved
    │   ├── QuantityError       (units) a number with a wrong, missing or unknown unit
    │   └── ExpressionError     (expressions) a condition that does not parse or does not fit
    ├── RecordingError          exit code 2: a recording cannot be read or started
    ├── LoadError               (loading.problems) exit code 2: invalid files, with all faults
    └── BackendError            exit code 3: the backend or its link failed

A failure that a mission may handle (a refused command, a timeout, a silent sensor) is an event. An
exception means a failure that no mission can handle.
"""

from __future__ import annotations

from typing import ClassVar


class PirateError(Exception):
    """The base class; it carries an exit code and a message for the user.

    Attributes:
        option_hint: Text that the command line adds to the message: the option that helps.
    """

    exit_code: ClassVar[int] = 4

    def __init__(self, *arguments: object, option_hint: str = "") -> None:
        super().__init__(*arguments)
        self.option_hint = option_hint


class UsageError(PirateError):
    """Raised for invalid arguments or text, before anything moves."""

    exit_code: ClassVar[int] = 2


class RecordingError(PirateError):
    """Raised for a recording that cannot be read, or cannot be written at its path."""

    exit_code: ClassVar[int] = 2


class BackendError(PirateError):
    """Raised when a backend or its link fails in a way that no event reports."""

    exit_code: ClassVar[int] = 3
