"""What shows that a state, a signal or a place is so: the source, the time and the connection.

The evidence of a signal of a board is that board's last report; nothing is stored for it. Only what
outlives a report has evidence of its own. The age is computed when somebody asks for it.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isnan, nan
from typing import Literal, NamedTuple, TypeAlias

Source: TypeAlias = Literal["sensor", "echo", "person", "assumption", "nothing"]
"""What has shown something. An echo shows that an array has arrived, never what it has moved."""

SHOWN: Mapping[Source, str] = {
    "sensor": "shown by sensors",
    "echo": "setpoints confirmed",
    "person": "declared",
    "assumption": "assumed",
    "nothing": "shown by nothing",
}
"""How each source has shown something, for people."""


class Evidence(NamedTuple):
    """The evidence of one state, signal or place.

    Attributes:
        at_s: When it was shown, by the engine's clock; NaN if nothing has shown it.
        connection: In which connection, see :attr:`.Sensing.connection`.
    """

    source: Source
    at_s: float
    connection: int

    def age_s(self, now_s: float) -> float:
        """Return how old it is, s; NaN if nothing has shown it."""
        return now_s - self.at_s

    def in_words(self, now_s: float) -> str:
        """Return it for people, with its age."""
        ago = "" if isnan(self.at_s) else f" {self.age_s(now_s):.1f} s ago"
        return f"{SHOWN[self.source]}{ago}"


NOTHING = Evidence("nothing", nan, 0)
"""Nothing has shown it."""
