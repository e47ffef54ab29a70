"""The order of a run, the equipment that a backend's factory returns, and the prepared run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Protocol

from pirate_sm.core import library
from pirate_sm.core.companion import Companion
from pirate_sm.core.engine import Engine
from pirate_sm.core.events import InSpace, Truth
from pirate_sm.core.loading import LoadedMission, LoadedRobot
from pirate_sm.core.models import LineFaults
from pirate_sm.core.options import GivenOptions
from pirate_sm.robot.backends.trace_script import Happening
from pirate_sm.robot.control_panel.panel_file import Panel, load_panel
from pirate_sm.robot.control_panel.panel_reader import EndRun, PanelReader
from pirate_sm.robot.detectors.registry import NOBODY, Detecting, Places
from pirate_sm.robot.detectors.vision_detector import CameraView
from pirate_sm.running.runtime.scripted_events import Firing
from pirate_sm.simulation.standing import Standing

if TYPE_CHECKING:
    from pirate_sm.robot.backends.protocol import Backend
    from pirate_sm.robot.backends.serial.link.health import LinkHealth
    from pirate_sm.robot.diagnosis.listening import OpenLink
    from pirate_sm.running.recording.format.header import RunHeader
    from pirate_sm.running.runtime.phase_times import ForecastWatch


# --- the order ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Order(GivenOptions):
    """The order of a run: its mission, the options that were given, and what belongs to a backend.

    Attributes:
        firings: Triggers that a trace fires instead of the first trigger of each wait.
        course: All events of a trace, in order.
        line: Faults of the line to the emulated bay; None: none.
        put_back: The pose of a simulated robot that is put back; None: as its mission begins.
        breakpoints: Where the mission pauses, each as ``PHASE``, ``LINE`` or ``FILE:LINE``.
    """

    firings: tuple[Firing, ...] = ()
    course: tuple[Happening, ...] = ()
    line: LineFaults | None = None
    put_back: Standing | None = None
    breakpoints: tuple[str, ...] = ()


# --- the panel ------------------------------------------------------------------------------------


class ChosenPanel(NamedTuple):
    """The control panel of a run.

    Attributes:
        panel: The panel, whose names the robot has.
        device: Its device, if the user has named one.
    """

    panel: Panel
    device: Path | None

    def reader(self, end_run: EndRun) -> PanelReader:
        """Return the reader of the panel, unopened, which ends the run by this function."""
        return PanelReader(self.panel, self.device, end_run)


def choose_panel(text: str, robot: LoadedRobot) -> ChosenPanel:
    """Return the panel in ``NAME`` or ``NAME:DEVICE``; a name may also be the path of a file.

    Raises:
        LoadError: Its file has faults, or the robot lacks a command or a word.
        UsageError: There is no such panel.
    """
    name, device = panel_and_device(text)
    return ChosenPanel(load_panel(library.find_panel(name, Path.cwd()), robot), device)


def panel_and_device(text: str) -> tuple[str, Path | None]:
    """Return the two parts of ``NAME:DEVICE``; the device is None if it is not named."""
    name, colon, device = text.partition(":")
    return name, Path(device) if colon else None


# --- the run --------------------------------------------------------------------------------------


Say = Callable[[str], None]
"""Takes messages about steps that take longer than a moment."""


@dataclass(frozen=True, kw_only=True)
class Equipment:
    """An unopened backend and everything that belongs to it.

    Attributes:
        backend: The backend.
        loaded: The mission, if the backend changes it (a robot's zeros); None: as it was loaded.
        companions: The companions that this backend needs.
        notices: What an operator must know before the run.
        usual_detector: The default detector; None: this backend takes no detector.
        places: True positions of bends and wheels along the pipe, for a detector; None if unknown.
        truth: Returns the robot's true state, on backends that know it.
        wheels: Returns only the wheels of it, in the plane of the drawing, m, for frequent calls.
        in_space: Returns what they leave out, on backends that know it and move the robot in space.
        rolls: Returns the rolls of :class:`Truth`, on backends that move the robot in a plane and
            put it back after a crash, for frequent calls.
        link: Returns the state of the link, if there is one.
        open_link: Examines the robot on that link.
        parting: Returns what an operator must do after the run; empty if nothing.
        confirmation: What an operator must confirm before anything moves; empty if nothing.
        attended: Whether a companion answers the mission's questions.
        adapted: Returns another mission for the same robot, with the backend's changes (a robot's
            zeros).
    """

    backend: Backend
    loaded: LoadedMission | None = None
    companions: tuple[Companion, ...] = ()
    notices: tuple[str, ...] = ()
    usual_detector: str | None = None
    places: Places | None = None
    truth: Callable[[], Truth] | None = None
    wheels: Callable[[], tuple[tuple[float, float], ...]] | None = None
    in_space: Callable[[], InSpace] | None = None
    rolls: Callable[[], tuple[float, ...]] | None = None
    link: Callable[[], LinkHealth] | None = None
    open_link: OpenLink | None = None
    parting: Callable[[], str] = lambda: ""
    confirmation: str = ""
    attended: bool = False
    adapted: Callable[[LoadedMission], LoadedMission] = lambda loaded: loaded


class MakeBackend(Protocol):
    """The factory in a backend's entry point; see ``docs/extending.md``."""

    def __call__(self, order: Order, loaded: LoadedMission, say: Say) -> Equipment:
        """Return the order's backend, unopened, without moving anything.

        Raises:
            UsageError: The order does not fit the backend, or something is not installed.
        """


@dataclass(frozen=True, kw_only=True)
class Prepared(Equipment):
    """Everything that a run needs, before anything has moved.

    Attributes:
        detecting: The detector.
        panel: The control panel, unopened; None if there is none.
        resumed: The header of the run that it resumes, with what it resumes with; None if it
            is a run of its own.
        forecast: Compares it with earlier runs; None if that was not asked.
    """

    order: Order
    loaded: LoadedMission
    engine: Engine
    detecting: Detecting = NOBODY
    panel: ChosenPanel | None = None
    resumed: RunHeader | None = None
    forecast: ForecastWatch | None = None

    @property
    def breakpoints(self) -> tuple[str, ...]:
        """Places of the instructions before which the mission pauses from its start on."""
        from pirate_sm.running.runtime.breakpoints import breakpoints

        return breakpoints(self.loaded, self.order.breakpoints)

    @property
    def detector(self) -> str:
        """Name of the detector; ``operator`` still needs a keyboard or a panel."""
        return self.detecting.kind

    @property
    def camera(self) -> Callable[[], CameraView | None] | None:
        """What returns what a recording keeps of the detector's camera, if it has one."""
        return self.detecting.camera

    @property
    def reckoned(self) -> Callable[[], Truth | None] | None:
        """What returns the detector's estimate of a position that no simulator knows."""
        return None if self.truth else self.detecting.reckoned

    @property
    def others_words(self) -> str:
        """Name of the detector if it speaks for itself; empty if an operator says its words."""
        return "" if self.detector in ("operator", "none") else self.detector
