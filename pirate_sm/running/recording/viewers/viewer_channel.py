"""Topics for viewers: Foxglove's own message types, and flat topics that can be plotted."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from pirate_sm.running.recording.format.engine_topics import DIALECT

NS_PER_S = 1_000_000_000
NUMBER = {"type": "number"}
WORD = {"type": "string"}


@dataclass(frozen=True, eq=False)
class ViewerChannel:
    """A topic for viewers."""

    topic: str
    schema_name: str
    schema: Mapping[str, Any]


Message = tuple[ViewerChannel, bytes]


def flat(topic: str, columns: Mapping[str, Any]) -> ViewerChannel:
    """Return a topic of plain columns."""
    name = f"pirate_sm{topic.replace('/', '.')}"
    schema = {"$schema": DIALECT, "title": name, "type": "object", "properties": dict(columns)}
    return ViewerChannel(topic, name, schema)


def foxglove(topic: str, name: str) -> ViewerChannel:
    """Return a topic of one of Foxglove's types; their schemas are beside this module."""
    title = f"foxglove.{name}"
    file = files("pirate_sm.running.recording.viewers") / "foxglove_schemas" / f"{title}.json"
    return ViewerChannel(topic, title, json.loads(file.read_text("utf-8")))


def stamp(time_ns: int) -> str:
    """Return the time as JSON in Foxglove's format."""
    seconds, rest = divmod(time_ns, NS_PER_S)
    return f'{{"sec":{seconds},"nsec":{rest}}}'
