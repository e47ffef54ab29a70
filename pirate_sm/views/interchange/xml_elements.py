"""Read XML safely, as elements with the place of every tag and attribute.

expat reads it, since it alone knows the places. What makes XML dangerous needs a DOCTYPE, so that
is refused: entities that expand, and entities from other files. Nothing outside the text is read.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Final
from xml.parsers import expat

from pirate_sm.core.documents import LoadError, Place, Problem

DEEPEST_NESTING: Final = 32
MOST_ELEMENTS: Final = 20_000

_BETWEEN: Final = " "  # stands in no namespace and in no name
_TAG: Final = re.compile(rb"<[^\s/>]+")
_ATTRIBUTE: Final = re.compile(rb"""\s+([^\s=<>"']+)\s*=\s*(?:"[^"]*"|'[^']*')""")
_LINE_END: Final = re.compile("\r\n|\r|\n")


SCXML: Final = "http://www.w3.org/2005/07/scxml"
"""The namespace of SCXML 1.0 (W3C Recommendation, 1 September 2015)."""

OURS: Final = "urn:pirate-sm"
"""The namespace of what SCXML has no word for; other programs ignore it."""


@dataclass(frozen=True, slots=True)
class Attribute:
    """An attribute with the line and column of its name."""

    value: str
    line: int
    column: int


@dataclass(slots=True)
class XmlElement:
    """An element of an XML document with the line and column of its tag.

    Attributes:
        name: Its name without the prefix.
        namespace: Its namespace; empty without one.
        attributes: The attributes without a namespace, by name.
        others: The values of attributes in a namespace, by namespace and name.
    """

    name: str
    namespace: str
    line: int
    column: int
    attributes: dict[str, Attribute] = field(default_factory=dict)
    others: dict[tuple[str, str], str] = field(default_factory=dict)
    children: list[XmlElement] = field(default_factory=list)


def lines_of(text: str) -> tuple[str, ...]:
    """Return the lines of an XML text; other line separators of Unicode are characters there."""
    return tuple(_LINE_END.split(text))


def read_elements(text: str, name: str) -> XmlElement:
    """Return the root element of an XML text.

    Args:
        text: The text; what it declares as its encoding does not matter.
        name: What to call it in messages.

    Raises:
        LoadError: It is not well-formed, has a DOCTYPE, or is too deep or too large.
    """
    builder = _Builder(text.encode())
    try:
        return builder.build()
    except expat.ExpatError as error:
        line, column = error.lineno, error.offset + 1
        message = f"this is not XML: {expat.ErrorString(error.code)}"
    except _RefusedError as error:
        line, column, message = error.line, error.column, error.message
    lines = lines_of(text)
    excerpt = lines[line - 1] if line <= len(lines) else ""
    problem = Problem("xml", Place(name, line, column), message, excerpt=excerpt)
    raise LoadError([problem]) from None


class _RefusedError(Exception):
    """Raised to stop reading."""

    def __init__(self, message: str, line: int, column: int) -> None:
        super().__init__(message)
        self.message, self.line, self.column = message, line, column


class _Builder:
    """Builds the elements with its own stack while expat reads."""

    def __init__(self, content: bytes) -> None:
        self._content = content
        self._stack: list[XmlElement] = []
        self._root: XmlElement | None = None
        self._count = 0
        # The text is UTF-8 now, whatever it was before.
        self._parser = expat.ParserCreate("utf-8", _BETWEEN)
        self._parser.ordered_attributes = True
        self._parser.StartDoctypeDeclHandler = self._doctype
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end

    def build(self) -> XmlElement:
        self._parser.Parse(self._content, True)
        if self._root is None:
            raise AssertionError("expat refuses a text without an element")
        return self._root

    def _doctype(self, *_: object) -> None:
        # expat has read on to its end.
        begin = self._content.rfind(b"<!DOCTYPE", 0, self._parser.CurrentByteIndex + 1)
        lines = _LINE_END.split(self._content[: max(begin, 0)].decode())
        message = "a DOCTYPE is not allowed: its entities could expand or name other files"
        raise _RefusedError(message, len(lines), len(lines[-1]) + 1)

    def _start(self, name: str, attributes: list[str]) -> None:
        self._count += 1
        if self._count > MOST_ELEMENTS:
            self._refuse(f"more than {MOST_ELEMENTS} elements")
        if len(self._stack) >= DEEPEST_NESTING:
            self._refuse(f"elements are nested more than {DEEPEST_NESTING} deep")
        namespace, _, local = name.rpartition(_BETWEEN)
        line, column = self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber + 1
        element = XmlElement(local, namespace, line, column)
        places = self._places(line, column)
        for key, value in zip(attributes[::2], attributes[1::2], strict=True):
            outside, _, own = key.rpartition(_BETWEEN)
            if outside:
                element.others[outside, own] = value
            else:
                element.attributes[own] = Attribute(value, *places.get(own, (line, column)))
        if self._stack:
            self._stack[-1].children.append(element)
        else:
            self._root = element
        self._stack.append(element)

    def _end(self, _: str) -> None:
        self._stack.pop()

    def _places(self, line: int, column: int) -> dict[str, tuple[int, int]]:
        """Return line and column of each attribute of the tag that begins here."""
        places: dict[str, tuple[int, int]] = {}
        position = self._parser.CurrentByteIndex
        found = _TAG.match(self._content, position)
        while found := _ATTRIBUTE.match(self._content, found.end() if found else position):
            parts = _LINE_END.split(self._content[position : found.start(1)].decode())
            line += len(parts) - 1
            column = len(parts[-1]) + (column if len(parts) == 1 else 1)
            places[found[1].decode()] = line, column
            position = found.start(1)
        return places

    def _refuse(self, message: str) -> None:
        line, column = self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber + 1
        raise _RefusedError(message, line, column)
