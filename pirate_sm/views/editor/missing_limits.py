"""The time limits that waits of a mission lack, and where they would be written."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final, NamedTuple

from pirate_sm.core.documents import Document, YamlNode
from pirate_sm.views.editor.outline import end_of

_USUAL: Final = "60 s"
"""The limit that is written. [decided] The shipped missions wait that long for the detector."""


class MissingLimit(NamedTuple):
    """A time limit that is missing.

    Attributes:
        start: Where the wait begins in the text, and ``end`` where it ends.
        text: What is to be written after it.
    """

    start: int
    end: int
    text: str


def missing_limits(document: Document) -> Iterator[MissingLimit]:
    """Yield the time limits that are missing in a mission."""
    data, ends = document.data, _items(document.data.get("ends"))
    failing = [name for name, end in ends if isinstance(end, dict) and "fail" in end]
    known = [data.get("on_failure"), *failing, *dict(ends)]
    go = next((each for each in known if isinstance(each, str)), "end")
    node = document.root.child("phases")
    for name, _ in _items(data.get("phases")):
        found = node and node[0].child(name)
        if found:
            yield from _missing(document, found[0], f", go: {go}")


def _missing(document: Document, node: YamlNode, leads: str = "") -> Iterator[MissingLimit]:
    """Yield what is missing in a part of a phase; only its own wait must lead on."""
    waits, limit = node.child("wait"), node.child("within")
    triggers = _triggers(waits[0].value) if waits else []
    if waits and triggers and not limit and not any("after" in each for each in triggers):
        wait, _, column = waits
        end, within = end_of(document, wait), f"within: {{time: {_USUAL}{leads}}}"
        if document.text[node.start] == "{":
            yield MissingLimit(wait.start, end, f", {within}")
        else:
            rest = document.text[end:].partition("\n")[0].rstrip("\r")
            yield MissingLimit(wait.start, end + len(rest), f"\n{' ' * (column - 1)}{within}")
    inner = node.children or ()
    for each in [it for it, *_ in inner.values()] if isinstance(inner, dict) else inner:
        yield from _missing(document, each)


def _triggers(wait: Any) -> list[Any]:
    """Return the triggers of a wait, of which one may be written without brackets."""
    return [each for each in (wait if isinstance(wait, list) else [wait]) if isinstance(each, dict)]


def _items(mapping: Any) -> list[tuple[str, Any]]:
    return [*mapping.items()] if isinstance(mapping, dict) else []
