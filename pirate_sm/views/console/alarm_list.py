"""The list of alarms: each in full, to be acknowledged one by one."""

from __future__ import annotations

from collections.abc import Sequence

from textual.widgets import OptionList

from pirate_sm.views.console.confirmed_actions import ConfirmedActions
from pirate_sm.views.console.dialogs import Pick, PickLine
from pirate_sm.views.showing.alarms import Alarm, alarms, pending

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
