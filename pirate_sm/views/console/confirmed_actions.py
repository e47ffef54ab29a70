"""Asks the operator before the robot moves, shows why a request is refused, and lists alarms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from textual.widgets import OptionList

from pirate_sm.core.events import Event
from pirate_sm.views.console.availability import UNHEARD
from pirate_sm.views.console.dialogs import READ_AFTER_S, Confirm, Dialog, Pick, PickLine
from pirate_sm.views.showing.alarms import Alarm, alarms, pending

if TYPE_CHECKING:
    from textual.app import App

    from pirate_sm.views.console.session import OperatorSession

    _Base = App[None]
else:
    _Base = object

# --- confirmations ------------------------------------------------------------------------------


_R = TypeVar("_R")


class ConfirmedActions(_Base):
    """Actions that the operator must confirm first.

    Attributes:
        read_after_s: How long after a dialog has been drawn it can have been read.
    """

    session: OperatorSession
    read_after_s = READ_AFTER_S
    _agreed = False

    def is_unread(self, acted_s: float) -> bool:
        """Return whether a dialog is open that nobody can have read at that monotonic time, s."""
        dialog = self.screen_stack[-1] if self.screen_stack else None
        return isinstance(dialog, Dialog) and acted_s < dialog.drawn_s + self.read_after_s

    def is_outdated(self, dialog: Dialog[_R]) -> bool:
        """Return whether the run that its answer would move was stopped, or has ended."""
        run = dialog.run
        return run is not None and (run.stop is not None or run is not self.session.quitting.run)

    def _open(self, dialog: Dialog[_R], then: Callable[[_R | None], None]) -> None:
        """Open a dialog that can move the robot.

        Its answer does not count once it is outdated, nor while the robot is not heard, since it
        would be obeyed whenever the robot comes back.
        """
        dialog.run = self.session.quitting.run

        def answered(said: _R | None) -> None:
            if said and self.session.latest.unheard_s:
                self._refuse("not given", UNHEARD)
                said = None
            then(None if self.is_outdated(dialog) else said)

        self.push_screen(dialog, answered)

    def _ask(self, question: str, yes: str, then: Callable[[], None]) -> None:
        """Act once the operator has said yes; immediately if there is no question."""
        if question:
            self._open(Confirm(question, yes), lambda said: then() if said else None)
        else:
            then()

    def _move(self, event: Event) -> None:
        """Give the engine an event once the operator has confirmed that the robot may move."""
        self._agree(partial(self.session.give_event, event))

    def _may_move(self) -> bool:
        """Return whether the operator need not be asked whether the robot may move."""
        return self._agreed or not self.session.prepared.confirmation

    def _agree(self, move: Callable[[], None]) -> None:
        """Move the robot once the operator has confirmed that it may."""
        question = self.session.prepared.confirmation
        if self._may_move():
            move()
            return

        def answered(yes: bool | None) -> None:
            self._agreed = bool(yes)
            if yes:
                move()

        self._open(Confirm(f"{question}. Is it free to?", "It is free"), answered)

    def _refuse(self, what: str, reason: str) -> None:
        self.notify(f"{what}: {reason}", severity="warning", timeout=4, markup=False)


# --- alarms -------------------------------------------------------------------------------------


_HEADING = "Alarms, the newest first; 1st: of its cascade"


class AlarmList(Pick):
    """Shows alarms; choosing one acknowledges it."""

    keys = "↑ ↓ Enter: seen   Esc leaves"

    def __init__(self, found: Sequence[Alarm], seen: set[int]) -> None:
        self._alarms = list(reversed(found))
        self._seen = seen
        lines = self._lines()
        super().__init__(_HEADING, lines, max(len(each.label) for each in lines))

    def _lines(self) -> list[PickLine]:
        return [_line(each, seen=each.entry.number in self._seen) for each in self._alarms]

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Acknowledge the alarm."""
        self._seen.add(self._alarms[event.option_index].entry.number)
        self.replace(self._lines())


def _line(alarm: Alarm, *, seen: bool) -> PickLine:
    mark = "1st" if alarm.first else "   "
    state = "seen" if seen else "over" if alarm.over else "new "
    label = f"{mark} {state} {alarm.entry.now_s:8.1f} s"
    return PickLine(str(alarm.entry.number), label, alarm.text)


class AlarmActions(ConfirmedActions):
    """The bar of alarms, and the list of all of them.

    Attributes:
        seen: Numbers of the alarms that the operator has acknowledged.
    """

    seen: set[int]

    def acknowledge(self) -> None:
        """Acknowledge what the bar shows."""
        self.seen.update(each.entry.number for each in pending(self.session.latest, self.seen))

    def action_alarms(self) -> None:
        """Show every alarm."""
        found = alarms(self.session.latest, self.seen)
        if found:
            self.push_screen(AlarmList(found, self.seen))
        else:
            self.notify("no alarm so far", timeout=3, markup=False)
