"""Reads a panel's MIDI device in a thread, so that a stop waits for nothing else.

A companion gives the engine what is pressed, in a run without the console.
"""

from __future__ import annotations

import errno
import grp
import os
import re
import select
import stat
import time
from collections import deque
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import inf
from pathlib import Path
from threading import Thread
from typing import Literal, NamedTuple, Protocol, Self, TypeAlias, assert_never

from pirate_sm.core.effects import Effect, Ended, Log
from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import (
    Breakpoints,
    BuiltInFault,
    DetectorWord,
    Event,
    OperatorCommand,
    Pause,
    Resume,
    Skip,
    Step,
)
from pirate_sm.core.robot import RobotSpec, lets_all_go
from pirate_sm.robot.control_panel.panel_file import (
    AnswerButton,
    Button,
    CommandButton,
    Panel,
    RunAction,
    RunButton,
    WordButton,
)
from pirate_sm.robot.control_panel.presses import (
    TWICE_WITHIN_S,
    ControlChangeParser,
    LinePress,
    Press,
    Presses,
    action_text,
)

# --- devices --------------------------------------------------------------------------------------


_CARDS = Path("/proc/asound/cards")
_DEVICES = Path("/dev/snd")

_CARD = re.compile(r"^ *(\d+) \[.*?\]: (.*)$")
_DEVICE = re.compile(r"midiC(\d+)D(\d+)")

_AT_ONCE = 4096

_TAKEN = {errno.EBUSY, errno.EAGAIN}


@dataclass(frozen=True)
class MidiDevice:
    """A MIDI device.

    Attributes:
        path: Its file.
        card: Name of its sound card, as the system shows it.
    """

    path: Path
    card: str

    def __str__(self) -> str:
        return f"{self.path} ({self.card})"


@dataclass(frozen=True)
class MidiSystem:
    """Where the system lists its sound cards and keeps their devices (ALSA, on Linux).

    Attributes:
        cards: The file with the names of the sound cards.
        devices: The folder with the files of their devices.
    """

    cards: Path = _CARDS
    devices: Path = _DEVICES

    def listed(self) -> list[MidiDevice]:
        """Return all MIDI devices, in the order of their cards; empty on a machine without any."""
        try:
            names = card_names(self.cards.read_text("utf-8", errors="replace"))
            files = [(_DEVICE.fullmatch(path.name), path) for path in self.devices.iterdir()]
        except OSError:
            return []
        found = sorted((int(m[1]), int(m[2]), path) for m, path in files if m is not None)
        return [MidiDevice(path, names.get(card, "unknown card")) for card, _, path in found]

    def find(self, name: str) -> Path:
        """Return the file of the first device whose card has this text in its name.

        Raises:
            UsageError: There is none; says which devices there are.
        """
        there = self.listed()
        for device in there:
            if name.casefold() in device.card.casefold():
                return device.path
        raise UsageError(f"no MIDI device is named '{name}'; {devices_text(there)}")


def devices_text(devices: Sequence[MidiDevice]) -> str:
    """Return which devices there are, for messages."""
    return (
        f"connected: {', '.join(map(str, devices))}" if devices else "no MIDI device is connected"
    )


def card_names(text: str) -> dict[int, str]:
    """Return the names of sound cards by their numbers, from the text of ``/proc/asound/cards``.

    A card has two lines: a number, an id and a short name; then its long name.
    """
    names: dict[int, str] = {}
    card = None
    for line in text.splitlines():
        match = _CARD.match(line)
        if match is not None:
            card = int(match[1])
            names[card] = match[2].partition(" - ")[2].strip() or match[2].strip()
        elif card is not None and line.strip():
            names[card] = f"{names[card]}: {line.strip()}"
            card = None
    return names


def open_device(path: Path) -> int:
    """Return a file descriptor that reads the device without blocking.

    Raises:
        UsageError: It is no device, or cannot be opened; says what to do.
    """
    try:
        if not stat.S_ISCHR(path.stat().st_mode):
            raise UsageError(f"{path} is not a device; MIDI devices are /dev/snd/midiC*D*")
        return os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
    except PermissionError:
        raise UsageError(f"{path} may not be read: {_who_may(path)}") from None
    except OSError as error:
        taken = error.errno in _TAKEN
        why = "another program uses it" if taken else (error.strerror or str(error))
        raise UsageError(f"{path} cannot be opened: {why}") from None


def read_device(fd: int) -> bytes | str:
    """Return the bytes that wait in a device, perhaps none; why it is gone, if it is."""
    try:
        return os.read(fd, _AT_ONCE) or "its device has closed"
    except BlockingIOError:
        return b""
    except OSError as error:
        return error.strerror or str(error)


def _who_may(path: Path) -> str:
    """Return which users may read a file that this one may not."""
    try:
        status = path.stat()
        group = grp.getgrgid(status.st_gid).gr_name
    except (OSError, KeyError):
        return "permission denied"
    if not status.st_mode & stat.S_IRGRP:
        return "permission denied, also to its group"
    return f"only the group '{group}' may; `sudo usermod -aG {group} $USER`, then log in again"


# --- the reader -----------------------------------------------------------------------------------


REOPEN_EVERY_S = 1.0

MOST_WAITING = 100
"""Nobody presses so often between two looks; the oldest are dropped."""

EndRun: TypeAlias = Callable[[str], None]
"""Brings the robot to its safe state, for this reason; may be called from any thread."""


class Connection(NamedTuple):
    """The panel was lost, or is back.

    Attributes:
        state: Which of the two.
        message: What has happened, for people.
    """

    state: Literal["lost", "back"]
    message: str


Happening: TypeAlias = Press | LinePress | Connection


class PressSource(Protocol):
    """Where an operator presses buttons: a control panel, or the page of a run."""

    @property
    def buttons(self) -> Collection[Button]:
        """Return what its buttons do."""

    def taken(self) -> Sequence[Happening]:
        """Return what has happened since the last call, oldest first."""


class PanelReader:
    """A connected panel, while it is entered.

    Presses that end the run act in the reader's thread; all others wait for :meth:`taken`.

    Args:
        panel: The panel.
        device: Its file; None: found by the name of its sound card.
        end_run: Ends the run.
        reopen_every_s: How often a device that has gone is looked for.

    Attributes:
        panel: The panel.
    """

    def __init__(
        self,
        panel: Panel,
        device: Path | None,
        end_run: EndRun,
        *,
        reopen_every_s: float = REOPEN_EVERY_S,
    ) -> None:
        self.panel = panel
        self._device = device
        self._end_run = end_run
        self._system = MidiSystem()
        self._reopen_every_s = reopen_every_s
        self._happened: deque[Happening] = deque(maxlen=MOST_WAITING)
        self._presses = Presses(panel)
        self._parser = ControlChangeParser()
        self._fd = self._wake = self._woken = -1
        self._thread = Thread(target=self._work, name="panel", daemon=True)

    def __enter__(self) -> Self:
        """Open the device and begin to read.

        Raises:
            UsageError: The device is not there or cannot be opened.
        """
        self._fd = self._open()
        self._woken, self._wake = os.pipe()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop reading and close the device."""
        os.close(self._wake)
        self._thread.join()
        os.close(self._woken)
        self._close()

    @property
    def buttons(self) -> Collection[Button]:
        """Return what its buttons do."""
        return self.panel.buttons.values()

    def taken(self) -> list[Happening]:
        """Return what has happened since the last call, oldest first."""
        found = []
        while self._happened:
            found.append(self._happened.popleft())
        return found

    # --- in its own thread --------------------------------------------------------------------

    def _open(self) -> int:
        return open_device(self._device or self._system.find(self.panel.device))

    def _close(self) -> None:
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def _work(self) -> None:
        try:
            while self._turn():
                pass
        except Exception as error:
            self._lose(f"this program has failed to read it: {type(error).__name__}: {error}")

    def _turn(self) -> bool:
        """Wait for bytes, for a held button or for the device; return whether to go on."""
        poll = select.poll()
        poll.register(self._woken, select.POLLIN)
        if self._fd >= 0:
            poll.register(self._fd, select.POLLIN)
            wait_s = max(self._presses.due_s - time.monotonic(), 0.0)
        else:
            wait_s = self._reopen_every_s
        ready = dict(poll.poll(None if wait_s == inf else wait_s * 1000))
        if self._woken in ready:
            return False
        if self._fd < 0:
            self._look_for_it()
            return True
        if self._fd in ready:
            self._read()
        for press in self._presses.pass_time(time.monotonic()):
            self._act(press)
        return True

    def _read(self) -> None:
        data = read_device(self._fd)
        if isinstance(data, str):
            self._lose(data)
            return
        for change in self._parser.take(data):
            for press in self._presses.take(change, time.monotonic()):
                self._act(press)

    def _act(self, press: Press) -> None:
        button = press.button
        if isinstance(button, RunButton) and button.do in ("stop", "abort") and not press.asks:
            self._end_run(f"{'stopped' if button.do == 'stop' else 'aborted'} on the panel")
        else:
            self._happened.append(press)

    def _lose(self, why: str) -> None:
        self._close()
        self._presses.release_all()
        self._parser = ControlChangeParser()
        self._happened.append(Connection("lost", f"the panel is disconnected: {why}"))

    def _look_for_it(self) -> None:
        with suppress(UsageError):
            self._fd = self._open()
            self._happened.append(Connection("back", "the panel is back"))


# --- the companion --------------------------------------------------------------------------------


LOOK_EVERY_S = 0.02
"""The longest delay of a press, except for a stop, which needs no companion."""


class PanelCompanion:
    """A companion that reads a panel, or another place where an operator presses buttons.

    A command that lets go of the pipe must be pressed twice, whatever the panel's file says: the
    console would ask too.

    Args:
        reader: The panel, which is entered as long as the run goes on.
        robot: The robot.
        speaks: The detector that says the words, so that the panel may not; empty if none does.
        valid_for_s: How long a word is valid.
        keyboard: Whether a person also has a keyboard. Otherwise the loss of the panel is a fault.
        watching: Whether an operator watches the robot as long as it runs; else only a paused
            mission waits for one.
        places: Returns the place of the instruction in a line of the mission's files.

    Attributes:
        listening: Whether an operator is watching the robot or is waited for.
        says_words: Whether the panel has buttons for words; likewise ``answers`` and ``resumes``.
    """

    def __init__(
        self,
        reader: PressSource,
        robot: RobotSpec,
        *,
        speaks: str,
        valid_for_s: float,
        keyboard: bool,
        watching: bool = True,
        places: Callable[[str], str] = str,
    ) -> None:
        self.due_s = 0.0
        self.listening = self._watching = watching
        buttons = reader.buttons
        self.says_words = any(isinstance(each, WordButton) for each in buttons)
        self.answers = any(isinstance(each, AnswerButton) for each in buttons)
        self.resumes = any(isinstance(each, RunButton) and each.do == "go" for each in buttons)
        self._reader, self._robot = reader, robot
        self._speaks, self._places = speaks, places
        self._valid_for_s = valid_for_s
        self._keyboard = keyboard
        self._events: list[Event] = []
        self._logs: list[Log] = []
        self._keys = ""
        self._began = False
        self._asked = ("", -inf)

    def pressed(self) -> str:
        """Return the numbers of the answers given since the last call, as keys would."""
        keys, self._keys = self._keys, ""
        return keys

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Stop listening at the end of the run."""
        if any(isinstance(effect, Ended) for effect in effects):
            self.due_s, self.listening = inf, False

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Take in what has happened on the panel; return messages for the operator."""
        self._logs = []
        self.listening = self._watching or state.mission.paused
        for happening in self._reader.taken():
            if isinstance(happening, Connection):
                self._connection(happening)
            elif not self._began:
                continue  # it was pressed before this run
            elif isinstance(happening, LinePress):
                self._press_line(happening, state.mission.breakpoints)
            elif happening.asks:
                self._asked = ("", -inf)  # another button takes the first press back
                self._ask(happening.name, action_text(happening.button))
            else:
                self._press(happening, state, now_s)
        self._began = True
        return self._logs

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the events of the presses, oldest first."""
        self.due_s = now_s + LOOK_EVERY_S
        events, self._events = self._events, []
        return events

    def _connection(self, news: Connection) -> None:
        if news.state == "lost" and not self._keyboard:
            self._events.append(BuiltInFault.PANEL_LOST.report(news.message))
        else:
            self._logs.append(Log("warning" if news.state == "lost" else "info", news.message))

    def _press(self, press: Press, state: EngineState, now_s: float) -> None:
        asked, self._asked = self._asked, ("", -inf)
        match press.button:
            case RunButton(do=action):
                self._events.append(_event(action, press.by))
            case CommandButton(command=command):
                again = asked[0] == press.name and now_s <= asked[1] + TWICE_WITHIN_S
                sure = again or press.button.twice
                if sure or not lets_all_go(self._robot, state.robot, command):
                    self._events.append(OperatorCommand(command))
                else:
                    self._asked = press.name, now_s
                    self._ask(press.name, f"{command}, after which nothing holds the robot")
            case WordButton(word=word) if self._speaks:
                where = press.by or "panel"
                said = f"'{word}' on the {where} is ignored: the detector is {self._speaks}"
                self._logs.append(Log("warning", said))
            case WordButton(word=word):
                self._events.append(DetectorWord(word, self._valid_for_s, press.by))
            case AnswerButton(answer=number):
                self._keys += str(number)

    def _press_line(self, press: LinePress, breakpoints: tuple[str, ...]) -> None:
        asked = [each.at for each in self._events if isinstance(each, Breakpoints)]
        try:
            place = self._places(press.line)
            self._events.append(press.event(place, asked[-1] if asked else breakpoints))
        except UsageError as error:
            self._logs.append(Log("warning", f"{press.what} {error}"))

    def _ask(self, name: str, what: str) -> None:
        text = f"press {name} again within {TWICE_WITHIN_S:g} s: {what}"
        self._logs.append(Log("warning", text))


def _event(action: RunAction, by: str) -> Event:
    """Return the event of a press that acts on the run; one that ends it needs none."""
    match action:
        case "go":
            return Resume(by)
        case "pause":
            return Pause(by)
        case "step":
            return Step(by)
        case "skip":
            return Skip()
        case "stop" | "abort":
            raise AssertionError(f"the reader itself acts on {action}")
        case _:
            assert_never(action)
