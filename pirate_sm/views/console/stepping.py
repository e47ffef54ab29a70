"""Breakpoints in the console: the list of them, and running on to a line."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import ClassVar

from textual.binding import Binding, BindingType
from textual.widgets import OptionList

from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import Breakpoints
from pirate_sm.robot.control_panel.presses import LinePress
from pirate_sm.running.runtime.breakpoints import Breakable, breakables, breakpoints
from pirate_sm.views.console import availability
from pirate_sm.views.console.dialogs import Pick, PickLine
from pirate_sm.views.console.hand_back import HandBackActions
from pirate_sm.views.showing.snapshot import Snapshot


class BreakpointList(Pick):
    """Shows where the mission can pause; choosing a line sets or clears a breakpoint.

    Args:
        lines: Returns the lines as they are now.
        toggle: Sets or clears the breakpoint at a place.
        run_to: Runs on to a place.
        at: The line that is marked first.
    """

    keys = "↑ ↓ Enter: set, clear   >: run to here   Esc leaves"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("greater_than_sign", "run_here", "Run to here", key_display=">")
    ]

    def __init__(
        self,
        lines: Callable[[], Sequence[PickLine]],
        toggle: Callable[[str], None],
        run_to: Callable[[str], None],
        at: int,
    ) -> None:
        self._lines, self._toggle, self._run_to = lines, toggle, run_to
        found = lines()
        super().__init__("Breakpoints ●", found, max(len(each.label) for each in found), at)

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Set or clear the breakpoint; the list stays open."""
        event.prevent_default()
        self._toggle(self._choices[event.option_index].name)

    def action_run_here(self) -> None:
        """Run to the marked line."""
        place = self._choices[self._marked].name
        self.dismiss(None)
        self._run_to(place)

    def renew(self) -> None:
        """Show what is so now."""
        if self.is_mounted:
            self.replace(self._lines())


class SteppingActions(HandBackActions):
    """The list of breakpoints, and what is asked for in it."""

    def action_breakpoints(self) -> None:
        """Show where the mission can pause."""
        snapshot = self.session.latest
        if reason := why_not_break(snapshot):
            self._refuse("breakpoints", reason)
            return
        places, state = breakables(snapshot.scene.loaded), snapshot.state
        pc = state.mission.pc if state is not None else 0
        here = snapshot.scene.loaded.program.instructions[pc].place
        at = next((n for n, each in enumerate(places) if str(each.place) == here), 0)
        listed = BreakpointList(
            lambda: break_lines(places, self.session.latest), self.toggle, self.run_to, at
        )
        self.push_screen(listed)

    def toggle(self, place: str, by: str = "") -> None:
        """Set the breakpoint at a place, or clear it."""
        snapshot = self.session.latest
        if (reason := why_not_break(snapshot)) or snapshot.state is None:
            self._refuse("breakpoints", reason)
            return
        before = snapshot.state.mission.breakpoints
        kept = tuple(each for each in before if each != place)
        at = kept if place in before else (*before, place)
        self.session.give_event(Breakpoints(at, by))

    def run_to(self, place: str, by: str = "") -> None:
        """Start or resume the mission; it pauses before the place."""
        self.session.giver.stop()
        snapshot = self.session.latest
        go = availability.controls(snapshot, self.starts(snapshot))[0]
        if go.reason or snapshot.stopped_in:
            choose = f"it was stopped: choose the phase with {go.key} first"
            self._refuse("run to here", go.reason or choose)
            return
        event = availability.going_on(snapshot)._replace(by=by, until=place)
        self._agree(partial(self.session.give_event, event))

    def press_line(self, press: LinePress) -> None:
        """Do what is asked for at a line of the mission's file."""
        try:
            (place,) = breakpoints(self.session.latest.scene.loaded, [press.line])
        except UsageError as error:
            self._refuse(*f"{press.what} {error}".split(": ", 1))
            return
        if len(self.screen_stack) > 1:
            self._refuse(f"{press.what} {press.line}", "a dialog is open")
        else:
            (self.toggle if press.do == "break" else self.run_to)(place, press.by)


def why_not_break(snapshot: Snapshot) -> str:
    """Return why no breakpoint can be set now; empty if one can."""
    if snapshot.over or snapshot.state is None:
        return availability.OVER if snapshot.over else availability.OPENING
    return "" if snapshot.scene.mission else availability.NO_MISSION


def break_lines(places: Sequence[Breakable], snapshot: Snapshot) -> list[PickLine]:
    """Return a line of the list for each of the places."""
    at = snapshot.state.mission.breakpoints if snapshot.state is not None else ()
    own = snapshot.scene.loaded.documents[0].name
    found = []
    for each in places:
        file = "" if each.place.file == own else f"{each.place.file.rpartition('/')[2]}:"
        mark = "●" if str(each.place) in at else " "
        found.append(PickLine(str(each.place), f"{mark} {file}{each.line}", each.text))
    return found
