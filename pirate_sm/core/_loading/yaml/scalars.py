"""Resolve unquoted scalars by the YAML 1.2 core schema (section 10.3.2), with finite numbers.

PyYAML follows YAML 1.1, in which `on` and `Off` are booleans, `12:30` and `1_000` numbers. Here
they are text.
"""

from __future__ import annotations

import math
import re
from typing import Final, TypeAlias

Scalar: TypeAlias = "str | int | float | bool | None"

CORE_PREFIX: Final = "tag:yaml.org,2002:"

_WORDS: Final[dict[str, bool | None]] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
_SPECIAL_FLOATS: Final = {
    **{sign + word: math.inf for sign in ("", "+") for word in (".inf", ".Inf", ".INF")},
    **{"-" + word: -math.inf for word in (".inf", ".Inf", ".INF")},
    **dict.fromkeys((".nan", ".NaN", ".NAN"), math.nan),
}
_INT: Final = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT: Final = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_MOST_DIGITS: Final = 18  # fits 64 bits, and keeps int() from quadratic work


class ScalarError(ValueError):
    """Raised for a scalar that does not fit its tag, or a number out of range."""

    def __init__(self, code: str, message: str) -> None:
        self.code = code
        super().__init__(message)


def resolve_plain(text: str) -> Scalar:
    """Return the value of an unquoted scalar.

    Raises:
        ScalarError: The number is too large.
    """
    if text in _WORDS:
        return _WORDS[text]
    if text[0] not in "+-.0123456789":
        return text
    if _INT.fullmatch(text):
        if len(text) > _MOST_DIGITS:
            raise ScalarError("number", f"the number has more than {_MOST_DIGITS} digits")
        return int(text, 0) if text[:2] in ("0o", "0x") else int(text)
    if text in _SPECIAL_FLOATS:
        return _SPECIAL_FLOATS[text]
    if _FLOAT.fullmatch(text):
        value = float(text)
        if math.isinf(value):
            raise ScalarError("number", "the number is too large")
        return value
    return text


def resolve_tagged(tag: str, text: str) -> Scalar:
    """Return the value of a scalar with an explicit tag of the core schema.

    Raises:
        ScalarError: The tag is not allowed, or the text does not fit it.
    """
    kind = tag.removeprefix(CORE_PREFIX)
    if not tag.startswith(CORE_PREFIX) or kind not in ("str", "int", "float", "bool", "null"):
        shown = tag.replace(CORE_PREFIX, "!!")
        raise ScalarError("tag", f"the tag '{shown}' is not allowed: files hold plain data only")
    if kind == "str":
        return text
    value = resolve_plain(text)
    if kind == "float" and type(value) is int:
        return float(value)
    if type(value).__name__ != {"null": "NoneType"}.get(kind, kind):
        raise ScalarError("tag", f"'{text}' does not fit its tag '!!{kind}'")
    return value
