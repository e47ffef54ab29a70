"""Dialogs over the console, among them its help. The stop key works in all.

A key that was pressed before a dialog could be read was meant for something else and is ignored.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import starmap
from math import inf, nan
from textwrap import wrap
from time import monotonic
from typing import ClassVar, NamedTuple, TypeVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.screen import ModalScreen
from textual.widgets import Button, Footer, Input, OptionList, Static
from textual.widgets.option_list import Option

from pirate_sm.core.events import Observation
from pirate_sm.core.units import LENGTH, QuantityError, read_quantity
from pirate_sm.running.runtime.ending import StopRequests
from pirate_sm.views.console.availability import (
    LEAVE,
    NO,
    YES,
    Entries,
    both_cases,
    command_reason,
    controls,
)
from pirate_sm.views.console.terminal_driver import STOP_KEY
from pirate_sm.views.console.widgets import content_line
from pirate_sm.views.showing.snapshot import Snapshot
from pirate_sm.views.showing.text_styles import MUTED, STRONG

# --- dialogs ------------------------------------------------------------------------------------


_WIDEST = 100
"""The largest width of a list, as in the stylesheet."""

_FRAME = 6
"""Columns of a list for border, padding and scroll bar."""


_NO_KEYS = f"{both_cases(NO)},{both_cases(LEAVE)},escape"
_STOP = Binding(STOP_KEY, "app.stop", "STOP")
"""The stop key in the last line of each dialog."""


def last_line() -> Footer:
    """Return a footer with the keys of the dialog, over that of the console."""
    return Footer(show_command_palette=False, compact=True)


_R = TypeVar("_R")

READ_AFTER_S = 0.3
"""A dialog is read no sooner after it was drawn than an operator can react to it."""


class Dialog(ModalScreen[_R]):
    """A dialog that knows since when it can be read.

    Attributes:
        drawn_s: When it was drawn, by the monotonic clock; infinite before.
        run: The requests of the run that its answer can move; None if it moves nothing.
    """

    drawn_s = inf
    run: StopRequests | None = None

    def on_screen_resume(self) -> None:
        """Note when it has been drawn."""
        self.call_after_refresh(self._note_drawn)

    def _note_drawn(self) -> None:
        self.drawn_s = min(self.drawn_s, monotonic())


class Confirm(Dialog[bool]):
    """Asks a question; any answer but yes is a no."""

    BINDINGS: ClassVar[list[BindingType]] = [
        _STOP,
        Binding(both_cases(YES), "answer(True)", "Yes", key_display=YES),
        Binding(_NO_KEYS, "answer(False)", "No", key_display=NO),
    ]

    def __init__(self, question: str, yes: str) -> None:
        super().__init__()
        self._question = question
        self._yes = yes

    def compose(self) -> ComposeResult:
        """Lay out the question and two buttons; the safe one has the focus."""
        with Vertical(classes="dialog"):
            yield Static(self._question, markup=False, classes="question")
            with Horizontal(classes="buttons"):
                yield Button(f"{self._yes} (y)", variant="warning", id="yes")
                yield Button("No (n)", variant="default", id="no")
        yield last_line()

    def on_mount(self) -> None:
        """Focus the button for no, so that Enter alone says no."""
        self.query_one("#no").focus()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        """Answer by the button."""
        self.dismiss(event.button.id == "yes")

    def action_answer(self, yes: bool) -> None:
        """Answer by the key."""
        self.dismiss(yes)


class ObservationDialog(Dialog[Observation | None]):
    """Asks where the robot is and what is seen there. The space bar types a space."""

    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "dismiss(None)", "Cancel")]

    def compose(self) -> ComposeResult:
        """Lay out two lines to type in."""
        with Vertical(classes="dialog"):
            yield Static("Wheel 1 is at (empty: not said)", markup=False)
            yield Input(placeholder="0.70 m")
            yield Static("Seen there (empty: nothing)", markup=False)
            yield Input(placeholder="crack, 3 o'clock")
        yield last_line()

    def on_input_submitted(self) -> None:
        """Take both lines, or show why the place is none."""
        place, seen = (each.value.strip() for each in self.query(Input))
        try:
            place_m = read_quantity(place, LENGTH) if place else nan
        except QuantityError as error:
            self.app.notify(str(error), severity="warning", markup=False)
            return
        self.dismiss(Observation(seen, place_m) if place or seen else None)


class PickLine(NamedTuple):
    """A line of a list; a line with a reason cannot be chosen."""

    name: str
    label: str
    detail: str = ""
    reason: str = ""


class Pick(Dialog[str | None]):
    """A list to choose from.

    Attributes:
        keys: What its keys do.
    """

    keys = "↑ ↓ Enter chooses   Esc leaves"

    BINDINGS: ClassVar[list[BindingType]] = [
        _STOP,
        Binding(f"escape,{both_cases(LEAVE)}", "dismiss(None)", "Cancel"),
    ]

    def __init__(
        self, title: str, choices: Sequence[PickLine], wide: int = 24, at: int = 0
    ) -> None:
        super().__init__()
        self._title = title
        self._wide = wide
        self._choices = list(choices)
        self._marked = at

    def compose(self) -> ComposeResult:
        """Lay out the list and its keys."""
        with Vertical(classes="dialog pick"):
            options = enumerate(self._choices)
            listed = OptionList(*(Option(self._text(at, it), it.name) for at, it in options))
            listed.highlighted = self._marked
            listed.border_title = self._title
            listed.border_subtitle = self.keys
            yield listed
        yield last_line()

    def on_resize(self) -> None:
        """Fit the lines to the new width."""
        self._draw(range(len(self._choices)))

    def on_option_list_option_highlighted(self, event: OptionList.OptionHighlighted) -> None:
        """Mark the line; colour alone would not show it on every terminal."""
        before, self._marked = self._marked, event.option_index
        self._draw({before, self._marked})

    def _text(self, at: int, choice: PickLine) -> Content:
        mark = "▸" if at == self._marked else " "
        label = f"{choice.label:<{self._wide}} "
        indent = len(label) + 3
        room = max(min(_WIDEST, self.app.size.width * 95 // 100) - _FRAME - indent, 12)
        first, *more = wrap(choice.reason or choice.detail, room) or [""]
        if choice.reason:
            head = content_line(("✕", MUTED), mark, (f" {label}{first}", MUTED))
        else:
            head = content_line(f" {mark} ", (label, "bold"), (first, MUTED))
        return Content("\n").join(
            [head, *(content_line((" " * indent + each, MUTED)) for each in more)]
        )

    def _draw(self, indexes: Iterable[int]) -> None:
        listed = self.query_one(OptionList)
        for index in indexes:
            listed.replace_option_prompt_at_index(index, self._text(index, self._choices[index]))

    def replace(self, choices: Sequence[PickLine]) -> None:
        """Show new reasons."""
        pairs = enumerate(zip(self._choices, choices, strict=True))
        changed = [index for index, (old, new) in pairs if old != new]
        self._choices = list(choices)
        self._draw(changed)
        if changed:
            self.app.clear_notifications()  # one may say a reason that does not hold any more

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Choose the line, or show in full why it cannot be chosen."""
        choice = self._choices[event.option_index]
        if choice.reason:
            text = f"{choice.label}: {choice.reason}"
            self.app.notify(text, severity="warning", timeout=10, markup=False)
        else:
            self.dismiss(choice.name)


class HelpDialog(Dialog[None]):
    """A page to read, which follows what is so.

    Args:
        lines: Returns the lines of the page as they are now.

    Attributes:
        heading: Its title.
    """

    heading = "Help"

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(f"escape,{both_cases(LEAVE)},question_mark,enter", "dismiss", "Close")
    ]

    def __init__(self, lines: Callable[[], Sequence[Content]]) -> None:
        super().__init__()
        self._now, self._lines = lines, lines()

    def compose(self) -> ComposeResult:
        """Lay out a page that scrolls."""
        with VerticalScroll(classes="dialog help") as page:
            page.border_title = self.heading
            page.border_subtitle = "Esc leaves"
            yield Static(Content("\n").join(self._lines))
        yield last_line()

    def renew(self) -> None:
        """Show what has changed since."""
        if self.is_mounted and (lines := self._now()) != self._lines:
            self._lines = lines
            self.query_one(Static).update(Content("\n").join(lines))


class Help(HelpDialog):
    """A page to read while the robot can be stopped."""

    BINDINGS: ClassVar[list[BindingType]] = [_STOP]


# --- the help page ------------------------------------------------------------------------------


_KEYS, _WIDE = 16, 50
"""Columns of the keys and of their meaning; both fit into a terminal of 80 columns."""

_ALWAYS = (
    ("Space", "STOP: wheels stop, clamps hold. Works at any time, also over a dialog."),
    ("m", "Choose a mission. It begins paused: the robot is yours first."),
    ("↑ ↓", "Drive forward, backward for as long as the key is held."),
    ("← →", "Stop the wheels."),
    ("+ -", "Drive faster, slower by hand, from the next drive on."),
    ("@", "Type where wheel 1 is and what is seen, while nothing moves."),
    ("=", "Where a drive by hand stops: after a distance, before the joint."),
    ("1 … 9", "Answer what the mission asks."),
    ("Tab", "Next page, if the terminal is too small for all of it."),
    ("PgUp PgDn", "Earlier and later lines of the log."),
    ("#", "Pre-flight: the checks of pirate doctor on the open port, repeated."),
    ("*", "Breakpoints: where the mission pauses; and run to a line."),
    ("!", "Every alarm with its time, in full; Enter there acknowledges one."),
    ("Esc", "The alarms shown are seen; no more of a series of commands; leave a dialog."),
    ("?", "This page; ↑ ↓ PgUp PgDn move it."),
    ("^p", "Command palette: everything by name."),
    ("^t", "Next theme: dark, light, two of high contrast, the colours of Okabe and Ito."),
    ("q", "Safe state, then leave."),
)

_LOOKING_BACK = (
    ("r", "Play; at the end from the start."),
    ("p Space", "Pause."),
    ("← →", "1 s back, 1 s on; with Shift 0.1 s."),
    ("↑ ↓", "10 s back, 10 s on; so do PgUp and PgDn."),
    ("< >", "The phase before, the next one."),
    ("Home End", "The start, the end."),
    ("Tab", "Next page, if the terminal is too small for all of it."),
    ("?", "This page."),
    ("^t", "Next theme."),
    ("q", "Leave."),
)

_SIGNS = (
    ("▶ ‖ ■ ◆", "running, paused, ending or over, no mission: by hand"),
    ("✓ ▶ ▷ ·", "a phase that was left, the current one, one that has called it, not entered"),
    ("● ○", "a state that has been confirmed; one that was only commanded"),
    ("■ ?", "commanded and stopped: 0 is sent; not shown now, or a fault contradicts it"),
    ("12s", "after a state: how long ago sensors, an echo or the operator showed it"),
    ("┄1.2 3s", "what a value was when it was last reported, and how long ago"),
    (
        "1A 2B 3~ 4– 5?",
        "wheel 1 touches wall A, 2 wall B, 3 out of the plane of its part, 4 none; 5 is not known",
    ),
    ("thick wall", "where a wheel touches it"),
    ("dial", "where side A of a part points, looking ahead: up, right, down, left"),
    ("✕ =", "cannot be done now; is so already: the words are the engine's own"),
    ("full disc, ring", "a wheel that touches a wall, one that does not"),
    ("full, outline", "a part of the robot that is held, one that is not"),
    ("rays, dashes", "a light that is on; the robot as it was last heard"),
    ("!", "near a limit; before a key: a fault contradicts it, so it asks first"),
)


def help_lines(
    letters: Mapping[str, str], snapshot: Snapshot, entries: Entries | None
) -> list[Content]:
    """Return the help page of the console, with all of why something cannot be done now."""
    robot = snapshot.scene.robot
    commands = snapshot.scene.loaded.loaded_robot.profile.commands
    return _page(
        {
            "Always": _ALWAYS,
            "A mission": [
                (each.key, _with_reason(each.label, each.reason))
                for each in controls(snapshot, entries)
            ],
            f"Commands of {robot.name}": [
                (
                    letters.get(name, "^p"),
                    _with_reason(f"{name}  {each.description}", command_reason(snapshot, name)),
                )
                for name, each in commands.items()
            ],
            "You as the detector, if there is no other": [
                (letters.get(word, "^p"), word) for word in robot.detector_words
            ],
            "Signs": _SIGNS,
        }
    )


def _with_reason(text: str, reason: str) -> str:
    return f"{text}. Not now: {reason}" if reason else text


def recording_lines() -> list[Content]:
    """Return the help page of the viewer of a recording."""
    return _page({"A recording": _LOOKING_BACK, "Signs": _SIGNS})


def _page(sections: Mapping[str, Sequence[tuple[str, str]]]) -> list[Content]:
    """Return sections with their titles, a blank line between them; empty ones are left out."""
    lines = []
    for title, rows in sections.items():
        if rows:
            lines += [content_line(""), content_line((title, STRONG)), *starmap(row, rows)]
    return lines[1:]


def row(key: str, text: str, style: str = STRONG) -> Content:
    """Return a sign with its meaning, in as many lines as that needs."""
    first, *more = wrap(text, _WIDE) or [""]
    head = content_line((f"{key:>{_KEYS}}  ", style), first)
    return Content("\n").join([head, *(content_line(" " * (_KEYS + 2) + each) for each in more)])
