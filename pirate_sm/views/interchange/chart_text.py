"""The text of a chart file from its data."""

from __future__ import annotations

from typing import Any

import yaml

from pirate_sm.core.visible import visible


def chart_text(data: dict[str, Any], source: str) -> str:
    """Return the data of a chart as the text of its file.

    Args:
        data: The data, as a chart file has them.
        source: Where they are from, for people.
    """
    text = yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=100)
    return f"# Made from {visible(source)} by `pirate import`.\n{text}"
