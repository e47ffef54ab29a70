"""A graph in Graphviz's language, for use of Graphviz's layouts."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.core.palette import DAY, EITHER
from pirate_sm.views.drawing.graph.graph import Edge, EdgeKind, Graph, Node, NodeKind
from pirate_sm.views.drawing.text_wrapping import INDENT, balanced, printable, wrapped

NODE_COLUMNS, LABEL_COLUMNS, NOTE_COLUMNS = 46, 28, 120


def _filled(role: str) -> str:
    """Return the attributes of a box in the colour of a role."""
    return f'style="rounded,filled", fillcolor="{DAY[f"{role}_box"]}", color="{EITHER[role]}"'


_SHAPES = {
    NodeKind.INITIAL: 'shape=point, width=0.15, label=""',
    NodeKind.ANYWHERE: 'style="rounded,dashed"',
    NodeKind.PHASE: 'style="rounded"',
    NodeKind.STATE: 'style="rounded"',
    NodeKind.SUCCEED: _filled("good"),
    NodeKind.FAIL: _filled("bad"),
}
_STYLES = {
    EdgeKind.WITHIN: ("dashed", EITHER["late"]),
    EdgeKind.FAILURE: ("dotted", EITHER["bad"]),
    EdgeKind.FAULT: ("dotted", EITHER["fault"]),
}
LEFT = r"\l"
"""The end of a left-aligned line."""


def dot(graph: Graph) -> str:
    """Return the graph as a ``digraph``; visited nodes have their numbers in parentheses."""
    title = _left([graph.title, *wrapped(graph.description, NOTE_COLUMNS)])
    notes = graph.note_lines(NOTE_COLUMNS)
    lines = [
        f"digraph {_quoted(graph.title)} {{",
        f"    graph [label={title}, labelloc=t, labeljust=l, fontname=monospace]",
        "    node [shape=box, fontname=monospace, fontsize=11]",
        "    edge [fontname=monospace, fontsize=10]",
    ]
    for number, cluster in enumerate(graph.clusters):
        nodes = [_node(node) for node in graph.nodes if node.cluster == cluster.id]
        if cluster.title:
            lines.append(f"    subgraph cluster_{number} {{")
            lines.append(f"        label={_quoted(cluster.title)}")
            lines += (f"        {node}" for node in nodes)
            lines.append("    }")
        else:
            lines += (f"    {node}" for node in nodes)
    lines += (f"    {_edge(edge)}" for edge in graph.edges)
    if notes:
        lines.append(f'    "(notes)" [shape=plaintext, label={_left(notes)}]')
    return "\n".join([*lines, "}", ""])


def _node(node: Node) -> str:
    attributes = [_SHAPES[node.kind]]
    if node.kind is not NodeKind.INITIAL:
        title = node.heading
        lines = [line for each in node.lines for line in wrapped(each, NODE_COLUMNS, INDENT)]
        attributes.append(f"label={_left([title, *lines]) if lines else _quoted(title)}")
    if node.visits:
        attributes.append("penwidth=3")
    if node.current:
        attributes.append("peripheries=2")
    if node.tooltip:
        attributes.append(f"tooltip={_quoted(node.tooltip)}")
    return f"{_quoted(node.id)} [{', '.join(attributes)}]"


def _edge(edge: Edge) -> str:
    found = ", ".join(_edge_attributes(edge))
    return f"{_quoted(edge.source)} -> {_quoted(edge.target)}{f' [{found}]' if found else ''}"


def _edge_attributes(edge: Edge) -> Iterator[str]:
    style, colour = _STYLES.get(edge.kind, ("", ""))
    if edge.label:
        yield f"label={_left(balanced(edge.label, LABEL_COLUMNS))}"
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
