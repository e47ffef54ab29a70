"""Acts on what is pressed on a control panel, as on keys; a stop does not come this way."""

from __future__ import annotations

from time import monotonic
from typing import assert_never

from pirate_sm.core.panel import AnswerButton, Button, CommandButton, RunButton, WordButton
from pirate_sm.robot.control_panel.panel_reader import Connection, PanelReader
from pirate_sm.robot.control_panel.presses import TWICE_WITHIN_S, Press, action_text
from pirate_sm.views.console.dialogs import Confirm
from pirate_sm.views.console.key_bindings import CONTROLS
from pirate_sm.views.console.operator_actions import OperatorActions


class PanelActions(OperatorActions):
    """The part of the console that heeds a control panel.

    Attributes:
        panel: The panel, opened; None if there is none.
    """

    panel: PanelReader | None = None

    def heed_panel(self) -> None:
        """Act on what has happened on the panel since the last call."""
        for happening in self.panel.taken() if self.panel is not None else ():
            match happening:
                case Connection("lost", message):
                    self.notify(message, severity="warning", timeout=10, markup=False)
                case Connection(_, message):
                    self.notify(message, timeout=10, markup=False)
                case Press(name, button, asks=True):
                    what = f"press {name} again within {TWICE_WITHIN_S:g} s"
                    self._refuse(action_text(button), what)
                case Press(_, button):
                    self._press(button)
                case _:
                    assert_never(happening)

    def _press(self, button: Button) -> None:
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
                self.action_control(control)
            case CommandButton(command=command):
                self.action_command(command)
            case WordButton(word=word):
                self.action_word(word)
            case AnswerButton(answer=number):
                self.action_answer(number)
            case _:
                assert_never(button)
