"""What a backend's factory returns, and what a run is made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from pirate_sm.companion import Companion
from pirate_sm.detectors.registry import Places
from pirate_sm.engine.engine import Engine
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.model.true_position import Truth
from pirate_sm.wiring.run_order import Order

if TYPE_CHECKING:
    from pirate_sm.backends.protocol import Backend
    from pirate_sm.backends.serial.health import LinkHealth

Say = Callable[[str], None]
"""Takes what a person should know while something takes longer than a moment."""


@dataclass(frozen=True, kw_only=True)
class Equipment:
    """A backend that has not been opened, with all that belongs to it.

    Attributes:
        backend: The backend.
        loaded: The mission, where the backend changes it (a robot's zeros); None: as it was loaded.
        companions: Who must be beside the mission for this backend.
        notices: What a person must know before they see the run.
        usual_detector: Who says the detector's words where nobody is asked for; None: this backend
            takes no detector at all.
        places: Where the bends and the wheels really are along the pipe, for a detector; None
            where nobody knows.
        truth: Where the robot really is, for backends that know.
        wheels: The same of its wheels alone, in the plane of the pipe, m, for whoever asks often.
        link: How the link is, where there is one.
        parting: What a person must do once the run has ended; empty: nothing.
        confirmation: What a person must agree to before anything moves; empty: nothing.
        attended: Whether a companion answers the mission's questions.
        adapted: Returns another mission for the same robot as the backend changes every mission
            (a robot's zeros).
    """

    backend: Backend
    loaded: LoadedMission | None = None
    companions: tuple[Companion, ...] = ()
    notices: tuple[str, ...] = ()
    usual_detector: str | None = None
    places: Places | None = None
    truth: Callable[[], Truth] | None = None
    wheels: Callable[[], tuple[tuple[float, float], ...]] | None = None
    link: Callable[[], LinkHealth] | None = None
    parting: Callable[[], str] = lambda: ""
    confirmation: str = ""
    attended: bool = False
    adapted: Callable[[LoadedMission], LoadedMission] = lambda loaded: loaded


class MakeBackend(Protocol):
    """What the entry point of a backend makes it with; see ``docs/extending.md``."""

    def __call__(self, order: Order, loaded: LoadedMission, say: Say) -> Equipment:
        """Return the backend that the order wants, not opened; nothing has moved.

        Raises:
            UsageError: The order does not fit the backend, or something is not installed.
        """
        ...


@dataclass(frozen=True, kw_only=True)
class Prepared(Equipment):
    """Everything that a run needs; nothing has moved.

    Attributes:
        reckoned: Where a detector takes the robot to be, where one does; None before it knows.
        detector: Who says the detector's words; ``operator`` still wants a keyboard.
    """

    order: Order
    loaded: LoadedMission
    engine: Engine
    reckoned: Callable[[], Truth | None] | None = None
    detector: str = "none"
