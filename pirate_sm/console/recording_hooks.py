"""What a session asks of whoever records its runs."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Protocol

from pirate_sm.companion import Companion
from pirate_sm.runtime.loop import MissionRun
from pirate_sm.runtime.observers import Tap
from pirate_sm.wiring import Prepared


class RunKeeper(Protocol):
    """How one run is recorded, or not.

    Attributes:
        prepared: The run, with what is to be said of its recording.
        tap: Who keeps it; None where nobody does.
        companions: Who stands beside the mission for it.
    """

    @property
    def prepared(self) -> Prepared:
        """The run."""
        ...

    @property
    def tap(self) -> Tap | None:
        """Who keeps it."""
        ...

    @property
    def companions(self) -> tuple[Companion, ...]:
        """Who stands beside the mission for it."""
        ...

    def follow(self, run: MissionRun) -> None:
        """Show viewers this run."""
        ...

    def forget(self) -> None:
        """Leave no recording of it, for nothing was asked for in it."""
        ...


@dataclass(frozen=True)
class NoKeeper:
    """A run that nobody records."""

    prepared: Prepared
    tap: Tap | None = None
    companions: tuple[Companion, ...] = ()

    def follow(self, run: MissionRun) -> None:
        """Do nothing: nobody looks."""

    def forget(self) -> None:
        """Do nothing: there is no recording."""


def unkept(prepared: Prepared) -> AbstractContextManager[RunKeeper]:
    """Return the run without a recording."""
    return nullcontext(NoKeeper(prepared))
