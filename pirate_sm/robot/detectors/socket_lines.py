"""Lines of JSON in which another program sends detector words and numbers measured outside."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import nan

from pirate_sm.core.events import DetectorWord, OutsideNumber
from pirate_sm.core.spelling import meant, one_of

LONGEST_LINE = 4096
"""Bytes; valid lines are far shorter."""

LONGEST_VALIDITY_S = 60.0
"""The longest validity, because a program may have died after its word."""

_SHOWN = 60
_LARGEST = 1e300


class LineError(ValueError):
    """Is raised for a line that is not valid; its text is for the sender."""


@dataclass(frozen=True)
class AcceptedLines:
    """What other programs may send.

    Attributes:
        words: The words in the robot's profile; empty where words come from elsewhere.
        valid_for_s: Validity of a word for a line that has none.
        signals: The outside signals of the robot, with the validity of each.
    """

    words: Sequence[str]
    valid_for_s: float = LONGEST_VALIDITY_S
    signals: Mapping[str, float] = field(default_factory=dict)

    @property
    def example(self) -> str:
        """Return a line that is valid."""
        if self.words:
            return f'{{"word": "{self.words[0]}"}}'
        return f'{{"signal": "{next(iter(self.signals), "NAME")}", "value": 0.1}}'


def read_line(line: bytes, accepted: AcceptedLines) -> DetectorWord | OutsideNumber:
    """Return the word or number in a line.

    Args:
        line: ``{"word": "...", "valid_for_s": 1.0, "age_s": 0.1}`` or ``{"signal": "...",
            "value": 0.1, "age_s": 0.1}`` in UTF-8; ``valid_for_s`` and ``age_s`` may be left out.
            ``age_s`` is taken off the validity.
        accepted: What the robot knows.

    Raises:
        LineError: The line is not valid, has an unknown name, or is older than its validity.
    """
    said = read_object(line, accepted.example)
    fields = ("signal", "value") if "signal" in said else ("word", "valid_for_s")
    unknown = [key for key in said if key not in (*fields, "age_s")]
    if unknown:
        raise LineError(f"unknown field '{_short(unknown[0].encode(errors='replace'))}'")
    if "signal" in said:
        name = _name(said, "signal", tuple(accepted.signals))
        return OutsideNumber(name, _value(said), _age(said, accepted.signals[name]))
    word = _name(said, "word", accepted.words)
    valid_for_s = _seconds(said, "valid_for_s", accepted.valid_for_s)
    if not 0 < valid_for_s <= LONGEST_VALIDITY_S:
        raise LineError(f"'valid_for_s' is more than 0 and at most {LONGEST_VALIDITY_S:g} seconds")
    return DetectorWord(word, valid_for_s - _age(said, valid_for_s))


def read_object(line: bytes, example: str) -> dict[str, object]:
    """Return the JSON object in a line.

    Raises:
        LineError: It is not a JSON object, or too long.
    """
    if len(line) > LONGEST_LINE:
        raise LineError(f"a line has at most {LONGEST_LINE} bytes")
    try:
        said = json.loads(line, parse_int=float)
    except (ValueError, RecursionError):
        raise LineError(f"not a line of JSON in UTF-8: {_short(line)}") from None
    if not isinstance(said, dict):
        raise LineError(f"expected an object such as {example}")
    return said


def _name(said: dict[str, object], key: str, names: Sequence[str]) -> str:
    name = said.get(key)
    if not names:
        raise LineError(f"no {key} is accepted here")
    if not isinstance(name, str):
        raise LineError(f"'{key}' is a text, {one_of(names)}")
    if name not in names:
        shown = _short(name.encode(errors="replace"))
        raise LineError(f"unknown {key} '{shown}': {meant(name, names)}")
    return name


def _value(said: dict[str, object]) -> float:
    """Return the number measured, in SI; null is unknown."""
    value = said.get("value")
    if value is None and "value" in said:
        return nan
    if not isinstance(value, float):
        raise LineError("'value' is a number in SI units, or null where it is unknown")
    if not abs(value) < _LARGEST:  # as for NaN
        raise LineError("'value' is a finite number")
    return value


def _age(said: dict[str, object], valid_for_s: float) -> float:
    age_s = _seconds(said, "age_s", 0.0)
    if not 0 <= age_s < valid_for_s:
        raise LineError(f"'age_s' is at least 0 and less than the validity, {valid_for_s:g} s")
    return age_s


def _seconds(said: dict[str, object], key: str, default: float) -> float:
    value = said.get(key, default)
    if not isinstance(value, float):
        raise LineError(f"'{key}' is a number of seconds")
    return value


def _short(line: bytes) -> str:
    text = " ".join(line.decode(errors="replace").split())
    shown = "".join(letter if letter.isprintable() else "�" for letter in text)
    return shown if len(shown) <= _SHOWN else f"{shown[: _SHOWN - 1]}…"
