"""Gives the engine what is pressed on a panel, in a run without the console."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from pirate_sm.core.effects import Effect, Ended, Log
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import (
    BuiltInFault,
    DetectorWord,
    Event,
    OperatorCommand,
    Pause,
    Resume,
    Skip,
    Step,
)
from pirate_sm.core.panel import AnswerButton, CommandButton, RunAction, RunButton, WordButton
from pirate_sm.core.robot import RobotSpec, lets_all_go
from pirate_sm.robot.control_panel.panel_reader import Connection, PanelReader
from pirate_sm.robot.control_panel.presses import TWICE_WITHIN_S, Press, action_text

LOOK_EVERY_S = 0.02
"""The longest delay of a press, except for a stop, which needs no companion."""

_EVENTS: dict[RunAction, Event] = {"go": Resume(), "pause": Pause(), "step": Step(), "skip": Skip()}


class PanelCompanion:
    """A companion that reads a panel.

    A command that lets go of the pipe must be pressed twice, whatever the panel's file says: the
    console would ask too.

    Args:
        reader: The panel, which is entered as long as the run goes on.
        robot: The robot.
        speaks: The detector that says the words, so that the panel may not; empty if none does.
        valid_for_s: How long a word is valid.
        keyboard: Whether a person also has a keyboard. Otherwise the loss of the panel is a fault.

    Attributes:
        listening: True until the run ends, because a person is watching the robot.
        says_words: Whether the panel has buttons for words; likewise ``answers``.
    """

    def __init__(
        self,
        reader: PanelReader,
        robot: RobotSpec,
        *,
        speaks: str,
        valid_for_s: float,
        keyboard: bool,
    ) -> None:
        self.due_s = 0.0
        self.listening = True
        buttons = reader.panel.buttons.values()
        self.says_words = any(isinstance(each, WordButton) for each in buttons)
        self.answers = any(isinstance(each, AnswerButton) for each in buttons)
        self._reader = reader
        self._robot = robot
        self._speaks = speaks
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
        for happening in self._reader.taken():
            if isinstance(happening, Connection):
                self._connection(happening)
            elif not self._began:
                continue  # it was pressed before this run
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
                self._events.append(_EVENTS[action])
            case CommandButton(command=command):
                again = asked[0] == press.name and now_s <= asked[1] + TWICE_WITHIN_S
                sure = again or press.button.twice
                if sure or not lets_all_go(self._robot, state.robot, command):
                    self._events.append(OperatorCommand(command))
                else:
                    self._asked = press.name, now_s
                    self._ask(press.name, f"{command}, after which nothing holds the robot")
            case WordButton(word=word) if self._speaks:
                said = f"'{word}' on the panel is ignored: the detector is {self._speaks}"
                self._logs.append(Log("warning", said))
            case WordButton(word=word):
                self._events.append(DetectorWord(word, self._valid_for_s))
            case AnswerButton(answer=number):
                self._keys += str(number)

    def _ask(self, name: str, what: str) -> None:
        text = f"press {name} again within {TWICE_WITHIN_S:g} s: {what}"
        self._logs.append(Log("warning", text))
