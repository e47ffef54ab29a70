"""Acts on keys, clicked rows, the command palette and a control panel.

What is pressed on a panel counts as a key; a stop does not come this way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import chain
from math import inf, isnan
from signal import SIGHUP
from time import monotonic
from typing import Any, assert_never

from textual.app import SystemCommand
from textual.worker import Worker, WorkerState

from pirate_sm.core.errors import PirateError
from pirate_sm.core.events import (
    Answer,
    DetectorWord,
    Event,
    Observation,
    OperatorCommand,
    Pause,
    Skip,
    Step,
)
from pirate_sm.core.robot import lets_all_go
from pirate_sm.robot.control_panel.panel_file import (
    AnswerButton,
    Button,
    CommandButton,
    RunButton,
    WordButton,
)
from pirate_sm.robot.control_panel.panel_reader import Connection, PressSource
from pirate_sm.robot.control_panel.presses import TWICE_WITHIN_S, LinePress, Press, action_text
from pirate_sm.running.runtime.ending import BY_SIGNAL
from pirate_sm.views.console import availability
from pirate_sm.views.console.availability import CONTROLS, ways
from pirate_sm.views.console.checklist import Checklist
from pirate_sm.views.console.confirmed_actions import AlarmActions
from pirate_sm.views.console.dialogs import Confirm, ObservationDialog
from pirate_sm.views.console.driving import (
    FIRST_REPEAT_S,
    NEXT_REPEAT_S,
    SaidPlace,
    came_m,
    is_still,
    place_m,
)
from pirate_sm.views.console.hand_back import FAULT
from pirate_sm.views.console.missions import MissionActions
from pirate_sm.views.console.stepping import SteppingActions, why_not_break
from pirate_sm.views.console.terminal_driver import STOP_KEY
from pirate_sm.views.showing.panels import choices

# --- keys, rows and the palette -----------------------------------------------------------------


_ASKED = {
    "entries": "where the mission can start is",
    "ways": "commands that restore a phase are",
    "missions": "the missions are",
    "load": "the mission is",
}
"""What each kind of worker finds out."""


class OperatorActions(SteppingActions, MissionActions, AlarmActions):
    """The acting half of the console; every refusal is shown with the engine's reason.

    Attributes:
        pressed_s: When the last key was pressed, by the monotonic clock.
        late_after_s: From which age on a key does not drive any more.
        faults: The exceptions that left a question unanswered, but did not end the console.
    """

    letters: dict[str, str]
    faults: list[Exception]

    pressed_s = _drove_s = -inf
    late_after_s = NEXT_REPEAT_S
    _wants_to_go: str | None = None

    # --- the stop -----------------------------------------------------------------------------

    def stop_now(self) -> None:
        """Send the robot to its safe state; may be called from any thread."""
        self.session.stop()

    def leave_now(self) -> None:
        """Send the robot to its safe state and leave, because the terminal has gone."""
        self.session.quit(BY_SIGNAL[SIGHUP])

    def action_stop(self) -> None:
        """Send the robot to its safe state."""
        self.stop_now()

    def action_leave(self) -> None:
        """Go to the safe state and leave; at the second request leave immediately."""
        quitting = self.session.quitting
        if quitting.stop is not None:
            quitting.insist()
        self.session.quit()
        if self.session.latest.over:
            self.exit()

    # --- commands and words -------------------------------------------------------------------

    def on_request_row_clicked(self, message: object) -> None:
        """Act on a clicked row."""
        name = str(getattr(message, "name", ""))
        known = name in self.session.latest.scene.robot.table.command_index
        (self.action_command if known else self.action_control)(name)

    def action_command(self, name: str) -> None:
        """Give the robot a command if the engine accepts it; end a series of commands."""
        self.session.giver.stop()
        snapshot = self.session.latest
        driving = self.session.driving
        reason = availability.command_reason(snapshot, name) or driving.why_not(name)
        if reason:
            self._refuse(name, reason)
            return
        share = driving.speed if name in ways(snapshot.scene.robot) else 1.0
        give = partial(self._move, OperatorCommand(name, share, at_once=True))
        robot, state = snapshot.scene.robot, snapshot.state
        if state is not None and lets_all_go(robot, state.robot, name):
            question = f"{name} releases the pipe: nothing holds the robot then. Release it?"
            self._ask(question, "Let go", give)
        else:
            doubt = availability.drive_doubt(snapshot, name)
            self._ask(f"{doubt}. Give {name} anyway?" if doubt else "", "Drive", give)

    def action_drive(self, name: str) -> None:
        """Drive for as long as the key is held; act on each repeat of it."""
        driving, now_s = self.session.driving, monotonic()
        if now_s > self.pressed_s + self.late_after_s:
            return  # a slow terminal has kept the console from it; the key may be released by now
        again, self._drove_s = now_s < self._drove_s + FIRST_REPEAT_S, now_s
        self.session.giver.stop()
        reason = availability.command_reason(self.session.latest, name) or driving.why_not(name)
        if not reason and (doubt := availability.drive_doubt(self.session.latest, name)):
            reason = f"{doubt} ({self.letters.get(name, '^p')} asks and drives)"
        if not (again or reason or self._may_move()):
            self._agree(lambda: None)  # no drive begins with the answer, only with a key held
        elif driving.holds(name) or not reason:
            driving.press(name)
        elif not again:
            self._refuse(name, reason)

    def on_app_blur(self) -> None:
        """Stop what a held key drives: its release will not be seen."""
        self.session.driving.release()

    def action_faster(self, steps: int) -> None:
        """Choose another speed for the next drive."""
        self.session.driving.faster(steps)

    def action_limit(self) -> None:
        """Choose where the next drive stops."""
        self.session.driving.other_limit()

    # --- before anything moves ----------------------------------------------------------------

    def action_preflight(self) -> None:
        """Show the checks of the open link until they are passed."""
        link, latest = self.session.prepared.open_link, self.session.latest
        if link is None:
            self._refuse("pre-flight", "this robot is not at the other end of a serial link")
        elif latest.over or latest.state is None:
            self._refuse("pre-flight", availability.OVER if latest.over else availability.OPENING)
        else:
            self.push_screen(Checklist(link))

    # --- where the robot is -------------------------------------------------------------------

    @property
    def typing(self) -> bool:
        """Whether a text is being typed, so that the stop key is a letter; nothing moves then."""
        return bool(self.screen_stack) and isinstance(self.screen_stack[-1], ObservationDialog)

    def action_say(self) -> None:
        """Let the operator type where the robot is and what is seen."""
        if is_still(self.session.latest):
            self.push_screen(ObservationDialog(), self._say)
        else:
            self._refuse("a place", "it can be typed while nothing moves and nothing runs")

    def _say(self, said: Observation | None) -> None:
        if said is None:
            return
        latest, driving = self.session.latest, self.session.driving
        if isnan(said.place_m):
            said = said._replace(place_m=place_m(latest, driving.place))
        else:
            driving.place = SaidPlace(said.place_m, came_m(latest))
        self.session.give_event(said)
        if said.text and not latest.scene.mission:
            self._refuse("not recorded", "the robot by hand is not; choose a mission first")

    def action_word(self, word: str, by: str = "") -> None:
        """Send one of the detector's words instead of a detector; ``by`` says from where."""
        prepared = self.session.prepared
        if prepared.others_words:
            self._refuse(word, f"the detector speaks for itself ({prepared.others_words})")
            return
        valid_for_s = prepared.loaded.loaded_robot.profile.detector.valid_for
        self.session.give_event(DetectorWord(word, valid_for_s, by))

    def action_answer(self, number: int) -> None:
        """Give the mission the answer with this number."""
        _, offered = choices(self.session.latest)
        if 1 <= number <= len(offered):
            self.session.give_event(Answer(offered[number - 1]))

    # --- the mission --------------------------------------------------------------------------

    def action_control(self, name: str, by: str = "") -> None:
        """Start, pause or resume the mission, if possible; end a series of commands.

        Args:
            name: What is asked for.
            by: Where, as events record it; empty at the keyboard and on a panel.
        """
        self.session.giver.stop()
        snapshot = self.session.latest
        control = next(
            each
            for each in availability.controls(snapshot, self.starts(snapshot))
            if each.name == name
        )
        if name == "go" and control.reason == availability.LOOKING:
            self._wants_to_go = by
            self.notify("starts as soon as the check has looked at it", timeout=4, markup=False)
        elif control.reason:
            self._refuse(control.label, control.reason)
        elif name == "hand_back" or (name == "go" and snapshot.stopped_in):
            self._choose_phase(snapshot)
        elif name == "abort":
            self.session.stop()
        elif name == "pause":
            self.session.give_event(Pause(by))
        else:
            events: dict[str, Event] = {"step": Step(by), "skip": Skip()}
            self._move(events.get(name) or availability.going_on(snapshot)._replace(by=by))

    # --- where a mission can be handed back ----------------------------------------------------

    def on_worker_state_changed(self, event: Worker.StateChanged) -> None:
        """Take in the result of a worker, or show why it failed."""
        worker, error = event.worker, event.worker.error
        if event.state is WorkerState.ERROR and isinstance(error, PirateError):
            self.notify(error.for_terminal, severity="error", timeout=10, markup=False)
        elif event.state is WorkerState.ERROR and isinstance(error, Exception):
            self._note_fault(worker.group, error)
        elif event.state is WorkerState.SUCCESS:
            self._take_in(worker.group, worker.result)

    def _note_fault(self, what: str, error: Exception) -> None:
        """Show, once, an internal error that left a question unanswered."""
        reason = (str(error).strip() or type(error).__name__).splitlines()[-1]
        said = f"{_ASKED[what]} not known: {FAULT} ({reason})"
        if repr(error) not in map(repr, self.faults):
            self.faults.append(error)
            self.notify(said, severity="error", timeout=10, markup=False)
        if what == "entries":
            self._search_failed_in = self._situation
            phases = self.session.latest.scene.loaded.program.phases
            self._take_in(what, dict.fromkeys(phases, said))
        elif what == "ways":
            self._search_failed_in = self._searched

    def _take_in(self, what: str, found: Any) -> None:
        if what == "entries":
            self._entries = found
            if self._wants_to_go is not None:
                by, self._wants_to_go = self._wants_to_go, None
                self.action_control("go", by)
        elif what == "ways":
            self._ways = found
        elif what == "missions":
            self._choose_mission(found)
        elif what == "load":
            self._take_up(found)

    # --- which mission ------------------------------------------------------------------------

    def action_seen(self) -> None:
        """End a series of commands; else acknowledge the alarms that the bar shows."""
        series = self.session.giver.series
        if series is not None and series.active:
            self.session.giver.stop()
            return
        self.acknowledge()

    def palette(self) -> Iterable[SystemCommand]:
        """Yield all commands, with the reason for those that are not available."""
        snapshot = self.session.latest
        yield SystemCommand("Stop", f"Safe state immediately ({STOP_KEY})", self.action_stop)
        ask: Callable[[str], None] = self.action_command
        for name in snapshot.scene.loaded.loaded_robot.profile.commands:
            reason = availability.command_reason(snapshot, name)
            yield SystemCommand(name, reason or "Command", partial(ask, name))
        for control in availability.controls(snapshot, self.starts(snapshot)):
            go = partial(self.action_control, control.name)
            yield SystemCommand(control.label, control.reason or "Mission", go)
        yield SystemCommand("Pre-flight", "Check the open link", self.action_preflight)
        yield SystemCommand("Alarms", "Every alarm in full", self.action_alarms)
        yield SystemCommand("Missions", "Choose a mission", self.action_missions)
        reason = why_not_break(snapshot)
        yield SystemCommand("Breakpoints", reason or "Where it pauses", self.action_breakpoints)
        for word in snapshot.scene.robot.detector_words:
            yield SystemCommand(f"Detector: {word}", "Say it", partial(self.action_word, word))


# --- a control panel and the page ---------------------------------------------------------------


class PanelActions(OperatorActions):
    """The part of the console that heeds a control panel, and the page of its runs.

    Attributes:
        pressed: Where buttons are pressed.
    """

    pressed: Sequence[PressSource] = ()

    def heed_panel(self) -> None:
        """Act on what has been pressed since the last call."""
        for happening in chain.from_iterable(each.taken() for each in self.pressed):
            match happening:
                case Connection("lost", message):
                    self.notify(message, severity="warning", timeout=10, markup=False)
                case Connection(_, message):
                    self.notify(message, timeout=10, markup=False)
                case Press(name, button, asks=True):
                    what = f"press {name} again within {TWICE_WITHIN_S:g} s"
                    self._refuse(action_text(button), what)
                case LinePress():
                    self.press_line(happening)
                case Press(_, button, by=by):
                    self._press(button, by)
                case _:
                    assert_never(happening)

    def _press(self, button: Button, by: str) -> None:
        """Do what the button does; while a dialog is open, only answers count."""
        dialog = self.screen if len(self.screen_stack) > 1 else None
        unread = self.is_unread(monotonic())
        if isinstance(dialog, Confirm) and isinstance(button, AnswerButton) and not unread:
            dialog.action_answer(button.answer == 1)
            return
        if dialog is not None:
            self._refuse(action_text(button), "a dialog is open")
            return
        match button:
            case RunButton(do="go") if self.session.latest.stopped_in:
                self.session.giver.stop()
                key = CONTROLS["go"]
                reason = f"it was stopped: choose the phase with {key} at the keyboard"
                self._refuse(action_text(button), reason)
            case RunButton(do=control):
                self.action_control(control, by)
            case CommandButton(command=command):
                self.action_command(command)
            case WordButton(word=word):
                self.action_word(word, by)
            case AnswerButton(answer=number):
                self.action_answer(number)
            case _:
                assert_never(button)
