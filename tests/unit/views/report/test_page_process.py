"""A run and the process of its page: what is heard, and that nothing of it disturbs the run."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Event
from typing import Any

import pytest

from pirate_sm.core.effects import Effect, Log, PhaseChange
from pirate_sm.core.errors import UsageError
from pirate_sm.robot.control_panel.panel_file import RunButton, WordButton
from pirate_sm.robot.control_panel.panel_reader import Connection
from pirate_sm.robot.control_panel.presses import LinePress, Press
from pirate_sm.views.report import page_process
from pirate_sm.views.report.page_process import MOST_A_SECOND, PageProcess

SAID = 'import sys\nprint(\'{"address": "http://here/#x"}\', flush=True)\n'


class Desk:
    """The page of a run whose process is a script of the test."""

    def __init__(self, script: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        played = tmp_path / "played_page.py"
        played.write_text(script)
        monkeypatch.syspath_prepend(str(tmp_path))
        monkeypatch.setenv("PYTHONPATH", str(tmp_path))
        monkeypatch.setattr(page_process, "__name__", "played_page")
        self.reasons: list[str] = []
        self.stopped = Event()
        self.page = PageProcess(["near"], self._end)

    def _end(self, reason: str) -> None:
        self.reasons.append(reason)
        self.stopped.set()

    def rest(self) -> list[Any]:
        """All that has happened when nothing more can come."""
        self.page._thread.join(30)
        return self.page.taken()


@pytest.fixture
def played(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], Desk]]:
    """Gives the page of a run whose process does this after it has said its address."""
    desks: list[Desk] = []

    def play(script: str) -> Desk:
        desks.append(Desk(SAID + script, tmp_path, monkeypatch))
        return desks[-1]

    yield play
    for desk in desks:
        desk.page.__exit__()
        desk.page._process.wait()


def test_presses_are_those_of_buttons_and_a_stop_acts_by_itself(
    played: Callable[[str], Desk],
) -> None:
    desk = played("print('pause\\ncontinue\\nword near\\nstop', flush=True)")

    happened = desk.rest()

    assert desk.page.address == "http://here/#x"
    assert desk.reasons == ["stopped on the page"]
    assert happened[:-1] == [
        Press("page", RunButton(do="pause"), by="page"),
        Press("page", RunButton(do="go"), by="page"),
        Press("page", WordButton(word="near"), by="page"),
    ]


def test_lines_of_the_mission_are_pressed_too(played: Callable[[str], Desk]) -> None:
    desk = played("print('break m.yaml:28\\nuntil a b.yaml:3', flush=True)")

    assert desk.rest()[:-1] == [
        LinePress("break", "m.yaml:28", "page"),
        LinePress("until", "a b.yaml:3", "page"),
    ]


def test_a_press_that_comes_with_the_address_is_heard(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk = Desk(
        """print('{"address": "http://here/#x"}\\nstop', flush=True)""", tmp_path, monkeypatch
    )
    desk.rest()
    assert desk.reasons == ["stopped on the page"]
    desk.page.__exit__()
    desk.page._process.wait()


@pytest.mark.parametrize(
    "sent",
    [
        "b'launch\\n'",
        "b'stop'",
        "b'break m.yaml\\n'",
        "b'break a:b:3\\n'",
        "b'until m.yaml:3;stop\\n'",
        "b'\\xff\\xfe\\n'",
        "b'x' * 1_000_000",
        "b'pause\\n' * 1_000_000",
        "b''",
    ],
)
def test_a_process_that_dies_floods_or_sends_what_is_no_press_is_lost_and_no_more(
    played: Callable[[str], Desk], sent: str
) -> None:
    desk = played(f"sys.stdout.buffer.write({sent})\nsys.stdout.flush()")

    *before, last = desk.rest()

    assert isinstance(last, Connection)
    assert last.state == "lost"
    assert last.message.startswith("the page cannot be used any more: ")
    assert len(before) <= MOST_A_SECOND
    assert desk.reasons == []


def test_a_flood_of_stops_stops_the_run(played: Callable[[str], Desk]) -> None:
    desk = played("sys.stdout.buffer.write(b'stop\\n' * 1_000)\nsys.stdout.flush()")
    assert isinstance(desk.rest()[-1], Connection)
    assert set(desk.reasons) == {"stopped on the page"}


def test_a_process_that_says_nothing_is_not_waited_for_for_ever(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page_process, "_PATIENCE_S", 0.2)
    for script in ("import time\ntime.sleep(60)", "print('hello')", ""):
        with pytest.raises(UsageError, match="its process does not answer"):
            Desk(script, tmp_path, monkeypatch)


def test_a_recording_is_shown_at_once_and_a_later_one_at_the_first_deed_of_its_run(
    played: Callable[[str], Desk], tmp_path: Path
) -> None:
    seen = tmp_path / "seen"
    desk = played(
        f"for line in sys.stdin:\n    with open({str(seen)!r}, 'a') as out: out.write(line)"
    )

    def tell(companion: Any, *effects: Effect) -> None:
        companion.react(effects, 1.0)

    forecast = tmp_path / "times.yaml"
    desk.page.follow(tmp_path / "1.mcap")
    second = desk.page.follow(tmp_path / "2.mcap")
    tell(second, Log("info", "the operator has control"))
    third = desk.page.follow(tmp_path / "3.mcap", forecast)
    tell(third, PhaseChange("drive"))
    tell(third, PhaseChange("halt"))
    desk.page.__exit__()
    desk.page._process.wait()

    lines = [json.loads(line) for line in seen.read_text().splitlines()]
    assert lines == [[str(tmp_path / "1.mcap"), None], [str(tmp_path / "3.mcap"), str(forecast)]]


def test_nothing_waits_for_a_process_that_takes_nothing(played: Callable[[str], Desk]) -> None:
    desk = played("import time\ntime.sleep(600)")
    for number in range(20_000):
        desk.page.follow(Path(f"/a/{number}")).react([PhaseChange("drive")], 0.0)
    desk.page._process.kill()


def test_the_interpreter_is_that_of_the_run(played: Callable[[str], Desk]) -> None:
    desk = played("sys.exit()")
    assert desk.page._process.args[0] == sys.executable  # type: ignore[index]
