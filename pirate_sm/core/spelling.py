"""Find the nearest valid name for a misspelt one, and format lists of names for messages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from difflib import get_close_matches

_LONGEST_WORD = 64  # difflib is quadratic; nobody misspells a name of this length
_CUTOFF = 0.6
_CUTOFF_OTHER_LETTER = 0.75  # a slip of a finger seldom changes the first letter
_OPPOSITE = "un"
_ENDINGS = (".yaml", ".yml")

_compared: ContextVar[tuple[str, dict[str, None]] | None] = ContextVar("compared", default=None)


@contextmanager
def compared_with(word: str) -> Iterator[dict[str, None]]:
    """Return a context that collects the names with which a word is compared, in their order.

    An impossible word in a file shows in this way which words are possible in its place.
    """
    found: dict[str, None] = {}
    before = _compared.set((_fold(word), found))
    try:
        yield found
    finally:
        _compared.reset(before)


def nearest(word: str, candidates: Iterable[str]) -> str | None:
    """Return the candidate that `word` most likely stands for, or None when none is close.

    Letters in the wrong case, `-`, `.` or blanks for `_`, and the ending of a file count as the
    same spelling. A name that says the opposite, as `Unlocked` of `Locked`, is never close.
    """
    if len(word) > _LONGEST_WORD:
        return None
    by_fold: dict[str, str] = {}
    for candidate in candidates:
        by_fold.setdefault(_fold(candidate), candidate)
    folded, compared = _fold(word), _compared.get()
    if compared is not None and compared[0] == folded:
        compared[1].update(dict.fromkeys(by_fold.values()))
    if folded in by_fold:
        return by_fold[folded]
    opposites = {_OPPOSITE + folded, folded.removeprefix(_OPPOSITE)}
    allowed = [each for each in by_fold if each not in opposites]
    for close in get_close_matches(folded, allowed, n=3, cutoff=_CUTOFF):
        if close[:1] == folded[:1] or get_close_matches(folded, [close], 1, _CUTOFF_OTHER_LETTER):
            return by_fold[close]
    return None


def meant(word: str, known: Iterable[str], otherwise: str = "", *, limit: int = 12) -> str:
    """Return a hint for an unknown name: the nearest valid one, else what is expected.

    Args:
        word: The name.
        known: The names that are valid.
        otherwise: What to say where none is near, in place of the valid names.
        limit: How many of the valid names to list.
    """
    names = list(known)
    close = nearest(word, names)
    return f"did you mean '{close}'?" if close else otherwise or f"expected {one_of(names, limit)}"


def unknown(says: str, names: Iterable[str], known: Iterable[str], otherwise: str = "") -> str:
    """Return what is wrong with the names that are not known, all of them; empty if each is.

    Args:
        says: What is said before a name, such as `there is no defect`.
        names: The names.
        known: The names that are valid.
        otherwise: What to say where none is near, in place of the valid names.
    """
    valid = list(known)
    wrong = {name: nearest(name, valid) for name in names if name not in valid}
    lines = [f"{says} '{name}': did you mean '{close}'?" for name, close in wrong.items() if close]
    if far := [f"'{name}'" for name, close in wrong.items() if not close]:
        lines.append(f"{says} {' or '.join(far)}: {otherwise or f'expected {one_of(valid)}'}")
    return "\n".join(lines)


def one_of(names: Iterable[str], limit: int = 12) -> str:
    """Return `a`, `one of a, b, c`, or a shortened list when there are more than `limit`."""
    listed = list(names)
    if len(listed) == 1:
        return listed[0]
    shown = ", ".join(listed[:limit])
    more = len(listed) - limit
    return f"one of {shown}, … ({more} more)" if more > 0 else f"one of {shown}"


def listed(names: Iterable[str], word: str = "and") -> str:
    """Return ``a``, ``a and b`` or ``a, b and c``."""
    *rest, last = [*names] or [""]
    return f"{', '.join(rest)} {word} {last}" if rest else last


def _fold(word: str) -> str:
    word = word.strip().casefold()
    for ending in _ENDINGS:
        word = word.removesuffix(ending)
    return word.replace("-", "_").replace(" ", "_").replace(".", "_")
