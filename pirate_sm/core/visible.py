"""Escape control characters in text from files before a terminal shows it."""

from __future__ import annotations

from unicodedata import category

_NAMED = {"\n": "\\n", "\r": "\\r", "\t": "\\t"}


def visible(text: str, *, lines: bool = False) -> str:
    """Return the text with every invisible character escaped.

    These are control characters, marks that change the direction of text, zero-width characters
    and Unicode line separators, which could hide or reorder the text of a line.

    Args:
        text: Any text.
        lines: Whether it may have several lines.
    """
    if text.isprintable():
        return text
    return "".join(
        each if _shows(each) or (lines and each == "\n") else _escaped(each) for each in text
    )


def _shows(character: str) -> bool:
    return character.isprintable() or category(character) == "Zs"


def _escaped(character: str) -> str:
    code = ord(character)
    if character in _NAMED:
        return _NAMED[character]
    if code <= 0xFF:
        return f"\\x{code:02x}"
    return f"\\u{code:04x}" if code <= 0xFFFF else f"\\U{code:08x}"
