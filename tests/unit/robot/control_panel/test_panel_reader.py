"""A panel behind a pseudo-terminal: its thread stops at once, and survives whatever comes."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from queue import Queue
from threading import Event, active_count
from typing import Any

import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.robot.control_panel import panel_reader
from pirate_sm.robot.control_panel.panel_file import Panel
from pirate_sm.robot.control_panel.panel_reader import Connection, Happening, PanelReader
from pirate_sm.robot.control_panel.presses import Press

STOP, GRIP, ABORT, LAST = 1, 2, 3, 4
PANEL = Panel.model_validate(
    {
        "format": 1,
        "panel": "small",
        "device": "Small",
        "controls": {"STOP": STOP, "GRIP": GRIP, "ABORT": ABORT, "LAST": LAST},
        "buttons": {
            "STOP": {"do": "stop"},
            "GRIP": {"command": "Grip"},
            "ABORT": {"do": "abort", "hold": "20 ms"},
            "LAST": {"do": "pause"},
        },
    }
)
PATIENCE_S = 20.0


class Panels:
    """Readers of the device that the test plays."""

    def __init__(self, midi: Any, stack: ExitStack) -> None:
        self.midi = midi
        self.ended: Queue[str] = Queue()
        self._stack = stack

    def open(self) -> PanelReader:
        reader = PanelReader(PANEL, self.midi.path, self.ended.put, reopen_every_s=0.01)
        return self._stack.enter_context(reader)


@pytest.fixture
def panels(midi: Any) -> Iterator[Panels]:
    with ExitStack() as stack:
        yield Panels(midi, stack)


def until(reader: PanelReader, enough: Callable[[list[Happening]], bool]) -> list[Happening]:
    """What has happened, once it is enough."""
    happened: list[Happening] = []
    for _ in range(int(PATIENCE_S / 0.002)):
        happened += reader.taken()
        if enough(happened):
            return happened
        Event().wait(0.002)
    raise AssertionError(f"only this has happened: {happened}")


def test_a_press_waits_until_it_is_taken(panels: Panels) -> None:
    reader = panels.open()
    panels.midi.press(GRIP)
    assert until(reader, bool) == [Press("GRIP", PANEL.buttons["GRIP"])]
    assert reader.taken() == []


def test_a_stop_waits_for_nobody(panels: Panels) -> None:
    reader = panels.open()
    panels.midi.press(STOP)
    assert panels.ended.get(timeout=PATIENCE_S) == "stopped on the panel"
    assert reader.taken() == []


def test_a_held_button_acts_without_another_byte(panels: Panels) -> None:
    panels.open()
    panels.midi.send(bytes([0xB0, ABORT, 127]))
    assert panels.ended.get(timeout=PATIENCE_S) == "aborted on the panel"


def test_a_million_random_bytes_do_no_harm(panels: Panels) -> None:
    reader = panels.open()
    # Random, but without the number of one button, by which the test sees where the flood ends.
    panels.midi.send(random.Random(15).randbytes(1_000_000).replace(bytes([LAST]), b"\x05"))
    panels.midi.send(bytes([0xB0, *(b for n in (STOP, GRIP, ABORT, LAST) for b in (n, 0))]))
    panels.midi.press(LAST)
    flood = until(reader, lambda happened: Press("LAST", PANEL.buttons["LAST"]) in happened)
    assert len(flood) > 1
    assert {type(each) for each in flood} == {Press}
    while not panels.ended.empty():
        panels.ended.get()

    panels.midi.press(STOP)
    assert panels.ended.get(timeout=PATIENCE_S) == "stopped on the panel"


def test_a_panel_that_is_pulled_out_is_told_once_and_told_when_it_is_back(panels: Panels) -> None:
    reader = panels.open()
    panels.midi.send(bytes([0xB0, GRIP, 127]))  # never released
    until(reader, bool)
    panels.midi.unplug()
    lost = until(reader, bool)
    assert lost == [Connection("lost", "the panel is disconnected: its device has closed")]

    panels.midi.plug()
    assert until(reader, bool) == [Connection("back", "the panel is back")]
    panels.midi.press(GRIP)
    assert until(reader, bool) == [Press("GRIP", PANEL.buttons["GRIP"])]
    panels.midi.press(STOP)
    assert panels.ended.get(timeout=PATIENCE_S) == "stopped on the panel"


def test_a_fault_in_the_thread_is_told_as_a_loss(
    panels: Panels, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> bytes:
        raise RuntimeError("broken")

    reader = panels.open()
    monkeypatch.setattr(panel_reader, "read_device", fail)
    panels.midi.press(STOP)
    (lost,) = until(reader, bool)
    assert isinstance(lost, Connection)
    assert lost.state == "lost"
    assert "RuntimeError: broken" in lost.message


def test_a_device_that_is_not_there_is_refused(tmp_path: Path) -> None:
    reader = PanelReader(PANEL, tmp_path / "none", lambda reason: None)
    before = active_count()
    with pytest.raises(UsageError, match="cannot be opened"):
        reader.__enter__()
    assert active_count() == before


def test_a_reader_that_is_left_has_ended_its_thread(midi: Any) -> None:
    before = active_count()
    with PanelReader(PANEL, midi.path, lambda reason: None):
        assert active_count() == before + 1
    assert active_count() == before
