"""Where a name is declared and used: it is changed, and loading says where it is missing then.

So nothing here knows which names a file has and how far they reach, and what is renamed is loaded
again before the editor gets it.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import cycle, islice
from typing import Final, NamedTuple, TypeAlias

from pirate_sm.core.documents import Place

_MOST: Final = 40
"""Occurrences of a name that are tried as its declaration. [decided]"""

_LETTERS: Final = "zqxj"


class NameAt(NamedTuple):
    """Where a name is written: a file by its path, and the index in its text."""

    path: str
    start: int


class FileSaid(NamedTuple):
    """What loading says of a file.

    Attributes:
        errors: Their places and messages.
        files: The paths of the files that were read, in this order.
    """

    errors: frozenset[tuple[Place, str]]
    files: tuple[str, ...]


Load: TypeAlias = Callable[[Mapping[str, str], str], FileSaid]
"""Loads a file while some files, by their paths, have other texts."""


@dataclass
class Names:
    """Finds names in files.

    Attributes:
        load: Loads a file.
        text_of: Returns the text of a file.
    """

    load: Load
    text_of: Callable[[str], str]
    _before: dict[str, FileSaid] = field(default_factory=dict)

    def declaration(self, at: NameAt, word: str) -> NameAt | None:
        """Return where a name of this file is declared; None if it is elsewhere, or not a name."""
        for start in islice(_written(self.text_of(at.path), word), _MOST):
            other = NameAt(at.path, start)
            if other != at and at in self.uses(other, word):
                return other
        return at if self.uses(at, word) else None

    def file(self, at: NameAt, word: str) -> str | None:
        """Return the path of the file that is named here; None if it is the name of none."""
        after = self.load(self._changed([at], word), at.path).files
        return next((each for each in self._known(at.path).files if each not in after), None)

    def key(self, at: NameAt, word: str) -> NameAt | None:
        """Return the first key of this name in another file that is read with this one."""
        for path in self._known(at.path).files:
            found = re.search(rf"(?<![\w.]){re.escape(word)}(?=\s*:)", self.text_of(path))
            if found and path != at.path:
                return NameAt(path, found.start())
        return None

    def uses(self, declared: NameAt, word: str, others: Iterable[str] = ()) -> list[NameAt]:
        """Return where a name of a file is used, in it and in other files."""
        found = self._missing([declared], word, [declared.path])
        own = [each for each in found if each.path == declared.path]
        return [*found, *self._missing([declared, *own], word, others)]

    def _missing(self, spots: list[NameAt], word: str, paths: Iterable[str]) -> list[NameAt]:
        """Return where files lack a name when it is changed at some spots of one file."""
        changed = self._changed(spots, word)
        found: dict[NameAt, None] = {}
        for path in (each for each in paths if word in self.text_of(each)):
            errors = self.load(changed, path).errors - self._known(path).errors
            for place, _ in sorted(errors):
                file = os.path.realpath(place.file)
                text = changed.get(file) or self.text_of(file)
                found |= dict.fromkeys(NameAt(file, each) for each in _on_line(text, place, word))
        return [*found]

    def renamed(self, spots: Iterable[NameAt], word: str, new: str) -> dict[str, str]:
        """Return the texts of the files with another name; none if loading would then refuse it."""
        texts = _with(self.text_of, spots, word, new)
        for path in texts:
            known = {(each.file, each.line) for each, _ in self._known(path).errors}
            if {(each.file, each.line) for each, _ in self.load(texts, path).errors} - known:
                return {}
        return texts

    def _changed(self, spots: list[NameAt], word: str) -> dict[str, str]:
        """Return the text of a file with a name of this length that there is not, at some spots."""
        new = "".join(islice(cycle(_LETTERS), len(word)))
        return _with(self.text_of, spots, word, new.capitalize() if word[:1].isupper() else new)

    def _known(self, path: str) -> FileSaid:
        if path not in self._before:
            self._before[path] = self.load({}, path)
        return self._before[path]


def _with(
    text_of: Callable[[str], str], spots: Iterable[NameAt], word: str, new: str
) -> dict[str, str]:
    """Return the texts of files with another word at some spots."""
    texts: dict[str, str] = {}
    for path, start in sorted(spots, reverse=True):
        text = texts.get(path) or text_of(path)
        texts[path] = text[:start] + new + text[start + len(word) :]
    return texts


def _written(text: str, word: str) -> Iterator[int]:
    """Yield where a word is written as a whole."""
    pattern = rf"(?<![\w.]){re.escape(word)}(?![\w.]*\w)"
    return (each.start() for each in re.finditer(pattern, text))


def _on_line(text: str, place: Place, word: str) -> list[int]:
    """Return where a word is on the line of a place: there, else anywhere after it."""
    lines = text.splitlines(keepends=True)
    if not 0 < place.line <= len(lines):
        return []
    begin = sum(map(len, lines[: place.line - 1]))
    spots = [begin + each for each in _written(lines[place.line - 1], word)]
    here = begin + place.column - 1
    exact = [each for each in spots if each in (here, here + 1)]
    return exact or [each for each in spots if each >= here]
