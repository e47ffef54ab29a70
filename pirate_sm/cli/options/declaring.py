"""Declares the options of commands as fields of a dataclass, and reads values given as text."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, dataclass, field, fields
from inspect import Parameter, signature
from math import inf, isfinite
from typing import Annotated, Any, TypeAlias

from pirate_sm.core.errors import UsageError
from pirate_sm.core.spelling import meant
from pirate_sm.core.units import LENGTH, SPEED, TIME, Dimension, QuantityError, read_quantity

# --- declarations -------------------------------------------------------------------------------


Completion: TypeAlias = Callable[..., Any] | None
"""Answers a shell that completes the value; None where there is nothing to choose from."""
_AFTER_RUNS = 1000.0
"""The place of options in help texts, in the order of their fields, if they have no other one."""


def shape(kind: str, *names: str, **more: Any) -> Callable[[], Any]:
    """Return what declares a parameter to the command line's library, which this does not import.

    Args:
        kind: Its name there: ``Option`` or ``Argument``.
        names: How it is written.
        more: What else the library takes.
    """
    completion = more.pop("autocompletion", None)

    def complete(ctx: Any, incomplete: str) -> Any:  # the library knows the parameters by name
        return completion(ctx, incomplete)

    def make() -> Any:
        import typer

        if completion is not None:
            more["autocompletion"] = complete
        return getattr(typer, kind)(*names, **more)

    return make


def declared(parameter: Callable[[], Any], default: Any) -> Any:
    """Return a field of an options class with its shape."""
    return field(default=default, metadata={"parameter": parameter})


def option(
    metavar: str, completion: Completion, help_text: str, *names: str, default: Any = None
) -> Any:
    """Return an option whose value is a text.

    Args:
        metavar: The form of its value, as help shows it.
        completion: Which values fit.
        help_text: What it means.
        names: How it is written; without any, the field's name after two dashes.
        default: Its value where it is not given.
    """
    own = shape("Option", *names, metavar=metavar, autocompletion=completion, help=help_text)
    return declared(own, default)


def argument(
    metavar: str | None, completion: Completion, help_text: str, *, default: Any = MISSING
) -> Any:
    """Return an argument; the parameters are those of :func:`option`.

    Without a default it must be given; without a metavar help shows the field's name.
    """
    own = shape("Argument", metavar=metavar, autocompletion=completion, help=help_text)
    return declared(own, default)


def flag(help_text: str, *names: str, default: bool = False) -> Any:
    """Return an option without a value; the parameters are those of :func:`option`."""
    return declared(shape("Option", *names, help=help_text), default)


def typed(help_text: str, *names: str, default: Any = None, **more: Any) -> Any:
    """Return an option whose type says its form: a number, or one of several words.

    Args:
        help_text: What it means.
        names: How it is written; without any, the field's name after two dashes.
        default: Its value where it is not given.
        more: Bounds of a number, ``min`` and ``max``, and a ``metavar``.
    """
    return declared(shape("Option", *names, help=help_text, **more), default)


def placed(option: Any, place: float) -> Any:
    """Return an option with its place in help texts, where those of runs begin at 0."""
    return field(default=option.default, metadata={**option.metadata, "place": place})


@dataclass(frozen=True, kw_only=True)
class CommandOptions:
    """The options of a command, with the one that every command has, which comes last."""

    debug: bool = placed(flag("Show tracebacks.", "--debug"), inf)


def parameters_of(options: type) -> list[Parameter]:
    """Return the parameters of a command with these options, in the order of its help text."""
    found: list[tuple[float, Parameter]] = []
    taken = signature(options, eval_str=True).parameters
    for each in fields(options):
        parameter, place = each.metadata.get("parameter"), each.metadata.get("place", _AFTER_RUNS)
        if parameter is not None:
            own = taken[each.name]
            own = own.replace(annotation=Annotated[own.annotation, parameter()])
            found.append((place, own))
        found += each.metadata.get("several", tuple)()
    return [each for _, each in sorted(found, key=lambda placed: placed[0])]


def made(options: type[Any], given: Mapping[str, Any]) -> Any:
    """Return the options with these values; a field for several options takes what is left."""
    own = {each.name: given[each.name] for each in fields(options) if each.name in given}
    rest = {name: value for name, value in given.items() if name not in own}
    several = (each.name for each in fields(options) if "several" in each.metadata)
    return options(**own, **dict.fromkeys(several, rest))


# --- values as text -----------------------------------------------------------------------------


_CHOICE = re.compile(r"(?:Value error, )?'(.*)' is not one of ('.*')\.", re.DOTALL)
_PLAIN = (
    (re.compile(r"Input should be a valid integer.*"), "expected a whole number"),
    (re.compile(r"Input should be a valid number.*"), "expected a number"),
    (re.compile(r"Input should be greater than or equal to "), "expected at least "),
    (re.compile(r"Input should be greater than "), "expected more than "),
    (re.compile(r"Input should be less than or equal to "), "expected at most "),
    (re.compile(r"Input should be less than "), "expected less than "),
    (re.compile(r"Value error, "), ""),
)
"""What the library for command lines says of values, and what that means."""


def plain_refusal(message: str) -> str:
    """Return in plain words why a value is refused, with the name that was probably meant."""
    if choice := _CHOICE.fullmatch(message):
        names = re.findall(r"'([^']*)'", choice[2])
        return f"there is no '{choice[1]}'; {meant(choice[1], names)}"
    for pattern, plain in _PLAIN:
        message = pattern.sub(plain, message)
    return message


def read_settings(texts: Iterable[str] | None) -> dict[str, str]:
    """Return the values of parameters from ``--set NAME=VALUE``, as text, by name.

    Raises:
        UsageError: A text has another form, or a name occurs twice.
    """
    return read_pairs("--set", texts or (), "NAME=VALUE")


def read_pairs(option: str, texts: Iterable[str], form: str) -> dict[str, str]:
    """Return the pairs of a repeatable option in the form NAME=VALUE.

    Raises:
        UsageError: A text has another form, or a name occurs twice.
    """
    pairs: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise UsageError(f"{option} {text}: expected {form}")
        if name in pairs:
            raise UsageError(f"{option} gives '{name}' twice")
        pairs[name] = value
    return pairs


def read_length(option: str, text: str | None) -> float | None:
    """Return the length in an option, m.

    Raises:
        UsageError: It is not a length.
    """
    return _read(option, text, LENGTH)


def read_duration(option: str, text: str | None) -> float | None:
    """Return the duration in an option, s.

    Raises:
        UsageError: It is not a duration above zero.
    """
    return _above_zero(option, text, TIME, "a duration", "10 min")


def read_board(inside: str, square: str) -> tuple[tuple[int, int], float]:
    """Return the corners inside of a chessboard and the length of the sides of its squares, m.

    Raises:
        UsageError: A text has another form, or the board is too small.
    """
    match = re.fullmatch(r"(\d{1,2})x(\d{1,2})", inside)
    if match is None or min(int(match[1]), int(match[2])) < 3:
        raise UsageError(f"--board {inside}: expected the corners inside of it, such as 9x6")
    square_m = read_length("--square", square)
    if square_m is None or square_m <= 0.0:
        raise UsageError(f"--square {square}: expected a length above zero, such as '25 mm'")
    return (int(match[1]), int(match[2])), square_m


def read_slip_speed(option: str, text: str | None) -> float | None:
    """Return the speed that an option gives, m/s.

    Raises:
        UsageError: It is not a speed above zero.
    """
    return _above_zero(option, text, SPEED, "a speed", "1 mm/s")


def _above_zero(
    option: str, text: str | None, dimension: Dimension, what: str, example: str
) -> float | None:
    value = _read(option, text, dimension)
    if value is not None and value <= 0.0:
        raise UsageError(f"{option} {text}: expected {what} above zero, such as '{example}'")
    return value


def _read(option: str, text: str | None, dimension: Dimension) -> float | None:
    if text is None:
        return None
    try:
        return read_quantity(text, dimension)
    except QuantityError as error:
        raise UsageError(f"{option} {text}: {error}") from None


def read_speed(text: str | None, default: float) -> float:
    """Return mission seconds per second of the wall clock; infinite for ``max``.

    Raises:
        UsageError: The text is not a speed.
    """
    if text is None:
        return default
    named = {"max": inf, "realtime": 1.0}
    if text in named:
        return named[text]
    try:
        factor = float(text)
    except ValueError:
        factor = 0.0
    if not (isfinite(factor) and factor > 0):
        raise UsageError(f"--speed {text}: expected max, realtime, or a factor such as 4")
    return factor
