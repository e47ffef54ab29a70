"""Links of the pages to files and folders of the repository, which become pages of the site.

A linked file is shown with its text; a linked folder lists its files.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DOCS = "docs"
SHOWN = "files"
"""The folder of the site in which the pages of files are."""

LANGUAGES = {
    ".json": "json",
    ".md": "markdown",
    ".py": "python",
    ".xml": "xml",
    ".yaml": "yaml",
    ".yml": "yaml",
}
"""The kinds of files that are shown, by what their names end with."""

_CODE = re.compile(r"^ *(`{3,}).*?^ *\1", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"(?<=\]\()([^)#:\s]+)")


def pages(written: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Yield the name and the text of the page of each file and folder that is linked.

    Args:
        written: The text of each page by its name in ``docs``.
    """
    linked = {
        target
        for page, text in written.items()
        for _, target in _links(text, page)
        if _becomes_a_page(target)
    }
    for folder in [each for each in linked if (ROOT / each).is_dir()]:
        inside = sorted(each for each in (ROOT / folder).iterdir() if each.suffix in LANGUAGES)
        linked.update(posixpath.join(folder, each.name) for each in inside)
        lines = (f"- [{each.name}]({posixpath.basename(folder)}/{each.name}.md)" for each in inside)
        yield _page_of(folder), f"# {folder}\n\n" + "\n".join(lines) + "\n"
    for file in sorted(each for each in linked if (ROOT / each).is_file()):
        text = (ROOT / file).read_text("utf-8")
        language = LANGUAGES[posixpath.splitext(file)[1]]
        yield _page_of(file), f"# {file}\n\n`````{language}\n{text.rstrip()}\n`````\n"


def relinked(text: str, page: str) -> str:
    """Return the text of a page with its links to files as links to the pages of these files."""
    parts, end = [], 0
    for match, target in _links(text, page):
        if _becomes_a_page(target):
            path = posixpath.relpath(_page_of(target), posixpath.dirname(page) or ".")
            parts += [text[end : match.start()], path]
            end = match.end()
        elif _is_index(target):
            path = posixpath.relpath(posixpath.join(target, "index.md"), f"{DOCS}/{page}/..")
            parts += [text[end : match.start()], path]
            end = match.end()
    return "".join([*parts, text[end:]])


def _links(text: str, page: str) -> Iterator[tuple[re.Match[str], str]]:
    """Yield each link of a page outside of code, and the path in the repository it leads to."""
    hidden = [match.span() for match in _CODE.finditer(text)]
    for match in _LINK.finditer(text):
        if not any(start <= match.start() < end for start, end in hidden):
            yield match, posixpath.normpath(posixpath.join(DOCS, posixpath.dirname(page), match[1]))


def _is_index(target: str) -> bool:
    """Return whether the target is a folder of pages."""
    return (ROOT / target).is_dir() and any((ROOT / target).glob("*.md"))


def _becomes_a_page(target: str) -> bool:
    """Return whether the target is a file that is no page yet, or a folder of such files."""
    path = ROOT / target
    if path.is_dir():
        return not _is_index(target)
    inside = target.startswith(f"{DOCS}/")
    return path.suffix in LANGUAGES and path.is_file() and not (inside and path.suffix == ".md")


def _page_of(target: str) -> str:
    return f"{SHOWN}/{target.lstrip('.')}.md"  # MkDocs passes over names that begin with a dot
