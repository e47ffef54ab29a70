"""Finds the control panel of a run, without opening its device."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from pirate_sm.core.files import library
from pirate_sm.core.loading import LoadedRobot
from pirate_sm.core.panel import Panel
from pirate_sm.robot.control_panel.panel_file import load_panel
from pirate_sm.robot.control_panel.panel_reader import EndRun, PanelReader


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
