"""A graph as a Mermaid flowchart, for pages that draw Mermaid: GitHub, GitLab, many wikis.

It is a flowchart, not a state diagram, because only its labels may contain every character.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping

from pirate_sm.core.palette import EITHER
from pirate_sm.views.drawing.graph.graph import Cluster, Edge, EdgeKind, Graph, Node, NodeKind
from pirate_sm.views.drawing.text_wrapping import balanced, printable


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


LABEL_COLUMNS, NOTE_COLUMNS = 28, 100
BLANK = "#nbsp;"

_SHAPES = {
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
    lines += (f"    {_edge(edge, names)}" for edge in graph.edges)
    for number, edge in enumerate(graph.edges):
        style = _link_style(edge)
        if style:
            lines.append(f"    linkStyle {number} {style}")
    lines += (f"    {each}" for each in _CLASSES)
    lines += (
        f"    class {names[node.id]} {name}" for node in graph.nodes for name in _class_names(node)
    )
    if graph.notes:
        text = "<br/>".join(map(_escaped, graph.note_lines(NOTE_COLUMNS)))
        lines.append(f'    notes["{text}"]')
        lines.append("    class notes anywhere")
    return "\n".join([*lines, ""])


def _cluster(graph: Graph, cluster: Cluster, name: str, names: Mapping[str, str]) -> Iterator[str]:
    nodes = [_node(node, names[node.id]) for node in graph.nodes if node.cluster == cluster.id]
    if not cluster.title:
        yield from (f"    {node}" for node in nodes)
        return
    yield f'    subgraph {name}["{_escaped(cluster.title)}"]'
    yield from (f"        {node}" for node in nodes)
    yield "    end"


def _node(node: Node, name: str) -> str:
    opening, closing = _SHAPES[node.kind]
    if node.kind is NodeKind.INITIAL:
        return f'{name}{opening}" "{closing}'
    text = "<br/>".join(
        [f"<b>{_escaped(node.heading)}</b>", *(_escaped(line, indent=True) for line in node.lines)]
    )
    return f'{name}{opening}"{text}"{closing}'


def _edge(edge: Edge, names: Mapping[str, str]) -> str:
    arrow = "==>" if edge.taken else "-->"
    label = "<br/>".join(_escaped(line) for line in balanced(edge.label, LABEL_COLUMNS))
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
