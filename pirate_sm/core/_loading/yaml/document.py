"""Read YAML text as plain data with the place of each value.

PyYAML's parser provides events. They are interpreted by the YAML 1.2 core schema with further
restrictions: `on` and `12:30` are text, duplicate keys are faults, the result is plain data only,
and limits bound the time for a hostile file. Faults are collected; only a syntax error stops the
reading.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from pirate_sm.core._loading import problems as found
from pirate_sm.core._loading.problems import Edit, LoadError, Place, Problem, meant_key
from pirate_sm.core._loading.yaml.composer import YamlNode, compose, from_file, overlaid
from pirate_sm.core.library import shown
from pirate_sm.core.on_disk import opened

LARGEST_FILE: Final = 1 << 20  # bytes
_UNPRINTABLE: Final = re.compile(
    "[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]"
)
_INK: Final = re.compile(r"\S")
_QUANTITY: Final = re.compile(r"[-+.]?[0-9]")


@dataclass(frozen=True, slots=True)
class Document:
    """The plain data of a file with the place of each value.

    Attributes:
        name: Name of the file in messages.
        text: Its text.
        root: Its content with the place of every value, which is not to be changed.
        bases: The documents that it extends, with their own bases.
        data: Mappings, lists, text, numbers, booleans and None.
    """

    name: str
    text: str = field(repr=False)
    root: YamlNode = field(repr=False)
    lines: tuple[str, ...] = field(repr=False)
    bases: tuple[Document, ...] = field(default=(), repr=False)

    @property
    def data(self) -> Any:
        """Return the content as plain data."""
        return self.root.value

    @property
    def complete_text(self) -> str:
        """Return a text that needs no other file: that of the file, or all its data as JSON."""
        return json.dumps(self.data, indent=1) if self.bases else self.text

    def extending(self, base: Document, key: str) -> Document:
        """Return this document laid over another one.

        Mappings are merged, anything else replaces what is in the base. Each value keeps its place
        in its own file.

        Args:
            base: The document below.
            key: A key of this document that is left out: the one that names the base.
        """
        root = overlaid(from_file(base.root, base.name), self.root, without=key)
        return Document(self.name, self.text, root, self.lines, (base, *base.bases))

    def excerpt(self, line: int, file: str = "") -> str:
        """Return a line of the file, counted from 1; empty when there is none.

        Args:
            line: Number of the line.
            file: Name of one of the files that it extends, instead of its own.
        """
        lines = self._home(file).lines
        return lines[line - 1] if 1 <= line <= len(lines) else ""

    def place_of(self, path: found.Path, *, key: bool = False, offset: int | None = None) -> Place:
        """Return the place of the value at `path`, or of its nearest existing parent.

        Args:
            path: Keys and list indexes from the root.
            key: Return the place of the value's key, if it has one.
            offset: Return the place of this character of the value's text.
        """
        node, line, column = self.root, self.root.line, self.root.column
        file = ""
        for part in path:
            child = node.child(part)
            if child is None and part == 0:
                continue  # a list of one may be written without brackets
            if child is None:
                return Place(file or self.name, line, column)
            node, key_line, key_column = child
            file = node.file
            line, column = (key_line, key_column) if key else (node.line, node.column)
        if offset is not None:
            line, column = self._home(file)._inside(node, offset)
        return Place(file or self.name, line, column)

    def edit_of(
        self,
        path: found.Path,
        text: str,
        *,
        key: bool = False,
        within: tuple[int, int] | None = None,
        safe: bool = False,
    ) -> Edit | None:
        """Return the change that writes another text at `path`; None if it cannot be made.

        It cannot where nothing is written yet, over several lines, which may hold comments, and at
        an anchor or a tag. A name is only changed to one that is spelt alike.

        Args:
            path: Keys and list indexes from the root; all must exist.
            text: The replacement, as YAML.
            key: Replace the key instead of the value.
            within: Replace only these characters of the value's text.
            safe: Whether nothing else can have been meant.
        """
        node = self.root
        for part in path:
            child = node.child(part)
            if child is None and node.children is not None and part != 0:
                return None
            node = child[0] if child else node  # a name may be short for a mapping with it
        place = self.place_of(path, key=key, offset=within and within[0])
        key = key and isinstance(path[-1], str)
        old = self._home(node.file).text[node.start : node.end]
        if key:
            old = str(path[-1])
        elif within is not None:
            old = str(node.value)[slice(*within)]
        rest = self.excerpt(place.line, place.file)[place.column - 1 :]
        quoted = [mark + old + mark for mark in "\"'" if key and rest.startswith(mark + old + mark)]
        old = quoted[0] if quoted else old
        if within is None:
            number = _QUANTITY.match(old) and _QUANTITY.match(text)
            named = number or meant_key(old.strip("\"'"), [text])
            sound = old[:1] not in "&!" and "\n" not in old and (safe or named)
        else:
            sound = old not in ("", "-")  # a sign is only a part of the number that it means
        if not sound or not rest.startswith(old):
            return None
        return Edit(place, place.column + len(old), text, safe)

    def _home(self, file: str) -> Document:
        """Return the document of a file: this one, or one that it extends."""
        return next((each for each in self.bases if each.name == file), self)

    def _inside(self, node: YamlNode, offset: int) -> tuple[int, int]:
        """Return line and column of a character of a text value.

        Quotes, escapes and folded lines shift text. The character's line of the value is searched
        in the source; if it is not found literally, the start of the value is returned. Folding a
        block (`>`) changes blanks only, so there the other characters are counted.
        """
        value = node.value if isinstance(node.value, str) else ""
        offset = min(max(offset, 0), len(value))
        if self.text.startswith(">", node.start):
            return _line_and_column(self.text, self._folded(node, value, offset))
        begin = value.rfind("\n", 0, offset) + 1
        end = value.find("\n", offset)
        line_text = value[begin : end if end >= 0 else len(value)]
        position = self.text.find(line_text, node.start, node.end) if line_text else -1
        if position < 0:
            return node.line, node.column
        return _line_and_column(self.text, position + offset - begin)

    def _folded(self, node: YamlNode, value: str, offset: int) -> int:
        """Return the position in the file of a character of a folded block's value."""
        before = sum(not each.isspace() for each in value[:offset])
        position = self.text.find("\n", node.start, node.end)  # the header is no part of it
        for match in _INK.finditer(self.text, max(position, node.start), node.end):
            if before == 0:
                return match.start()
            before, position = before - 1, match.end()
        return max(position, node.start)


def _line_and_column(text: str, position: int) -> tuple[int, int]:
    """Return line and column of a position in the text, both counted from 1."""
    lines = (text[:position] + " ").splitlines()  # the blank stands for the character itself
    return len(lines), len(lines[-1])


def read_document(path: Path | str, name: str | None = None) -> Document:
    """Return the document of a file.

    Args:
        path: The file, at most 1 MiB of UTF-8.
        name: What to call it in messages; None: its path, see :func:`.shown`.

    Raises:
        LoadError: The file cannot be read or its content cannot be used.
    """
    name = name or shown(Path(path))
    return parse_document(_content(path, name, "a YAML file"), name)


def read_text(path: Path | str, name: str, expected: str) -> str:
    """Return the text of a file in another language than YAML, within the same limits.

    Args:
        path: The file, at most 1 MiB of UTF-8.
        name: What to call it in messages.
        expected: What it should be, with its article.

    Raises:
        LoadError: The file cannot be read, or is no text.
    """
    return _decoded(_content(path, name, expected), name, expected).removeprefix("\ufeff")


def _content(path: Path | str, name: str, expected: str) -> bytes:
    try:
        with opened(path) as stream:
            return stream.read(LARGEST_FILE + 1)
    except IsADirectoryError:
        raise _refusal(name, "file", f"is a directory; {expected} is expected") from None
    except FileNotFoundError:
        raise _refusal(name, "file", "there is no such file") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise _refusal(name, "file", f"cannot be read: {reason}") from None


def parse_document(text: str | bytes, name: str) -> Document:
    """Return the document of a YAML text.

    Args:
        text: One YAML document, at most 1 MiB.
        name: What to call it in messages.

    Raises:
        LoadError: The content has faults; holds all of them.
    """
    decoded = _decoded(text, name, "YAML text") if isinstance(text, bytes) else text
    decoded = decoded.removeprefix("\ufeff")
    if len(decoded) > LARGEST_FILE:
        raise _too_large(name)
    _refuse_unprintable(decoded, name)
    lines = tuple(decoded.splitlines())
    root, faults = (_composed if len(decoded) <= _LARGEST_KEPT else compose)(decoded)
    problems = [
        Problem(
            fault.code,
            Place(name, fault.line, fault.column),
            fault.message,
            fault.expected,
            fault.suggestion,
            lines[fault.line - 1] if 1 <= fault.line <= len(lines) else "",
        )
        for fault in faults
    ]
    if problems:
        raise LoadError(problems)
    if root is None:
        raise _refusal(name, "empty", "the file is empty; a mapping is expected")
    return Document(name=name, text=decoded, root=root, lines=lines)


_composed: Final = lru_cache(maxsize=32)(compose)
"""The trees of the last texts, for missions share robots and pipes. They must not be changed."""

_LARGEST_KEPT: Final = 200_000
"""Of larger texts the trees are not kept, characters: one takes 20 MB. A profile has 30,000."""


def _decoded(content: bytes, name: str, expected: str) -> str:
    if len(content) > LARGEST_FILE:
        raise _too_large(name)
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise _refusal(name, "encoding", "is written in UTF-16; save it as UTF-8")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        before = content[: error.start]
        if b"\0" in content:
            raise _refusal(name, "binary", f"is a binary file; {expected} is expected") from None
        lines = (before + b" ").splitlines()  # the blank stands for the byte itself
        line, column = len(lines), len(lines[-1].decode("utf-8"))
        message = f"byte 0x{content[error.start]:02x} is not UTF-8; save the file as UTF-8"
        raise LoadError([Problem("encoding", Place(name, line, column), message)]) from None


def _refuse_unprintable(text: str, name: str) -> None:
    """Raise LoadError for characters that YAML 1.2 does not allow (section 5.1)."""
    match = _UNPRINTABLE.search(text)
    if match is None:
        return
    if match[0] == "\0":
        raise _refusal(name, "binary", "is a binary file; YAML text is expected")
    place = Place(name, *_line_and_column(text, match.start()))
    message = f"the character U+{ord(match[0]):04X} is not allowed in YAML"
    raise LoadError([Problem("binary", place, message)])


def _too_large(name: str) -> LoadError:
    return _refusal(name, "too-large", f"is larger than {LARGEST_FILE >> 20} MiB")


def _refusal(name: str, code: str, message: str) -> LoadError:
    """Return an error about the file as a whole."""
    return LoadError([Problem(code, Place(name), message)])
