"""Checks a built site: nothing is fetched from elsewhere, every page is near the tutorial.

`python -m website.built_site FOLDER` prints what is wrong and ends with 1 if anything is.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Mapping
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

CLICKS = 3
"""How many clicks any page may be away from the tutorial."""

TUTORIAL = "tutorial/index.html"
_FETCHED = {
    "audio",
    "embed",
    "iframe",
    "img",
    "input",
    "object",
    "script",
    "source",
    "track",
    "video",
}
_ELSEWHERE = re.compile(r"(?:[a-z]+:)?//", re.IGNORECASE)
_IN_STYLES = re.compile(r"""(?:url\(|@import)\s*['"]?((?:https?:)?//[^)'"]*)""")
_NOWHERE = "404.html"
"""The page that a server shows for a missing one; its links begin at the server's root."""


class _Seen(HTMLParser):
    """Collects what a page fetches and where it leads."""

    def __init__(self) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take in an element."""
        given = {name: value or "" for name, value in attrs}
        if tag in _FETCHED:
            self.fetched += [given[name] for name in ("src", "srcset", "data") if given.get(name)]
        elif tag == "link" and given.get("rel") not in ("canonical", "next", "prev"):
            self.fetched.append(given.get("href", ""))
        elif tag == "a" and given.get("href"):
            self.links.append(given["href"])


def faults(site: Path) -> Iterator[str]:
    """Yield what is wrong with the site, one line each."""
    pages = {str(file.relative_to(site)): _seen(file) for file in sorted(site.rglob("*.html"))}
    for name, seen in pages.items():
        for address in seen.fetched:
            if _ELSEWHERE.match(address):
                yield f"{name}: fetches {address}"
    for file in sorted(site.rglob("*.css")):
        for address in _IN_STYLES.findall(file.read_text("utf-8")):
            yield f"{file.relative_to(site)}: fetches {address}"
    del pages[_NOWHERE]
    leads = {name: set(_targets(name, seen)) for name, seen in pages.items()}
    for name, targets in leads.items():
        for target in sorted(targets):
            if not (site / target).is_file():
                yield f"{name}: leads to {target}, which is not there"
    for name in sorted(pages.keys() - near(leads, TUTORIAL)):
        yield f"{name}: more than {CLICKS} clicks from the tutorial"


def _seen(file: Path) -> _Seen:
    seen = _Seen()
    seen.feed(file.read_text("utf-8"))
    return seen


def _targets(page: str, seen: _Seen) -> Iterator[str]:
    """Yield the files of the site to which a page leads, by their names."""
    for link in seen.links:
        path = unquote(urldefrag(link).url)
        if path and not re.match(r"[a-z]+:|//", path):
            yield os.path.normpath(Path(page).parent / path)


def near(leads: Mapping[str, set[str]], first: str) -> set[str]:
    """Return the pages that are few clicks from the first one."""
    found = {first}
    for _ in range(CLICKS):
        found |= {target for page in found for target in leads.get(page, ())}
    return found


def main(folder: str) -> int:
    """Print what is wrong with the site in this folder; return the exit code."""
    found = list(faults(Path(folder)))
    print("\n".join(found) or f"{folder}: links lead somewhere, and nothing is fetched")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
