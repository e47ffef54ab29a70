"""The protocol of a recorder of a session's runs."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Protocol

from pirate_sm.companion import Companion
from pirate_sm.runtime.loop import MissionRun
from pirate_sm.runtime.observers import Tap
from pirate_sm.wiring import Prepared


class RunKeeper(Protocol):
    """Records one run, or not.

    Attributes:
        prepared: The run, with notices about its recording.
        tap: The tap that records it; None without a recording.
        companions: The recorder's companions.
    """

    @property
    def prepared(self) -> Prepared:
        """The run."""
        ...

    @property
    def tap(self) -> Tap | None:
        """The tap that records it; None without a recording."""
        ...

    @property
    def companions(self) -> tuple[Companion, ...]:
        """The recorder's companions."""
        ...

    def follow(self, run: MissionRun) -> None:
        """Show viewers this run."""
        ...

    def forget(self) -> None:
        """Discard the recording of this run, because the operator requested nothing in it."""
        ...


@dataclass(frozen=True)
class NoKeeper:
    """A run without a recording."""

    prepared: Prepared
    tap: Tap | None = None
    companions: tuple[Companion, ...] = ()

    def follow(self, run: MissionRun) -> None:
        """Do nothing."""

    def forget(self) -> None:
        """Do nothing."""


def unkept(prepared: Prepared) -> AbstractContextManager[RunKeeper]:
    """Return the run without a recording."""
    return nullcontext(NoKeeper(prepared))
