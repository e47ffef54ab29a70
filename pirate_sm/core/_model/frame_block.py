"""Many reports of boards at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from pirate_sm.core._model.events import SensorFrame


class Rows(Protocol):
    """Rows of values, as a list of lists or an array has them."""

    def __getitem__(self, at: int, /) -> Any:
        """Return a row."""


@dataclass(frozen=True, eq=False)
class FrameBlock:
    """Reports of boards that came one after the other, with nothing in between.

    Attributes:
        times_s: When each was received, in seconds since the run began; never decreasing.
        boards: Id of the board of each.
        values: The raw values of each, in a row; rows are as long as the longest report.
        widths: Number of values that a board reports, by its id.
    """

    times_s: Sequence[float]
    boards: Sequence[int]
    values: Rows
    widths: Mapping[int, int]

    def __len__(self) -> int:
        """Return how many reports there are."""
        return len(self.times_s)

    def frames(self) -> Iterator[tuple[float, SensorFrame]]:
        """Yield the time and the frame of each report, in order."""
        for at, now_s in enumerate(self.times_s):
            yield now_s, self.frame(at)

    def frame(self, at: int) -> SensorFrame:
        """Return one of the frames."""
        board = self.boards[at]
        return SensorFrame(board, tuple(map(float, self.values[at][: self.widths[board]])))
