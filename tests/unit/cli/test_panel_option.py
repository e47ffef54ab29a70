"""`--panel` and `pirate panel`: what cannot be had moves nothing; what is pressed is recorded."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import Result

from pirate_sm.robot.control_panel.panel_reader import MidiDevice, MidiSystem

from .conftest import NEWT, ROOT

Run = Callable[..., Result]
Start = Callable[..., subprocess.Popen[str]]

PEDALS = NEWT / "pedals.yaml"
RED, GREEN, LEFT, RIGHT, PAD_3 = 80, 81, 82, 83, 22


def play(midi: Any, *numbers: int) -> None:
    """Press these buttons together, on the channel of the pedals."""
    midi.send(bytes([0xB9, *(b for n in numbers for b in (n, 127))]))
    midi.send(bytes([0xB9, *(b for n in reversed(numbers) for b in (n, 0))]))


@pytest.mark.parametrize(
    ("panel", "why"),
    [
        ("nanokontrol", "there is no panel 'nanokontrol'; did you mean 'nanokontrol2'?"),
        ("nanokontrol2", "newt has no command 'ClampFront'"),
        (PEDALS, "no MIDI device is named 'FootBoard'"),
        (f"{PEDALS}:/dev/snd/none", "/dev/snd/none cannot be opened: No such file"),
        (f"{PEDALS}:{PEDALS}", "is not a device; MIDI devices are /dev/snd/midiC*D*"),
        (NEWT / "patrol.yaml", "patrol.yaml:"),
    ],
)
def test_a_panel_that_cannot_be_had_moves_nothing(
    pirate_run: Run, tmp_path: Path, panel: object, why: str
) -> None:
    kept = tmp_path / "run.mcap"
    result = pirate_run(
        NEWT / "take_hold.yaml", "--backend", "trace", "--panel", panel, "--record", kept
    )
    assert result.exit_code == 2
    assert why in result.output
    assert "accepted" not in result.output
    assert not kept.exists()


def test_panels_and_devices_are_listed(pirate: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    device = MidiDevice(Path("/dev/snd/midiC1D0"), "nanoKONTROL2: KORG INC.")
    monkeypatch.setattr(MidiSystem, "listed", lambda self: [device])
    out = pirate("panel").output
    assert "nanokontrol2  Korg nanoKONTROL2" in out
    assert "/dev/snd/midiC1D0  nanoKONTROL2: KORG INC." in out
    assert "nanokontrol2  Korg" in pirate("list", "panels").output


@pytest.mark.thorough
def test_each_control_is_shown_as_it_is_moved(midi: Any) -> None:
    play(midi, RED)
    midi.send(bytes([0xB9, 1, 33]))
    play(midi, GREEN, RIGHT)
    midi.send(b"\x90\x3c\x7f")
    midi.send(bytes([0xB0, 5, 1]))
    shown = shown_until(midi, f"{PEDALS}:{midi.path}", "channel 1    5 = 1")

    lines = [" ".join(line.split()) for line in shown.splitlines()]
    assert "channel 10 80 = 127 RED → RED: stop" in lines
    assert "channel 10 80 = 0 RED" in lines
    assert "channel 10 1 = 33 WHEEL" in lines
    assert "channel 10 83 = 127 RIGHT → GREEN+RIGHT: skip" in lines
    assert "channel 1 5 = 1 not on channel 10" in lines
    assert "is the panel in CC mode?" in shown
    assert "the panel is disconnected" in shown


def test_a_device_alone_shows_bare_numbers(midi: Any) -> None:
    midi.send(bytes([0xB3, 7, 64, 7, 0]))
    shown = shown_until(midi, Path(midi.path).readlink(), "released")

    assert "pressed" in shown


def shown_until(midi: Any, name: object, last: str) -> str:
    """What `pirate panel` shows up to this text and after its device has gone."""
    code = "from pirate_sm.cli.entry import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", code, "panel", str(name)],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=ROOT,
    )  # fmt: skip
    assert process.stdout is not None
    shown = ""
    while last not in shown:
        line = process.stdout.readline()
        assert line, shown
        shown += line
    midi.unplug()
    shown += process.stdout.read()
    process.stdout.close()
    assert process.wait(timeout=60) == 3
    return shown


class Course:
    """A run of the newt in a process of its own, with the pedals."""

    def __init__(self, start: Start, midi: Any, kept: Path, *mission: object) -> None:
        self.midi = midi
        panel = ("--panel", f"{PEDALS}:{midi.path}")
        self.process = start(*mission, *panel, "--json", "--record", kept)
        self.lines: list[dict[str, Any]] = []

    def until(self, **wanted: object) -> dict[str, Any]:
        assert self.process.stdout is not None
        for text in self.process.stdout:
            self.lines.append(json.loads(text))
            if wanted.items() <= self.lines[-1].items():
                return self.lines[-1]
        raise AssertionError(f"{wanted} never came: {self.process.communicate()[1]}")

    def end(self) -> tuple[dict[str, Any], int]:
        last = self.until(type="end")
        self.process.communicate(timeout=60)
        return last, self.process.returncode


def replayed(pirate: Run, kept: Path) -> str:
    result = pirate("replay", kept)
    assert result.exit_code == 0, result.output
    return result.output


def test_the_stop_of_a_panel_ends_a_run_and_its_replay(
    start: Start, midi: Any, tmp_path: Path, pirate: Run
) -> None:
    kept = tmp_path / "run.mcap"
    drives = (NEWT / "patrol.yaml", "--backend", "trace", "--fire", "within")
    course = Course(start, midi, kept, *drives)
    course.until(name="HoldNose")
    play(midi, RED)
    last, code = course.end()

    assert (last["outcome"], last["message"]) == ("interrupted", "stopped on the panel")
    assert code == 130
    assert "replayed identically" in replayed(pirate, kept)


@pytest.mark.slow  # in real time
def test_a_run_is_led_from_a_panel_until_it_is_pulled_out_and_replays_without_one(
    start: Start, midi: Any, tmp_path: Path, pirate: Run
) -> None:
    kept = tmp_path / "run.mcap"
    course = Course(
        start, midi, kept, NEWT / "patrol.yaml", "--backend", "sim", "--detector", "operator"
    )
    course.until(name="GoAhead", status="done")
    play(midi, LEFT)
    course.until(message="paused: wheels stopped, deadlines frozen")
    play(midi, GREEN)
    course.until(message="resumed")
    midi.send(bytes([0xB9, PAD_3, 127]))
    course.until(type="phase", phase="look")
    midi.unplug()
    fault = course.until(type="fault")
    last, code = course.end()

    assert fault["code"] == "panel.lost"
    assert last["outcome"] == "fault"
    assert code == 1
    assert "replayed identically" in replayed(pirate, kept)


@pytest.mark.slow  # in real time
def test_a_question_is_answered_on_a_panel_where_nobody_has_a_keyboard(
    start: Start, midi: Any, tmp_path: Path
) -> None:
    ask = ROOT / "docs" / "examples" / "ask.yaml"
    panel = f"nanokontrol2:{midi.path}"
    process = start(ask, "--panel", panel, "--json", "--record", tmp_path / "run.mcap")
    assert process.stdout is not None
    for text in process.stdout:
        last = json.loads(text)
        if last["type"] == "log" and "people's hands" in last["message"]:
            midi.press(62)  # MARKER ►, the second answer
    assert (last["outcome"], last["message"]) == ("failed", "Not now")
    process.communicate(timeout=60)


@pytest.mark.parametrize("command", ["run_main", "main"])
def test_help_imports_nothing_of_panels(command: str) -> None:
    code = f"""
import sys
sys.argv = ["pirate", "--help"]
from pirate_sm.cli.entry import {command}
try:
    {command}()
except SystemExit:
    print([each for each in sys.modules if "control_panel" in each or "yaml" in each])
"""
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert "--help" in result.stdout
    assert result.stdout.splitlines()[-1] == "[]"
