"""A page of headings, paragraphs, tables and drawings, written as Markdown or as HTML."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from typing import NamedTuple, TypeAlias, assert_never

from pirate_sm import __version__
from pirate_sm.views.drawing.graph.graph import Graph
from pirate_sm.views.drawing.svg.svg_writer import svg
from pirate_sm.views.drawing.text_formats.mermaid import mermaid
from pirate_sm.views.drawing.text_wrapping import printable


class Heading(NamedTuple):
    """A heading; the page's own has level 1."""

    level: int
    text: str


class Paragraph(NamedTuple):
    """A paragraph; ``lead`` is its bold beginning."""

    text: str
    lead: str = ""


class PageTable(NamedTuple):
    """Rows with as many cells as the header; an empty header is not shown."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]


class Drawing(NamedTuple):
    """A graph."""

    graph: Graph


class PagePicture(NamedTuple):
    """A picture as SVG, and as lines of text for pages that cannot show it."""

    svg: str
    text: str


Block: TypeAlias = Heading | Paragraph | PageTable | Drawing | PagePicture

_STYLE = """
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; margin: 1rem 0; }
th, td { border: 1px solid #8888; padding: .3rem .6rem; text-align: left; vertical-align: top; }
figure { margin: 1rem 0; overflow-x: auto; }
"""


def markdown(blocks: Sequence[Block], note: str = "") -> str:
    """Return the page as Markdown, with graphs in Mermaid and pictures in text.

    Args:
        blocks: The page.
        note: A comment in the source of the page.
    """
    texts = [_markdown(block) for block in blocks]
    if note:
        texts.insert(1, f"<!-- {note} -->")
    return "\n\n".join(texts) + "\n"


def _markdown(block: Block) -> str:
    match block:
        case Heading():
            return f"{'#' * block.level} {_marked(block.text)}"
        case Paragraph():
            lead = f"**{_marked(block.lead)}** " if block.lead else ""
            return lead + _marked(block.text)
        case PageTable():
            lines = [block.header, ["---"] * len(block.header), *block.rows]
            return "\n".join(
                f"| {' | '.join(cell if row == 1 else _marked(cell) for cell in cells)} |"
                for row, cells in enumerate(lines)
            )
        case Drawing():
            return f"```mermaid\n{mermaid(block.graph)}```"
        case PagePicture():
            return f"```text\n{block.text}\n```"
    assert_never(block)


def html(blocks: Sequence[Block]) -> str:
    """Return the page as one HTML file without external resources, with pictures in SVG."""
    title = next((block.text for block in blocks if isinstance(block, Heading)), "")
    return "\n".join(
        [
            "<!DOCTYPE html>",
            '<html lang="en"><head><meta charset="utf-8">',
            f'<meta name="generator" content="pirate-sm {escape(__version__)}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{_text(title)}</title><style>{_STYLE}</style></head><body>",
            *(_html(block) for block in blocks),
            "</body></html>",
            "",
        ]
    )


def _html(block: Block) -> str:
    match block:
        case Heading():
            return f"<h{block.level}>{_text(block.text)}</h{block.level}>"
        case Paragraph():
            lead = f"<b>{_text(block.lead)}</b> " if block.lead else ""
            return f"<p>{lead}{_text(block.text)}</p>"
        case PageTable():
            return "\n".join(["<table>", *_rows(block), "</table>"])
        case Drawing():
            return f"<figure>{svg(block.graph)}</figure>"
        case PagePicture():
            return f"<figure>{block.svg}</figure>"
    assert_never(block)


def _rows(table: PageTable) -> Iterator[str]:
    if any(table.header):
        yield f"<tr>{''.join(f'<th>{_text(cell)}</th>' for cell in table.header)}</tr>"
    for row in table.rows:
        yield f"<tr>{''.join(f'<td>{_text(cell)}</td>' for cell in row)}</tr>"


def _text(text: str) -> str:
    return escape(printable(" ".join(text.split())))


def _marked(text: str) -> str:
    """Return the text on one line, with all characters of Markdown's markup escaped."""
    line = printable(" ".join(text.split()))
    return "".join(f"\\{each}" if each in "\\|<*`[]" else each for each in line)
