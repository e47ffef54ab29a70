"""Identifiers of nodes and clusters that every graph language accepts."""

from __future__ import annotations

import re
from collections.abc import Iterable


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
