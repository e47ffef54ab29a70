"""Makes presses of buttons from the bytes of a MIDI device: combined, held, or asked for twice."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Literal, NamedTuple, assert_never

from pirate_sm.core.events import Breakpoints, Resume
from pirate_sm.robot.control_panel import panel_file as kinds

# --- MIDI -----------------------------------------------------------------------------------------


_STATUS, _SYSTEM, _REALTIME = 0x80, 0xF0, 0xF8
_CONTROL_CHANGE = 0xB0


class ControlChange(NamedTuple):
    """A control has another value.

    Attributes:
        channel: MIDI channel, 1 to 16.
        number: Number of the control, 0 to 127.
        value: Its value, 0 to 127.
    """

    channel: int
    number: int
    value: int


class ControlChangeParser:
    """Takes bytes as they come, in pieces of any size (MIDI 1.0, detailed specification).

    A control change is a status byte ``0xB0 + channel``, a number and a value. Further pairs may
    follow without a status byte (running status). Single bytes from 0xF8 on may come between any
    two bytes and change nothing. All other messages are passed over.

    Attributes:
        others: How many messages of a channel were no control changes.
    """

    def __init__(self) -> None:
        self.others = 0
        self._channel = 0
        self._number = -1

    def take(self, data: bytes) -> list[ControlChange]:
        """Return the control changes that these bytes complete."""
        found = []
        for byte in data:
            if byte >= _REALTIME:
                continue
            if byte >= _STATUS:
                ours = byte & 0xF0 == _CONTROL_CHANGE
                self._channel = (byte & 0x0F) + 1 if ours else 0
                self._number = -1
                self.others += not ours and byte < _SYSTEM
            elif self._channel and self._number < 0:
                self._number = byte
            elif self._channel:
                found.append(ControlChange(self._channel, self._number, byte))
                self._number = -1
        return found


# --- presses --------------------------------------------------------------------------------------


PRESSED = 64
"""Values from here on are a pressed button (MIDI 1.0: a switch is on from 64)."""

TWICE_WITHIN_S = 3.0
"""How long a first press waits for the second one."""


def action_text(button: kinds.Button) -> str:
    """Return what a button does, for people."""
    match button:
        case kinds.RunButton(do=action):
            return action
        case kinds.CommandButton(command=command):
            return command
        case kinds.WordButton(word=word):
            return f"the word {word}"
        case kinds.AnswerButton(answer=number):
            return f"answer {number}"
        case _:
            assert_never(button)


class Press(NamedTuple):
    """A button has been pressed as its action asks for.

    Attributes:
        name: The button or the combination of buttons.
        button: What it does.
        asks: Whether it must be pressed once more before it acts.
        by: Where, as events record it; empty for a control panel.
    """

    name: str
    button: kinds.Button
    asks: bool = False
    by: str = ""


class LinePress(NamedTuple):
    """A line of the mission's file has been pressed, as only the page of a run can.

    Attributes:
        do: Set or clear a breakpoint, or run until there.
        line: The line, as in ``FILE:LINE``.
        by: Where, as events record it.
    """

    do: Literal["break", "until"]
    line: str
    by: str

    @property
    def what(self) -> str:
        """What is asked for, in words before the line."""
        return "breakpoint at" if self.do == "break" else "run to"

    def event(self, place: str, before: tuple[str, ...]) -> Breakpoints | Resume:
        """Return the request of the operator.

        Args:
            place: The place of the instruction in the line.
            before: The breakpoints until now.
        """
        if self.do == "until":
            return Resume(self.by, place)
        kept = tuple(each for each in before if each != place)
        return Breakpoints(kept if place in before else (*before, place), self.by)


@dataclass(frozen=True)
class _Due:
    at_s: float
    press: Press


class Presses:
    """Follows which buttons are down.

    A button acts when it goes down, once. While the first button of a combination is down, others
    act only in combinations with it, except for a stop.

    Args:
        panel: The panel.
    """

    def __init__(self, panel: kinds.Panel) -> None:
        self._channel = panel.channel
        self._name_of = {number: name for name, number in panel.controls.items()}
        self._buttons = {tuple(name.split("+")): (name, b) for name, b in panel.buttons.items()}
        self._leading = {name for names in self._buttons for name in names[:-1]}
        self._down: list[str] = []
        self._held: dict[str, _Due] = {}
        self._asked: _Due | None = None

    @property
    def due_s(self) -> float:
        """When a held button acts next; infinite if none is held."""
        return min((each.at_s for each in self._held.values()), default=inf)

    def release_all(self) -> None:
        """Forget which buttons are down, because the panel has gone."""
        self._down.clear()
        self._held.clear()
        self._asked = None

    def take(self, change: ControlChange, now_s: float) -> list[Press]:
        """Return the presses that a control change makes, at a time of a monotonic clock, s."""
        name = self._name_of.get(change.number)
        if name is None or change.channel != self._channel:
            return []
        if change.value < PRESSED:
            self._held.pop(name, None)
            if name in self._down:
                self._down.remove(name)
            return []
        if name in self._down:
            return []
        found = self._meant(name)
        self._down.append(name)
        if found is None:
            return []
        press = Press(*found)
        if press.button.hold > 0:
            self._held[name] = _Due(now_s + press.button.hold, press)
            return []
        return [self._counted(press, now_s)]

    def pass_time(self, now_s: float) -> list[Press]:
        """Return the presses of buttons that have been held for long enough."""
        done = [name for name, due in self._held.items() if due.at_s <= now_s]
        return [self._counted(self._held.pop(name).press, now_s) for name in done]

    def _meant(self, name: str) -> tuple[str, kinds.Button] | None:
        """Return the action of a button that goes down now, by the others that are down."""
        leading = tuple(each for each in self._down if each in self._leading)
        alone = self._buttons.get((name,))
        stops = (
            alone is not None and isinstance(alone[1], kinds.RunButton) and alone[1].do == "stop"
        )
        return alone if stops else self._buttons.get((*leading, name))

    def _counted(self, press: Press, now_s: float) -> Press:
        """Return the press, as a question if it must come once more."""
        asked, self._asked = self._asked, None
        if not press.button.twice:
            return press
        if asked is not None and asked.press == press and now_s <= asked.at_s:
            return press
        self._asked = _Due(now_s + TWICE_WITHIN_S, press)
        return press._replace(asks=True)
