"""Hooks of MkDocs: pages that stand in no Markdown file, and links to files of the repository.

The pages in ``docs`` are also read in viewers of repositories, so they link to files and folders of
the repository and indent lists by as much as the marker is wide. Both are translated here.
"""

from __future__ import annotations

import posixpath
import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from website import generated, markdown, repository_files  # noqa: E402 - found by the line above

_ROLE = re.compile(r":(?:attr|class|data|exc|func|meth|mod):(?=<code>)")

FOLDER = "/*"
"""The end of a name in ``nav`` that stands for all pages of a folder."""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages and those of linked files; fill in the folders of ``nav``."""
    for name, text in generated.pages():
        files.append(File.generated(config, name, content=text))
    written = [each for each in files if each.is_documentation_page()]
    for name, text in repository_files.pages(
        {each.src_uri: each.content_string for each in written}
    ):
        files.append(File.generated(config, name, content=text))
    names = sorted(each.src_uri for each in files if each.is_documentation_page())
    config.nav = list(_filled(config.nav or [], names))
    return files


def on_page_markdown(text: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Translate what viewers of repositories and MkDocs understand differently."""
    if page.file.src_uri.startswith("robots/"):
        text = generated.with_drawings(text, page.file.src_uri)
    return markdown.for_site(repository_files.relinked(text, page.file.src_uri))


def on_page_content(html: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Take the roles of docstrings away, as in ``:meth:`Session.advance```."""
    return _ROLE.sub("", html) if page.file.src_uri.startswith("api/") else html


def _filled(entries: list[Any], names: list[str]) -> Iterator[Any]:
    """Yield the entries of ``nav`` with the pages of each folder instead of its name."""
    for entry in entries:
        if isinstance(entry, Mapping):
            yield {
                title: list(_filled(below, names)) if isinstance(below, list) else below
                for title, below in entry.items()
            }
        elif entry.endswith(FOLDER):
            folder = entry.removesuffix(FOLDER)
            yield from (
                name
                for name in names
                if posixpath.dirname(name) == folder and posixpath.basename(name) != "index.md"
            )
        else:
            yield entry
