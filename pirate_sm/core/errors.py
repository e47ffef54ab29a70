"""The exceptions that this package raises.

    PirateError                 exit code 4: a fault in this program
    ├── UsageError              exit code 2: invalid input of a person; nothing has moved
    │   ├── QuantityError       (units) a number with a wrong, missing or unknown unit
    │   └── ExpressionError     (expressions) a condition that does not parse or does not fit
    ├── RecordingError          exit code 2: a recording cannot be read or started
    ├── LoadError               (_loading.problems) exit code 2: invalid files, with all faults
    └── BackendError            exit code 3: the backend or its link failed
        └── DetectorError       a detector of another package failed

A failure that a mission may handle (a refused command, a timeout, a silent sensor) is an event. An
exception means a failure that no mission can handle.
"""

from __future__ import annotations

from copyreg import __newobj__  # type: ignore[attr-defined]
from typing import Any, ClassVar, Final, NamedTuple


class ExitCode:
    """The exit codes of commands; an error carries its own.

    Attributes:
        INTERRUPTED: As a shell shows it: 128 + SIGINT.
        OUTPUT_LOST: The output is not read any more: 128 + SIGPIPE, as a shell shows it.
    """

    SUCCEEDED: Final = 0
    FAILED: Final = 1
    USAGE: Final = 2
    BACKEND: Final = 3
    BUG: Final = 4
    RECORDING_LOST: Final = 5
    INTERRUPTED: Final = 130
    OUTPUT_LOST: Final = 141


class Hint(NamedTuple):
    """What helps, in the words of the command line and in those of Python.

    Attributes:
        option: ``: use --backend trace``.
        argument: ``: use backend='trace'``.
    """

    option: str
    argument: str


NO_HINT = Hint("", "")


class PirateError(Exception):
    """The base class; it carries an exit code and a message for the user.

    Its text is for a caller from Python; the command line shows :attr:`for_terminal`.
    """

    exit_code: ClassVar[int] = ExitCode.BUG

    def __init__(self, *arguments: object, hint: Hint = NO_HINT) -> None:
        super().__init__(*arguments)
        self._hint = hint

    @property
    def for_terminal(self) -> str:
        """The message with the options that help."""
        return f"{super().__str__()}{self._hint.option}"

    def __str__(self) -> str:
        return f"{super().__str__()}{self._hint.argument}"

    def __reduce__(self) -> tuple[Any, ...]:
        # An error reaches another process without being made again from what made it here.
        return __newobj__, (type(self), *self.args), vars(self)


class UsageError(PirateError):
    """Raised for invalid arguments or text, before anything moves."""

    exit_code: ClassVar[int] = ExitCode.USAGE


def not_installed(what: str, package: str | None, extra: str) -> UsageError:
    """Return the error for a package of an extra that is missing, with what installs it.

    Args:
        what: What needs it, in the singular.
        package: Its name.
        extra: The extra of this package that brings it.
    """
    install = f"pip install 'pirate-sm[{extra}]'"
    return UsageError(f"{what} needs {package}, which is not installed: {install}")


class RecordingError(PirateError):
    """Raised for a recording that cannot be read, or cannot be written at its path."""

    exit_code: ClassVar[int] = ExitCode.USAGE


class BackendError(PirateError):
    """Raised when a backend or its link fails in a way that no event reports."""

    exit_code: ClassVar[int] = ExitCode.BACKEND


class DetectorError(BackendError):
    """Raised when a detector of another package fails during a run; the message names it."""
