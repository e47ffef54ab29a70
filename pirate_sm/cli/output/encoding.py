"""Replaces signs that a terminal's encoding lacks."""

from __future__ import annotations

import codecs
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from typing import TextIO

_ALIKE = {
    "→": "->", "←": "<-", "×": "x", "°": " deg", "−": "-", "–": "-", "—": "-", "…": "...",
    "✓": "v", "✕": "x", "●": "*", "○": "o", "◐": "o", "◆": "*", "■": "#", "▶": ">", "▷": ">",
    "‖": "||", "⚠": "!", "⌀": "diameter", "─": "-", "━": "=", "│": "|", "├": "|", "└": "`",
}  # fmt: skip
"""Replacements for signs that the encoding lacks; a question mark for any other."""


def shows_signs(stream: TextIO | None) -> bool:
    """Return whether the stream's encoding has every sign of the pictures."""
    try:
        "→●⣿━".encode(getattr(stream, "encoding", None) or "ascii")
    except UnicodeEncodeError:
        return False
    return True


def degrade(stream: TextIO | None) -> None:
    """Make the stream replace signs that its encoding lacks."""
    if stream is not None and not shows_signs(stream) and hasattr(stream, "reconfigure"):
        codecs.register_error("alike", _alike)
        stream.reconfigure(errors="alike")


def writable(text: str) -> str:
    """Return the text with signs written out that the encoding of standard output lacks."""
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    return text.encode(encoding, "backslashreplace").decode(encoding)


def _alike(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(_ALIKE.get(each, "?") for each in lacking), error.end
