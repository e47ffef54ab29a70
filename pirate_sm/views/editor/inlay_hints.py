"""Hints next to the text: quantities in SI units, and when a phase is reached."""

from __future__ import annotations

from collections.abc import Iterator

from lsprotocol.types import InlayHint

from pirate_sm.core.documents import Document
from pirate_sm.core.units import QuantityError, parse_quantity, unit_of
from pirate_sm.views.editor.expression_tokens import Leaf, leaves
from pirate_sm.views.editor.hover import times
from pirate_sm.views.editor.known_mission import KnownMission
from pirate_sm.views.editor.positions import Positions


def hints(
    document: Document, positions: Positions, known: KnownMission | None, begin: int, end: int
) -> Iterator[InlayHint]:
    """Yield the hints in a part of a file.

    Args:
        document: The file.
        positions: The positions in it.
        known: The mission that it is, if its text is that which is known.
        begin: Where the part begins, an index of the text.
        end: Where it ends.
    """
    for leaf in leaves(document):
        for start, text in _quantities(leaf) if begin <= leaf.start <= end else ():
            if said := _in_si(text):
                yield InlayHint(positions.at(start + len(text)), said, padding_left=True)
    found = document.root.child("phases") if known else None
    phases = found[0].children if found else None
    for name, (_, line, column) in phases.items() if isinstance(phases, dict) else ():
        at = positions.index(line, column) + len(name)
        if known and begin <= at <= end:
            yield InlayHint(positions.at(at), times(known, name), padding_left=True)


def _quantities(leaf: Leaf) -> Iterator[tuple[int, str]]:
    """Yield where the numbers of a text begin, each with its unit."""
    found = [each for each in leaf.tokens if each.quantity is not None]
    yield from ((leaf.start + each.offset, each.text) for each in found)
    if not leaf.tokens:
        yield leaf.start, leaf.text.rstrip()


def _in_si(text: str) -> str:
    """Return a quantity in its SI unit; empty for one that has that or none, and other texts."""
    try:
        quantity = parse_quantity(text)
    except QuantityError:
        return ""
    unit = unit_of(quantity.dimension)
    same = text.lstrip("+-.0123456789eE ") == unit
    return "" if same else f"= {quantity.value:.4g} {unit}".rstrip()
