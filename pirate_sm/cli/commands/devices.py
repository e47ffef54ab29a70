"""`pirate bay` and `pirate panel`: an emulated bay in real time, and what control panels send."""

from __future__ import annotations

import math
import os
import select
import time
from collections.abc import Sequence
from contextlib import ExitStack
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TextIO

from pirate_sm.cli.errors import say
from pirate_sm.cli.options.devices import BayOptions, PanelOptions
from pirate_sm.cli.output.files import refuse_losses
from pirate_sm.core.errors import UsageError
from pirate_sm.core.files import library
from pirate_sm.core.loading import load_mission, load_pipe, load_robot
from pirate_sm.core.panel import Panel
from pirate_sm.core.pipe import Pipe
from pirate_sm.core.profile import Profile
from pirate_sm.core.spelling import unknown
from pirate_sm.core.units import DIMENSIONLESS, read_quantity
from pirate_sm.core.visible import visible
from pirate_sm.robot.control_panel.panel_file import read_panel
from pirate_sm.robot.control_panel.panel_reader import MidiSystem, open_device, read_device
from pirate_sm.robot.control_panel.presses import (
    PRESSED,
    ControlChange,
    ControlChangeParser,
    Press,
    Presses,
    action_text,
)
from pirate_sm.running.runtime.ending import BACKEND, SUCCEEDED
from pirate_sm.running.wiring.backends import COMPILING, start_values, without_messages
from pirate_sm.running.wiring.prepared import panel_and_device

if TYPE_CHECKING:
    from pirate_sm.simulation.bay.switches import Switches, Topic


# --- pirate bay ---------------------------------------------------------------------------------


class _Setting(NamedTuple):
    """A robot in a pipe."""

    profile: Profile
    folder: Path
    pipe: Pipe
    start_values: tuple[float, ...] | None


def run_bay(options: BayOptions) -> int:
    """Emulate the bay until a signal stops it; return the exit code.

    Raises:
        LoadError: Files cannot be used.
        UsageError: Something does not fit, or an optional part is not installed.
        BackendError: There is no pseudo-terminal.
    """
    try:
        from pirate_sm.simulation.bay.node_handle import message_texts
        from pirate_sm.simulation.bay.terminal import StopSignals, Terminal, serve
        from pirate_sm.simulation.bay.virtual import VirtualBay
        from pirate_sm.simulation.xpbd.world import is_compiled
    except ModuleNotFoundError as error:
        raise without_messages(error) from None
    if options.log is not None:
        refuse_losses([options.log], overwrite=options.overwrite)
    switches = _switches(options)
    at = _setting(options)
    texts = message_texts(at.folder, at.profile)
    if not is_compiled(at.pipe.section):
        say(COMPILING)
    baud = at.profile.serial.baud if at.profile.serial is not None else None
    bay = VirtualBay(at.profile, at.pipe, texts, switches, options.seed, at.start_values)
    with ExitStack() as stack:
        signals = stack.enter_context(StopSignals())
        log = stack.enter_context(_log(options.log)) if options.log is not None else None
        terminal = stack.enter_context(Terminal(options.link, baud))
        print(terminal.name, flush=True)
        serve(bay, terminal, lambda: signals.stop, log)
    return 0


def _log(path: Path) -> TextIO:
    try:
        # It grows while the bay runs and can be read meanwhile, so no other file takes its place.
        return path.open("w", encoding="utf-8")
    except OSError as error:
        raise UsageError(f"'{path}' cannot be written: {error.strerror}") from None


def _switches(options: BayOptions) -> Switches:
    from pirate_sm.simulation.bay.switches import RING, Switches

    return Switches(
        loss_in=_share(options.loss_in or options.loss),
        loss_out=_share(options.loss_out or options.loss),
        never_two=options.never_two,
        corruption=_share(options.corruption),
        delay_s=options.delay,
        jitter_s=options.jitter,
        reset_at_s=tuple(options.reset_at or ()),
        reset_every_s=options.reset_every,
        hang_at_s=_or_never(options.hang_at),
        hang_for_s=_or_never(options.hang_for),
        boot_s=options.boot,
        ring=RING if options.overrun else None,
        stale_every_s=options.stale_every,
        wrong_md5=_topics(options.wrong_md5 or ()),
        unconfigured_at_s=tuple(options.unconfigured_at or ()),
        spontaneous_at_s=tuple(options.spontaneous_at or ()),
        motors_started=options.motors_started,
        sensors_started=options.sensors_started,
        old_client=options.old_client,
        dead_man=options.dead_man,
        defects=tuple(options.defects or ()),
    )


def _share(text: str | None) -> float:
    """Return the share in text such as ``20%`` or ``0.2``."""
    return 0.0 if text is None else read_quantity(text, DIMENSIONLESS)


def _or_never(time_s: float | None) -> float:
    return math.inf if time_s is None else time_s


def _topics(names: Sequence[str]) -> tuple[Topic, ...]:
    from pirate_sm.simulation.bay.switches import TOPICS

    if wrong := unknown("there is no topic", names, TOPICS):
        raise UsageError(wrong)
    return tuple(topic for topic in TOPICS if topic in names)


def _setting(options: BayOptions) -> _Setting:
    """Return the robot and pipe of the options, by default the first shipped ones."""
    if options.mission is not None:
        return _setting_of(options.mission, options)
    folder = library.find_robot(options.robot, Path.cwd()) if options.robot else library.robots()[0]
    return _Setting(load_robot(folder).profile, folder, _pipe(options.pipe), None)


def _setting_of(name: str, options: BayOptions) -> _Setting:
    path = library.find_mission(name)
    mission = load_mission(path, robot=options.robot, pipe=options.pipe)
    if options.robot is not None:
        folder = library.find_robot(options.robot, Path.cwd())
    else:
        folder = library.find_robot(mission.mission.robot, path.resolve().parent)
    pipe = mission.pipe or _pipe(options.pipe)
    return _Setting(mission.loaded_robot.profile, folder, pipe, start_values(mission))


def _pipe(name: str | None) -> Pipe:
    file = library.find_pipe(name, Path.cwd()) if name else library.pipes()[0]
    return load_pipe(file)[0]


# --- pirate panel -------------------------------------------------------------------------------


def show_panel(options: PanelOptions) -> int:
    """List what there is, or show what a panel sends; return the exit code.

    Raises:
        LoadError: The panel's file has faults.
        UsageError: There is no such panel or device.
    """
    if options.name is None:
        return _list_panels()
    panel, device = _chosen_panel(options.name)
    fd = open_device(device)
    print(f"{visible(str(device))}: press its buttons, Ctrl-C ends", flush=True)
    try:
        why = _Display(panel).follow(fd)
    except KeyboardInterrupt:
        return SUCCEEDED
    finally:
        os.close(fd)
    say(f"the panel is disconnected: {why}")
    return BACKEND


def _list_panels() -> int:
    from pirate_sm.cli.commands.list import list_panels, print_table

    list_panels()
    print_table("MIDI devices", [(str(each.path), each.card) for each in MidiSystem().listed()])
    return SUCCEEDED


def _chosen_panel(text: str) -> tuple[Panel | None, Path]:
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
