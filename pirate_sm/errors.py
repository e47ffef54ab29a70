"""Every exception this package raises on purpose.

    PirateError                 exit code 4: a fault in this program
    ├── UsageError              exit code 2: what a person wrote cannot be used; nothing has moved
    │   ├── QuantityError       (units) a number with a wrong, missing or unknown unit
    │   └── ExpressionError     (expressions) a condition that does not parse or does not fit
    ├── RecordingError          exit code 2: a recording cannot be read or begun
    ├── LoadError               (loading.problems) exit code 2: files refused, each fault placed
    └── BackendError            exit code 3: the backend or its link failed

A failure that a mission is expected to meet (a refused command, a timeout, a sensor gone silent)
is data and travels as an event; an exception is for what no mission can handle.
"""

from __future__ import annotations

from copyreg import __newobj__  # type: ignore[attr-defined]
from typing import Any, ClassVar, NamedTuple


class Hint(NamedTuple):
    """What helps, in the words of the command line and in those of Python.

    Attributes:
        option: ``: use --backend trace``.
        argument: ``: use backend='trace'``.
    """

    option: str
    argument: str


_NO_HINT = Hint("", "")


class PirateError(Exception):
    """Is the root: whoever catches it knows the exit code and a message for a person.

    Its text is for a caller from Python; the command line shows :attr:`for_terminal`.
    """

    exit_code: ClassVar[int] = 4

    def __init__(self, *arguments: object, hint: Hint = _NO_HINT) -> None:
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
    """Is raised for arguments or text that cannot be used, before anything moves."""

    exit_code: ClassVar[int] = 2


class RecordingError(PirateError):
    """Is raised for a recording that cannot be read, or not begun where it was asked for."""

    exit_code: ClassVar[int] = 2


class BackendError(PirateError):
    """Is raised when a backend or the link to it fails beyond what an event can say."""

    exit_code: ClassVar[int] = 3
