"""The width of text in cells of a terminal, and its wrapping to that width."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator

INDENT = 2


def cells(text: str) -> int:
    """Return the columns of the text: East Asian wide characters two, combining marks none."""
    return len(text) if text.isascii() else sum(_cells_of(character) for character in text)


def _cells_of(character: str) -> int:
    if unicodedata.combining(character):
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


def printable(text: str) -> str:
    """Return the text with a replacement for each unprintable character."""
    return text if text.isprintable() else "".join(map(_printable, text))


def _printable(character: str) -> str:
    hidden = unicodedata.category(character) in {"Cc", "Cs", "Cn"} and character not in "\t\n\r"
    return "\N{REPLACEMENT CHARACTER}" if hidden else character


def wrapped(text: str, width: int, hang: int = 0) -> tuple[str, ...]:
    """Return the text in lines of at most ``width`` columns, broken at spaces if possible.

    Later lines have the first one's indentation and ``hang`` spaces more.
    """
    indent = " " * (len(text) - len(text.lstrip(" ")))
    lines: list[str] = []
    line = ""
    for word in _short_words(text.split(), max(8, width - len(indent) - hang)):
        start = indent + (" " * hang if lines else "")
        candidate = f"{line} {word}" if line else f"{start}{word}"
        if line and cells(candidate) > width:
            lines.append(line)
            candidate = f"{indent}{' ' * hang}{word}"
        line = candidate
    return (*lines, line) if line else ()


def balanced(text: str, width: int) -> tuple[str, ...]:
    """Return the text in few lines of similar length; the first is the shortest.

    A word longer than ``width`` widens the lines, by up to a half.
    """
    longest = max(map(cells, text.split()), default=0)
    width = max(width, min(longest, width * 3 // 2))
    fewest = len(wrapped(text, width))
    while fewest > 1 and width > longest and len(wrapped(text, width - 1)) == fewest:
        width -= 1
    lines: list[str] = []
    for word in reversed(list(_short_words(text.split(), width))):
        if lines and cells(lines[0]) + 1 + cells(word) <= width:
            lines[0] = f"{word} {lines[0]}"
        else:
            lines.insert(0, word)
    return tuple(lines)


def _short_words(words: list[str], width: int) -> Iterator[str]:
    """Yield the words; longer ones in pieces."""
    for word in words:
        rest = word
        while cells(rest) > width:
            yield rest[:width] if rest.isascii() else rest[: width // 2]
            rest = rest[width:] if rest.isascii() else rest[width // 2 :]
        yield rest
