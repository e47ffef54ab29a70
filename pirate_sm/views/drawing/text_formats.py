"""Graphs as text in other languages: Graphviz's, and Mermaid for GitHub, GitLab and many wikis."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping

from pirate_sm.core.palette import DAY, EITHER
from pirate_sm.views.drawing.graph.graph import Cluster, Edge, EdgeKind, Graph, Node, NodeKind
from pirate_sm.views.drawing.wrapping import INDENT, balanced, printable, wrapped

# --- Graphviz -----------------------------------------------------------------------------------


_DOT_NODE_COLUMNS, _DOT_LABEL_COLUMNS, _DOT_NOTE_COLUMNS = 46, 28, 120


def _filled(role: str) -> str:
    """Return the attributes of a box in the colour of a role."""
    return f'style="rounded,filled", fillcolor="{DAY[f"{role}_box"]}", color="{EITHER[role]}"'


_DOT_SHAPES = {
    NodeKind.INITIAL: 'shape=point, width=0.15, label=""',
    NodeKind.ANYWHERE: 'style="rounded,dashed"',
    NodeKind.PHASE: 'style="rounded"',
    NodeKind.STATE: 'style="rounded"',
    NodeKind.SUCCEED: _filled("good"),
    NodeKind.FAIL: _filled("bad"),
}
_DOT_STYLES = {
    EdgeKind.WITHIN: ("dashed", EITHER["late"]),
    EdgeKind.FAILURE: ("dotted", EITHER["bad"]),
    EdgeKind.FAULT: ("dotted", EITHER["fault"]),
}
LEFT = r"\l"
"""The end of a left-aligned line."""


def dot(graph: Graph) -> str:
    """Return the graph as a ``digraph``; visited nodes have their numbers in parentheses."""
    title = _left([graph.title, *wrapped(graph.description, _DOT_NOTE_COLUMNS)])
    notes = graph.note_lines(_DOT_NOTE_COLUMNS)
    lines = [
        f"digraph {_quoted(graph.title)} {{",
        f"    graph [label={title}, labelloc=t, labeljust=l, fontname=monospace]",
        "    node [shape=box, fontname=monospace, fontsize=11]",
        "    edge [fontname=monospace, fontsize=10]",
    ]
    for number, cluster in enumerate(graph.clusters):
        nodes = [_dot_node(node) for node in graph.nodes if node.cluster == cluster.id]
        if cluster.title:
            lines.append(f"    subgraph cluster_{number} {{")
            lines.append(f"        label={_quoted(cluster.title)}")
            lines += (f"        {node}" for node in nodes)
            lines.append("    }")
        else:
            lines += (f"    {node}" for node in nodes)
    lines += (f"    {_dot_edge(edge)}" for edge in graph.edges)
    if notes:
        lines.append(f'    "(notes)" [shape=plaintext, label={_left(notes)}]')
    return "\n".join([*lines, "}", ""])


def _dot_node(node: Node) -> str:
    attributes = [_DOT_SHAPES[node.kind]]
    if node.kind is not NodeKind.INITIAL:
        title = node.heading
        lines = [line for each in node.lines for line in wrapped(each, _DOT_NODE_COLUMNS, INDENT)]
        attributes.append(f"label={_left([title, *lines]) if lines else _quoted(title)}")
    if node.visits:
        attributes.append("penwidth=3")
    if node.current:
        attributes.append("peripheries=2")
    if node.tooltip:
        attributes.append(f"tooltip={_quoted(node.tooltip)}")
    return f"{_quoted(node.id)} [{', '.join(attributes)}]"


def _dot_edge(edge: Edge) -> str:
    found = ", ".join(_edge_attributes(edge))
    return f"{_quoted(edge.source)} -> {_quoted(edge.target)}{f' [{found}]' if found else ''}"


def _edge_attributes(edge: Edge) -> Iterator[str]:
    style, colour = _DOT_STYLES.get(edge.kind, ("", ""))
    if edge.label:
        yield f"label={_left(balanced(edge.label, _DOT_LABEL_COLUMNS))}"
    if edge.tooltip:
        yield f"tooltip={_quoted(edge.tooltip)}, labeltooltip={_quoted(edge.tooltip)}"
    if style:
        yield f"style={style}"
    if edge.taken:
        yield f'color="{EITHER["path"]}", penwidth=3'
    elif colour:
        yield f'color="{colour}"'


def _left(lines: list[str] | tuple[str, ...]) -> str:
    """Return the lines as one quoted string, each left-aligned."""
    text = "".join(_inside(line) + LEFT for line in lines)
    return f'"{text}"'


def _quoted(text: str) -> str:
    return f'"{_inside(text)}"'


def _inside(text: str) -> str:
    """Return the text for use within quotes, without escapes and entities."""
    blanks = len(text) - len(text.lstrip(" "))
    flat = "\N{NO-BREAK SPACE}" * blanks + " ".join(printable(text).split())
    return flat.replace("\\", "\\\\").replace('"', '\\"').replace("&", "&amp;")


# --- Mermaid ------------------------------------------------------------------------------------


def plain_names(ids: Iterable[str], prefix: str) -> dict[str, str]:
    """Return a different name of ASCII letters, digits and underscores for each id.

    The prefix keeps them distinct from a language's reserved words.
    """
    names: dict[str, str] = {}
    used: set[str] = set()
    for each in ids:
        stem = f"{prefix}_{re.sub(r'[^A-Za-z0-9]+', '_', each).strip('_')}"
        name, number = stem, 2
        while name in used:
            name, number = f"{stem}_{number}", number + 1
        used.add(name)
        names[each] = name
    return names


_MERMAID_LABEL_COLUMNS, _MERMAID_NOTE_COLUMNS = 28, 100
BLANK = "#nbsp;"

_MERMAID_SHAPES = {
    NodeKind.INITIAL: ("((", "))"),
    NodeKind.ANYWHERE: ("[", "]"),
    NodeKind.PHASE: ("[", "]"),
    NodeKind.STATE: ("(", ")"),
    NodeKind.SUCCEED: ("([", "])"),
    NodeKind.FAIL: ("([", "])"),
}
_DASHES = {EdgeKind.WITHIN: "7 4", EdgeKind.FAILURE: "1 4", EdgeKind.FAULT: "9 4 1 4"}
_CLASSES = (
    "classDef anywhere stroke-dasharray:4 3",
    f"classDef succeed stroke:{EITHER['good']},stroke-width:2px",
    f"classDef fail stroke:{EITHER['bad']},stroke-width:2px",
    f"classDef visited stroke:{EITHER['path']},stroke-width:4px",
)


def mermaid(graph: Graph) -> str:
    """Return the graph as a flowchart; visited nodes have their numbers in parentheses."""
    names = plain_names((node.id for node in graph.nodes), "n")
    clusters = plain_names((cluster.id for cluster in graph.clusters), "c")
    lines = ["---", f"title: {_yaml(graph.title)}", "---", "flowchart TD"]
    for cluster in graph.clusters:
        lines += _cluster(graph, cluster, clusters[cluster.id], names)
    lines += (f"    {_mermaid_edge(edge, names)}" for edge in graph.edges)
    for number, edge in enumerate(graph.edges):
        style = _link_style(edge)
        if style:
            lines.append(f"    linkStyle {number} {style}")
    lines += (f"    {each}" for each in _CLASSES)
    lines += (
        f"    class {names[node.id]} {name}" for node in graph.nodes for name in _class_names(node)
    )
    if graph.notes:
        text = "<br/>".join(map(_escaped, graph.note_lines(_MERMAID_NOTE_COLUMNS)))
        lines.append(f'    notes["{text}"]')
        lines.append("    class notes anywhere")
    return "\n".join([*lines, ""])


def _cluster(graph: Graph, cluster: Cluster, name: str, names: Mapping[str, str]) -> Iterator[str]:
    nodes = [
        _mermaid_node(node, names[node.id]) for node in graph.nodes if node.cluster == cluster.id
    ]
    if not cluster.title:
        yield from (f"    {node}" for node in nodes)
        return
    yield f'    subgraph {name}["{_escaped(cluster.title)}"]'
    yield from (f"        {node}" for node in nodes)
    yield "    end"


def _mermaid_node(node: Node, name: str) -> str:
    opening, closing = _MERMAID_SHAPES[node.kind]
    if node.kind is NodeKind.INITIAL:
        return f'{name}{opening}" "{closing}'
    text = "<br/>".join(
        [f"<b>{_escaped(node.heading)}</b>", *(_escaped(line, indent=True) for line in node.lines)]
    )
    return f'{name}{opening}"{text}"{closing}'


def _mermaid_edge(edge: Edge, names: Mapping[str, str]) -> str:
    arrow = "==>" if edge.taken else "-->"
    label = "<br/>".join(_escaped(line) for line in balanced(edge.label, _MERMAID_LABEL_COLUMNS))
    middle = f'|"{label}"|' if label else ""
    return f"{names[edge.source]} {arrow}{middle} {names[edge.target]}"


def _link_style(edge: Edge) -> str:
    dashes = _DASHES.get(edge.kind)
    styles = [f"stroke-dasharray:{dashes}"] if dashes else []
    if edge.taken:
        styles.append(f"stroke:{EITHER['path']},stroke-width:4px")
    return ",".join(styles)


def _class_names(node: Node) -> Iterator[str]:
    if node.kind in {NodeKind.ANYWHERE, NodeKind.SUCCEED, NodeKind.FAIL}:
        yield node.kind.value
    if node.visits:
        yield "visited"


def _escaped(text: str, *, indent: bool = False) -> str:
    """Return the text with every special character as its number."""
    bare = text.lstrip(" ")
    blanks = BLANK * (len(text) - len(bare)) if indent else ""
    return blanks + "".join(
        character if character.isalnum() or character in " _,.:()=✓✗“”≤…" else f"#{ord(character)};"
        for character in " ".join(printable(bare).split())
    )


def _yaml(text: str) -> str:
    inside = " ".join(printable(text).split()).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{inside}"'
