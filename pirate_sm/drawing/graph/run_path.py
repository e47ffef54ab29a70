"""The path of a run through its mission, taken from its effects."""

from __future__ import annotations

from collections.abc import Sequence

from pirate_sm.drawing.graph.graph import EdgeKind
from pirate_sm.drawing.graph.highlight import Stop
from pirate_sm.model import effects as fx


class RunPath:
    """Records the phases that a run reaches, and by which kind of edge.

    Attributes:
        stops: For :func:`pirate_sm.drawing.graph.highlight.highlight`.
    """

    def __init__(self) -> None:
        self.stops: list[Stop] = []
        self._here = ""
        self._kind: EdgeKind | None = None

    def see(self, effects: Sequence[fx.Effect], now_s: float) -> None:
        """Note the phases and the end that the effects reach."""
        for effect in effects:
            match effect:
                case fx.PhaseChange(phase=phase):
                    self._reach(phase)
                case fx.Ended(end=end) if end:
                    self._reach(end)
                case fx.TriggerFired(trigger=trigger):
                    self._kind = EdgeKind.WITHIN if trigger == "within" else EdgeKind.TRIGGER
                case fx.CommandStatus(status="failed" | "refused"):
                    self._kind = EdgeKind.FAILURE
                case fx.Fault(handling=handling) if handling != "continue":
                    self._kind = EdgeKind.FAULT
                case fx.CommandStatus(status="sent" | "skipped"):
                    self._kind = None
                case _:
                    pass

    def _reach(self, name: str) -> None:
        if self._here and self._kind is not None:
            self.stops.append((self._here, name, self._kind))
        else:
            self.stops.append(name)
        self._here, self._kind = name, None
