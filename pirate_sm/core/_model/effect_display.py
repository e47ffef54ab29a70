"""What views show of an effect: each class of effects declares it in one place."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, NamedTuple, TypeAlias, TypeVar

Level: TypeAlias = Literal["info", "warning", "error"]
SpanKind: TypeAlias = Literal[
    "phase", "state", "unconfirmed", "done", "failed", "open", "wait", "word", "question"
]
MarkKind: TypeAlias = Literal[
    "trigger", "fault", "error", "warning", "skipped", "refused", "operator", "end"
]

_Effect = TypeVar("_Effect", bound=tuple[Any, ...])


class LaneSpan(NamedTuple):
    """An interval that an effect begins on a lane of the timeline, which ends the one before.

    Attributes:
        lane: Name of the lane.
        text: What is written there; empty: no interval begins.
        kind: What it looks like.
        about: Details, shown on hovering.
    """

    lane: str
    text: str
    kind: SpanKind
    about: str = ""


class LaneMark(NamedTuple):
    """A mark that an effect sets on a lane of the timeline; attributes as of an interval."""

    lane: str
    text: str
    kind: MarkKind
    about: str = ""


class Display(NamedTuple):
    """What views show of one effect.

    Attributes:
        kind: Type of its JSON line; empty: it has none.
        text: The effect in words, after its topic. Empty: it has no line, or one that depends on
            what came before.
        topic: What the line is about, in a word; empty: the kind.
        level: How much it matters; None: too little for a log.
        entry: What it puts on the timeline.
        rows: Its rows in its table; None: one row with its fields.
        fields: What its JSON line says; None: its fields.
    """

    kind: str = ""
    text: str = ""
    topic: str = ""
    level: Level | None = "info"
    entry: LaneSpan | LaneMark | None = None
    rows: Sequence[tuple[Any, ...]] | None = None
    fields: Mapping[str, Any] | None = None

    @property
    def about(self) -> str:
        """Return what its line is about, in a word."""
        return self.topic or self.kind


EFFECT_TABLES: dict[type[Any], tuple[str, tuple[str, ...]]] = {}
"""The table of each class of effects that has one: its name and its columns."""


def with_table(name: str, *columns: str) -> Callable[[type[_Effect]], type[_Effect]]:
    """Declare the table of a class of effects; its columns are by default the fields."""

    def declare(effect: type[_Effect]) -> type[_Effect]:
        EFFECT_TABLES[effect] = name, columns or effect._fields  # type: ignore[attr-defined]
        return effect

    return declare


def with_reason(text: str, reason: str) -> str:
    """Return the text, followed by a colon and the reason if there is one."""
    return f"{text}: {reason}" if reason else text
