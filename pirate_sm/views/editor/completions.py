"""What can be written at a place of a file: whatever loading would have taken there.

An impossible word is put there, and loading compares it with all that is valid, for the advice in
its message. So there is no second list of words.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

_IMPOSSIBLE = ("zzqxj: x", "zzqxj", "zzq.xj")
"""Words that no file has: as a key, as a value, and as a code, which has two parts."""

_WORD_BEFORE = re.compile(r"[\w.]*\Z")
_WORD_AFTER = re.compile(r"[\w.]*")
_BEGINS_ENTRY = re.compile(r"(^|\n)[ -]*\Z|[{,][ ]*\Z")


class PossibleWord(NamedTuple):
    """A word for a place.

    Attributes:
        is_key: Whether it is a key, without its colon.
    """

    word: str
    is_key: bool


def gap(text: str, index: int) -> tuple[int, int]:
    """Return where the word begins and ends at an index of a text."""
    before, after = _WORD_BEFORE.search(text[:index]), _WORD_AFTER.match(text, index)
    return before.start() if before else index, after.end() if after else index


def opening(text: str, start: int) -> str:
    """Return what an entry begins with at a place: ``-``, ``[`` or ``{``; empty on its own line."""
    before = text[:start].rpartition("\n")[2].rstrip()
    opened = max(before.rfind("["), before.rfind("{"))
    return before[opened] if before.endswith(("[", "{", ",")) and opened >= 0 else before[-1:]


def offers(
    text: str, start: int, end: int, compared: Callable[[str, str], list[str]]
) -> Iterator[PossibleWord]:
    """Yield the words that are possible instead of a part of a text.

    Args:
        text: The text of the file.
        start: Where the part begins.
        end: Where it ends.
        compared: Loads a text, and returns the names with which loading compares a word in it.
    """
    before, after = text[:start], text[end:]
    begins = _BEGINS_ENTRY.search(before) and not after.startswith(":")
    known: set[str] = set()
    for put in _IMPOSSIBLE:
        word, is_key, _ = put.partition(":")
        if (is_key and not begins) or (known and "." in word):
            continue
        for each in compared(f"{before}{put}{after}", word):
            if each not in known:
                known.add(each)
                yield PossibleWord(each, bool(is_key))
