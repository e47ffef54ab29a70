"""`pirate panel`: lists panels and MIDI devices, and shows what a panel sends."""

from __future__ import annotations

import os
import select
import time
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from pirate_sm.cli.errors import say
from pirate_sm.cli.options.devices import PanelOptions
from pirate_sm.core import library
from pirate_sm.core.errors import ExitCode
from pirate_sm.core.visible import visible
from pirate_sm.robot.control_panel.panel_file import Panel, read_panel
from pirate_sm.robot.control_panel.panel_reader import MidiSystem, open_device, read_device
from pirate_sm.robot.control_panel.presses import (
    PRESSED,
    ControlChange,
    ControlChangeParser,
    Press,
    Presses,
    action_text,
)
from pirate_sm.running.wiring.prepared import panel_and_device

if TYPE_CHECKING:
    pass


def show_panel(options: PanelOptions) -> int:
    """List the panels, or show what a panel sends; return the exit code.

    Raises:
        LoadError: The panel's file has faults.
        UsageError: There is no such panel or device.
    """
    if options.name is None:
        return _list()
    panel, device = _chosen(options.name)
    fd = open_device(device)
    print(f"{visible(str(device))}: press its buttons, Ctrl-C ends", flush=True)
    try:
        why = _Display(panel).follow(fd)
    except KeyboardInterrupt:
        return ExitCode.SUCCEEDED
    finally:
        os.close(fd)
    say(f"the panel is disconnected: {why}")
    return ExitCode.BACKEND


def _list() -> int:
    from pirate_sm.cli.commands.list import list_panels, print_table

    list_panels()
    print_table("MIDI devices", [(str(each.path), each.card) for each in MidiSystem().listed()])
    return ExitCode.SUCCEEDED


def _chosen(text: str) -> tuple[Panel | None, Path]:
    """Return the panel and its device; no panel where a device alone is named."""
    if text.startswith("/dev/"):
        return None, Path(text)
    name, device = panel_and_device(text)
    panel, _, problems = read_panel(library.find_panel(name, Path.cwd()))
    problems.raise_errors()
    return panel, device or MidiSystem().find(panel.device)


class _Display:
    """Prints a line for each control change."""

    def __init__(self, panel: Panel | None) -> None:
        self._panel = panel
        self._names = {number: name for name, number in panel.controls.items()} if panel else {}
        self._presses = Presses(panel) if panel else None
        self._parser = ControlChangeParser()
        self._others = 0

    def follow(self, fd: int) -> str:
        """Read the device until it has gone; return why."""
        poll = select.poll()
        poll.register(fd, select.POLLIN)
        while True:
            due_s = self._presses.due_s if self._presses is not None else inf
            wait_s = max(due_s - time.monotonic(), 0.0)
            if poll.poll(None if wait_s == inf else wait_s * 1000):
                data = read_device(fd)
                if isinstance(data, str):
                    return data
                self._show(data)
            if self._presses is not None:
                for press in self._presses.pass_time(time.monotonic()):
                    print(f"{'':32} {_does(press)}", flush=True)

    def _show(self, data: bytes) -> None:
        for change in self._parser.take(data):
            print(self._line(change), flush=True)
        if self._parser.others > self._others == 0:
            say("other messages than control changes come: is the panel in CC mode?")
        self._others = self._parser.others

    def _line(self, change: ControlChange) -> str:
        """Return a line with the control's name, its numbers, and what it does."""
        presses = self._presses.take(change, time.monotonic()) if self._presses else []
        name = self._names.get(change.number, "")
        if self._panel is not None and change.channel != self._panel.channel:
            name = f"not on channel {self._panel.channel}"
        does = ", ".join(map(_does, presses))
        if self._presses is None:
            does = "pressed" if change.value >= PRESSED else "released"
        numbers = f"channel {change.channel:<2} {change.number:>3} = {change.value:<3}"
        return f"{numbers}  {name:<16} {does}".rstrip()


def _does(press: Press) -> str:
    again = " (press again within 3 s)" if press.asks else ""
    return f"→ {press.name}: {action_text(press.button)}{again}"
