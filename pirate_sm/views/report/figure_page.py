"""A page that loads no other file, with paragraphs, tables and plots."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from html import escape

from pirate_sm import __version__
from pirate_sm.views.drawing.svg.plot import Plot, plot_svg
from pirate_sm.views.report.report_page import page_style

_STYLE = """
.plot { width: 100%; max-width: 720px; height: auto; display: block; margin: 6px 0 10px; }
.plot text { font: 11px system-ui, sans-serif; fill: var(--soft); }
.plot .title { font-weight: 600; fill: var(--ink); }
.plot path { fill: none; }
.plot .grid { stroke: var(--grid); }
.plot .curve, .plot .sample { stroke-width: 1.6; }
.plot .dots { stroke-width: 3; stroke-linecap: round; opacity: 0.45; }
.plot .band { opacity: 0.18; stroke: none; }
.figures main { display: block; max-width: 1100px; }
.figures section { margin: 0 0 14px; }
.figures table { border-collapse: collapse; font-size: 13px; margin: 0 0 10px; }
.figures td, .figures th { padding: 3px 9px; text-align: left; vertical-align: top; }
.figures tr { border-bottom: 1px solid var(--border); }
.figures th { white-space: nowrap; }
.figures a { color: var(--path); }
.figures svg { max-width: 100%; height: auto; }
.figures .drawing .paper { fill: none; }
.wide { overflow-x: auto; }
.figures .heat :is(td, thead th) { text-align: center; }
.heat td { border: 1px solid var(--border); min-width: 90px; }
.heat small { display: block; color: var(--soft); }
.listing { margin: 0; padding: 0 0 0 3.4em; overflow-x: auto; }
.listing { font: 13px/1.5 ui-monospace, "DejaVu Sans Mono", monospace; }
.listing li { white-space: pre; scroll-margin-top: 30vh; }
.listing li::marker { color: var(--soft); }
.listing .error { background: var(--bad-box); }
.listing .warning, .listing .possible { padding: 0; border: 0; background: var(--late-box); }
.listing :target { outline: 2px solid var(--path); }
"""


@dataclass(frozen=True)
class FigureSection:
    """A part of the page.

    Attributes:
        title: Its heading.
        lines: Paragraphs.
        header: Of its table; empty for none.
        rows: Of its table.
        plots: Under it.
        markup: HTML after the paragraphs, in which all text is escaped already.
    """

    title: str
    lines: Sequence[str] = ()
    header: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    plots: Sequence[Plot] = field(default=())
    markup: str = ""


def figure_page(title: str, sections: Iterable[FigureSection]) -> str:
    """Return the page as HTML."""
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
    body = "\n".join(line for section in sections for line in _section(section))
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f'<meta name="generator" content="pirate-sm {escape(__version__)}">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        f'<link rel="icon" href="data:,">\n<title>{escape(title)}</title>\n'
        f'<style>{page_style()}{_STYLE}</style>\n</head>\n<body class="figures">\n'
        f"<header><h1>{escape(title)}</h1></header>\n<main>\n{body}\n</main>\n</body>\n</html>\n"
    )


def _section(section: FigureSection) -> Iterator[str]:
    yield f"<section><h2>{escape(section.title)}</h2>"
    for line in section.lines:
        yield f"<p>{escape(line)}</p>"
    if section.markup:
        yield section.markup
    if section.header:
        yield f"<table><thead>{_table_row('th', section.header)}</thead><tbody>"
        yield from (_table_row("td", row) for row in section.rows)
        yield "</tbody></table>"
    yield from map(plot_svg, section.plots)
    yield "</section>"


def _table_row(cell: str, texts: Iterable[str]) -> str:
    return f"<tr>{''.join(f'<{cell}>{escape(text)}</{cell}>' for text in texts)}</tr>"
