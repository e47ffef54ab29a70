"""Translates the Markdown of viewers of repositories into that of the site's parser.

The parser, Python-Markdown, wants what belongs to an item of a list indented by four columns, and a
blank line before a list. CommonMark asks for as much as the marker is wide, and for no line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

STEP = 4
_MARKER = re.compile(r"( *)([-*+]|\d{1,9}[.)])( +)(?=\S)")
_FENCE = re.compile(r" *(`{3,}|~{3,})")


def for_site(text: str) -> str:
    """Return the text of a page with its lists as the site's parser reads them."""
    return "\n".join(_lines(text.split("\n")))


def _lines(lines: list[str]) -> Iterator[str]:
    contents: list[int] = []  # the column at which the text of each open item begins
    fence, before = "", ""
    for line in lines:
        column = len(line) - len(line.lstrip())
        if not line.strip():
            yield line
        elif fence:
            yield _moved(line, contents)
            if line.strip() == fence:
                fence = ""
        else:
            while contents and column < contents[-1]:
                if before.strip() and not _MARKER.match(line) and not _FENCE.match(line):
                    break  # a line of the item's paragraph that was not indented
                contents.pop()
            marker = _MARKER.match(line)
            if marker and column - (contents[-1] if contents else 0) < STEP:
                if not contents and before.strip() and not _is_item(before):
                    yield ""
                yield " " * STEP * len(contents) + line.lstrip()
                contents.append(marker.end())
            else:
                yield _moved(line, contents)
                opened = _FENCE.match(line)
                fence = opened[1] if opened else ""
        before = line


def _is_item(line: str) -> bool:
    """Return whether the line belongs to a list."""
    return bool(_MARKER.match(line)) or line.startswith(" ")


def _moved(line: str, contents: list[int]) -> str:
    """Return the line of an item, indented by four columns for each item that it is in."""
    if not contents:
        return line
    spare = max(0, len(line) - len(line.lstrip()) - contents[-1])
    return " " * (STEP * len(contents) + spare) + line.lstrip()
