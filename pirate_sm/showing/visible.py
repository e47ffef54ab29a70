"""Text from files as a terminal may show it: nothing in it moves a cursor or rings a bell."""

from __future__ import annotations

_CONTROLS = [*range(0x20), *range(0x7F, 0xA0)]
_NAMED = {ord("\n"): "\\n", ord("\r"): "\\r", ord("\t"): "\\t"}
_ESCAPED = {code: _NAMED.get(code, f"\\x{code:02x}") for code in _CONTROLS}
_ESCAPED_IN_LINES = {code: text for code, text in _ESCAPED.items() if code != ord("\n")}


def visible(text: str, *, lines: bool = False) -> str:
    """The text with its control characters (C0, DEL, C1) written out.

    Args:
        text: Any text.
        lines: Whether it may have several lines.
    """
    return text.translate(_ESCAPED_IN_LINES if lines else _ESCAPED)
