"""Which key asks for what: letters from the names themselves, so that any robot has its own."""

from __future__ import annotations

from collections.abc import Sequence
from string import ascii_lowercase

TAKEN = "q"
"""Leaves the console."""


def letters_for(names: Sequence[str], taken: str = TAKEN) -> dict[str, str]:
    """A lower-case letter for each name, in order, as far as there are letters.

    The first that is free of: the capitals of the name, its other letters, the rest of the
    alphabet from its end.
    """
    free = [letter for letter in ascii_lowercase if letter not in taken]
    found: dict[str, str] = {}
    for name in names:
        capitals = [letter.lower() for letter in name if letter.isupper()]
        wanted = (*capitals, *name.lower(), *reversed(ascii_lowercase))
        letter = next((each for each in wanted if each in free), None)
        if letter is None:
            break
        free.remove(letter)
        found[name] = letter
    return found
