"""What is pressed on a panel becomes the events that keys make."""

from __future__ import annotations

from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

from pirate_sm.core.effects import Ended
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import (
    Breakpoints,
    DetectorWord,
    Event,
    FaultReport,
    OperatorCommand,
    Pause,
    Resume,
    Skip,
    Step,
)
from pirate_sm.robot.control_panel.panel_file import Panel
from pirate_sm.robot.control_panel.panel_reader import Connection, Happening, PanelCompanion
from pirate_sm.robot.control_panel.presses import LinePress, Press

PANEL = Panel.model_validate(
    {
        "format": 1,
        "panel": "small",
        "device": "Small",
        "controls": {name: n for n, name in enumerate(["STOP", *"ABCDEFGHI"])},
        "buttons": {
            "STOP": {"do": "stop"},
            "A": {"do": "go"},
            "B": {"do": "pause"},
            "C": {"do": "step"},
            "D": {"do": "skip"},
            "E": {"command": "Grip"},
            "F": {"command": "LetGo"},
            "G": {"word": "near"},
            "H": {"answer": 2},
            "I": {"command": "LetGo", "twice": True},
        },
    }
)
COMMANDS = (SimpleNamespace(lets_go=False), SimpleNamespace(lets_go=True))
HOLDING, FREE = 0, 1


class Desk:
    """A panel on which the test presses, beside a robot that holds on or does not."""

    def __init__(
        self,
        *,
        speaks: str = "",
        keyboard: bool = False,
        begun: bool = True,
        watching: bool = True,
    ) -> None:
        self.buttons = PANEL.buttons.values()
        self.waiting: list[Happening] = []
        robot: Any = SimpleNamespace(
            commands=COMMANDS,
            table=SimpleNamespace(command_index={"Grip": 0, "LetGo": 1}),
            held=(frozenset({"front"}), frozenset()),
        )
        reader: Any = self
        self.companion = PanelCompanion(
            reader,
            robot,
            speaks=speaks,
            valid_for_s=1.5,
            keyboard=keyboard,
            watching=watching,
            places=self._place,
        )
        self.paused = False
        self.breakpoints: tuple[str, ...] = ()
        self.configuration = HOLDING
        if begun:
            self.hear([])

    def _place(self, line: str) -> str:
        if line.endswith(":99"):
            raise UsageError(f"{line}: nothing begins there")
        return f"{line}:5"

    def taken(self) -> list[Happening]:
        waiting, self.waiting = self.waiting, []
        return waiting

    def hear(
        self, happened: list[Happening], now_s: float = 10.0
    ) -> tuple[list[Event], list[tuple[str, str]]]:
        self.waiting += happened
        state: Any = SimpleNamespace(
            robot=SimpleNamespace(configuration=self.configuration),
            mission=SimpleNamespace(paused=self.paused, breakpoints=self.breakpoints),
        )
        logs = self.companion.look(state, now_s)
        return list(self.companion.speak(now_s)), [(each.level, each.message) for each in logs]

    def press(self, *names: str, now_s: float = 10.0) -> tuple[list[Event], list[tuple[str, str]]]:
        return self.hear([Press(name, PANEL.buttons[name]) for name in names], now_s)


def test_each_button_is_an_event_in_the_order_of_the_presses() -> None:
    events, logs = Desk().press("B", "E", "A", "C", "D", "G")
    assert events == [
        Pause(),
        OperatorCommand("Grip"),
        Resume(),
        Step(),
        Skip(),
        DetectorWord("near", 1.5),
    ]
    assert logs == []


def test_an_answer_is_a_key_for_whoever_asks_the_question() -> None:
    desk = Desk()
    assert desk.press("H") == ([], [])
    assert desk.companion.pressed() == "2"
    assert desk.companion.pressed() == ""


def test_what_was_pressed_before_the_run_is_not_meant_for_it() -> None:
    desk = Desk(begun=False)
    assert desk.press("E") == ([], [])
    assert desk.press("E") == ([OperatorCommand("Grip")], [])


def test_a_word_is_not_said_in_place_of_a_detector_that_speaks() -> None:
    events, logs = Desk(speaks="odometry").press("G")
    assert events == []
    assert logs == [("warning", "'near' on the panel is ignored: the detector is odometry")]


def test_a_command_that_lets_go_of_the_pipe_is_pressed_twice() -> None:
    desk = Desk()
    events, logs = desk.press("F", now_s=10.0)
    assert events == []
    text = "press F again within 3 s: LetGo, after which nothing holds the robot"
    assert logs == [("warning", text)]
    assert desk.press("F", now_s=12.9) == ([OperatorCommand("LetGo")], [])
    assert desk.press("F", now_s=13.0)[0] == []
    assert desk.press("F", now_s=16.1)[0] == []


def test_another_press_takes_the_question_back() -> None:
    desk = Desk()
    desk.press("F")
    desk.press("E")
    assert desk.press("F")[0] == []


def test_another_button_that_asks_takes_the_question_back_too() -> None:
    desk = Desk()
    desk.press("F")
    desk.hear([Press("I", PANEL.buttons["I"], asks=True)])
    assert desk.press("F")[0] == []


def test_where_nothing_holds_nothing_is_asked() -> None:
    desk = Desk()
    desk.configuration = FREE
    assert desk.press("F") == ([OperatorCommand("LetGo")], [])


def test_a_button_that_asked_already_does_not_ask_again() -> None:
    desk = Desk()
    asks = Press("I", PANEL.buttons["I"], asks=True)
    assert desk.hear([asks]) == ([], [("warning", "press I again within 3 s: LetGo")])
    assert desk.press("I") == ([OperatorCommand("LetGo")], [])


LOST, BACK = (
    Connection("lost", "the panel is disconnected: unplugged"),
    Connection("back", "it is back"),
)


def test_a_loss_is_a_fault_where_nobody_has_a_keyboard() -> None:
    desk = Desk()
    assert desk.hear([LOST]) == (
        [FaultReport("panel.lost", "the panel is disconnected: unplugged")],
        [],
    )
    assert desk.hear([BACK]) == ([], [("info", "it is back")])


def test_a_loss_is_a_warning_beside_a_keyboard() -> None:
    assert Desk(keyboard=True).hear([LOST]) == (
        [],
        [("warning", "the panel is disconnected: unplugged")],
    )


def test_a_loss_before_the_first_look_is_not_forgotten() -> None:
    desk = Desk(begun=False)
    assert [type(each) for each in desk.hear([LOST])[0]] == [FaultReport]


def test_a_panel_is_read_every_20_ms_until_the_run_ends() -> None:
    desk = Desk()
    desk.press("E", now_s=10.0)
    assert desk.companion.due_s == pytest.approx(10.02)
    assert desk.companion.listening
    desk.companion.react([Ended("succeeded", "done")], 11.0)
    assert desk.companion.due_s == inf
    assert not desk.companion.listening


def test_events_say_that_they_were_asked_for_on_a_page() -> None:
    names = ("A", "B", "C", "G")
    presses: list[Happening] = [Press("page", PANEL.buttons[name], by="page") for name in names]

    events, _ = Desk().hear(presses)

    assert events == [
        Resume("page"),
        Pause("page"),
        Step("page"),
        DetectorWord("near", 1.5, "page"),
    ]
    _, logs = Desk(speaks="odometry").hear(presses[-1:])
    assert logs == [("warning", "'near' on the page is ignored: the detector is odometry")]


def test_where_people_need_not_watch_only_a_paused_mission_waits_for_them() -> None:
    desk = Desk(watching=False)
    assert not desk.companion.listening

    desk.paused = True
    desk.hear([])
    assert desk.companion.listening
    desk.companion.react((Ended("succeeded", "there"),), 11.0)
    assert not desk.companion.listening


def test_lines_of_the_page_are_breakpoints_and_runs_to_them() -> None:
    desk = Desk()
    desk.breakpoints = ("m.yaml:3:5",)

    events, logs = desk.hear(
        [
            LinePress("break", "m.yaml:4", "page"),
            LinePress("break", "m.yaml:99", "page"),
            LinePress("break", "m.yaml:3", "page"),
            LinePress("until", "m.yaml:8", "page"),
        ]
    )

    assert events == [
        Breakpoints(("m.yaml:3:5", "m.yaml:4:5"), "page"),
        Breakpoints(("m.yaml:4:5",), "page"),
        Resume("page", "m.yaml:8:5"),
    ]
    assert logs == [("warning", "breakpoint at m.yaml:99: nothing begins there")]
