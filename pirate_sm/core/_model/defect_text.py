"""How a defect is written: ``stiff_joint:friction=0.9Nm,after=2s``, its name and its numbers.

The numbers replace those of the profile. A range, ``after=2s..20s``, is drawn uniformly from the
seed of the run, which shows and records the number that was drawn. Files and Python may write a
mapping: ``{defect: stiff_joint, after: 2 s}``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from math import inf
from typing import Final, NamedTuple

from pirate_sm.core.errors import UsageError
from pirate_sm.core.spelling import unknown
from pirate_sm.core.units import (
    DIMENSIONLESS,
    TIME,
    TORQUE,
    Dimension,
    Quantity,
    QuantityError,
    format_quantity,
    parse_quantity,
    read_quantity,
)


class Key(NamedTuple):
    """A number that a defect takes.

    Attributes:
        meaning: What it is, in words.
        dimension: Its dimension; None: that of the affected signals.
        most: Its largest value. Numbers with a dimension of their own are at least 0.
    """

    meaning: str
    dimension: Dimension | None = None
    most: float = inf


KEYS: Final[Mapping[str, Key]] = {
    "after": Key("when it begins, from the start of the run", TIME),
    "every": Key("mean time between two occurrences", TIME),
    "lasting": Key("how long one occurrence lasts", TIME),
    "friction": Key("dry friction of a stiff joint, drag of a dead wheel", TORQUE),
    "share": Key("share of lost messages", DIMENSIONLESS, 0.5),
    "by": Key("how far the zero jumps"),
    "shows": Key("what the sensor shows"),
}

_SPELLS: Final = ("after", "every", "lasting")
_TAKES: Final[Mapping[str, tuple[str, ...]]] = {
    "dead_wheel": ("friction", "after"),
    "stiff_joint": ("friction", "after"),
    "sensor_stuck": ("shows", *_SPELLS),
    "sensor_drop": ("shows", *_SPELLS),
    "sensor_spike": ("shows", *_SPELLS),
    "zero_jump": ("by", "after", "every"),
    "lost_messages": ("share", *_SPELLS),
    "firmware_reset": ("after", "every"),
    "stray_motion": ("after", "every"),
}


def keys_of(kind: str) -> tuple[str, ...]:
    """Return the names of the numbers that a kind of defect takes."""
    return _TAKES.get(kind, _SPELLS)


def as_text(written: object) -> object:
    """Return a defect that is written as a mapping as text; anything else as it is."""
    if not (isinstance(written, Mapping) and isinstance(written.get("defect"), str)):
        return written
    pairs = [f"{key}={value}".replace(" ", "") for key, value in written.items() if key != "defect"]
    return f"{written['defect']}:{','.join(pairs)}" if pairs else written["defect"]


def numbers_of(text: str, kind: str) -> dict[str, str]:
    """Return the numbers in the text of a defect, as they are written.

    Raises:
        UsageError: One has another form, is given twice, or is not one that the kind takes.
    """
    name, _, rest = text.partition(":")
    numbers: dict[str, str] = {}
    for each in filter(None, rest.split(",")):
        key, given, value = (part.strip() for part in each.partition("="))
        if not given or key in numbers:
            fault = "given twice" if given else f"expected KEY=VALUE, got '{each}'"
            raise UsageError(f"{name}: {key}: {fault}")
        numbers[key] = value
    if wrong := unknown(f"the defect {name} takes no number", numbers, keys_of(kind)):
        raise UsageError(wrong)
    return numbers


def number_of(
    key: str, written: str, measured: Sequence[Dimension], draw: Callable[[float, float], float]
) -> tuple[Quantity, str]:
    """Return a number and its text; for a range one that was drawn from it, to five digits.

    Args:
        key: Its name in ``KEYS``.
        written: The number as it is written, ``2s`` or ``2s..20s``.
        measured: Dimensions of the affected signals, not empty.
        draw: Draws a number from a range.

    Raises:
        UsageError: It has another form or unit, or is out of bounds.
    """
    _, dimension, most = KEYS[key]
    low, dots, high = written.partition("..")
    expected = [dimension] if dimension else measured
    least = _read(low, expected)
    largest = _read(high, expected) if dots else least
    if dimension and not (least.value >= 0 and largest.value <= most):
        bound = f" and at most {format_quantity(most, dimension)}" if most < inf else ""
        raise UsageError(f"expected at least 0{bound}, got '{written}'")
    if largest.value < least.value or largest.dimension != least.dimension:
        raise UsageError(f"expected a range from the smaller to the larger value, got '{written}'")
    if not dots:
        return least, written
    unit = high.strip().lstrip("+-.0123456789eE ")
    shown = f"{draw(least.value, largest.value) / parse_quantity(f'1{unit}').value:.5g}{unit}"
    return _read(shown, expected), shown


def _read(text: str, dimensions: Sequence[Dimension]) -> Quantity:
    with suppress(QuantityError):
        quantity = parse_quantity(text)
        if quantity.dimension in dimensions:
            return quantity
    return Quantity(read_quantity(text, dimensions[0]), dimensions[0])  # says what is wrong
