"""Lines of JSON in which another program sends detector words."""

from __future__ import annotations

import json
from collections.abc import Sequence

from pirate_sm.model.events import DetectorWord
from pirate_sm.spelling import meant, one_of

LONGEST_LINE = 4096
"""Bytes; valid lines are far shorter."""

LONGEST_VALIDITY_S = 60.0
"""The longest validity, because a program may have died after its word."""

_SHOWN = 60


class LineError(ValueError):
    """Is raised for a line that is not valid; its text is for the sender."""


def read_line(line: bytes, words: Sequence[str], valid_for_s: float) -> DetectorWord:
    """Return the word in a line.

    Args:
        line: ``{"word": "...", "valid_for_s": 1.0}`` in UTF-8; the second field may be left out.
        words: The words in the robot's profile.
        valid_for_s: Validity for a line that has none.

    Raises:
        LineError: The line is not valid or has an unknown word.
    """
    if len(line) > LONGEST_LINE:
        raise LineError(f"a line has at most {LONGEST_LINE} bytes")
    try:
        said = json.loads(line)
    except (ValueError, RecursionError):
        raise LineError(f"not a line of JSON in UTF-8: {_short(line)}") from None
    if not isinstance(said, dict):
        raise LineError(f'expected an object such as {{"word": "{words[0]}"}}')
    unknown = [key for key in said if key not in ("word", "valid_for_s")]
    if unknown:
        raise LineError(f"unknown field '{_short(unknown[0].encode(errors='replace'))}'")
    return DetectorWord(_word(said, words), _validity(said.get("valid_for_s", valid_for_s)))


def _word(said: dict[str, object], words: Sequence[str]) -> str:
    word = said.get("word")
    if not isinstance(word, str):
        raise LineError(f"'word' is a text, {one_of(words)}")
    if word not in words:
        shown = _short(word.encode(errors="replace"))
        raise LineError(f"unknown word '{shown}': {meant(word, words)}")
    return word


def _validity(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise LineError("'valid_for_s' is a number of seconds")
    if 0 < value <= LONGEST_VALIDITY_S:  # false for NaN
        return float(value)
    raise LineError(f"'valid_for_s' is more than 0 and at most {LONGEST_VALIDITY_S:g} seconds")


def _short(line: bytes) -> str:
    text = " ".join(line.decode(errors="replace").split())
    shown = "".join(letter if letter.isprintable() else "�" for letter in text)
    return shown if len(shown) <= _SHOWN else f"{shown[: _SHOWN - 1]}…"
