from __future__ import annotations

import io
import os
import re
from typing import Any

import pytest
from representative import thorough_but
from rich.console import Console

from pirate_sm.cli.output.event_lines import ObservedRun
from pirate_sm.cli.output.live_view import LiveView
from pirate_sm.core.effects import Effect
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, prepare
from pirate_sm.views.drawing.canvas import Canvas

from ..conftest import NEWT, ROOT
from ..terminals import on_a_terminal, once

SIZES = [(80, 23), (120, 39), (60, 15), (20, 5), (200, 60)]
BRAILLE = "".join(chr(0x2800 + bits) for bits in range(1, 256))


class Frames:
    """Runs a mission and keeps the frame of every moment that something happened."""

    def __init__(self, size: tuple[int, int], **order: Any) -> None:
        prepared = prepare(Order(**order))
        situation = ObservedRun(prepared)
        self.size = size
        self.view = LiveView(Console(file=io.StringIO()), situation, "max", None)
        self.frames = [self._frame()]
        companions = [*prepared.companions, FirstChoice()]
        situation.run = MissionRun(
            prepared.engine, prepared.backend, observers=[self], companions=companions
        )
        self.result = situation.run.execute()

    def see(self, effects: tuple[Effect, ...], now_s: float) -> None:
        self.view.see(effects, now_s)
        self.frames.append(self._frame())

    def _frame(self) -> list[str]:
        return [line.plain for line in self.view.frame(*self.size)]

    def text(self) -> str:
        return "\n".join("\n".join(frame) for frame in self.frames)


@pytest.mark.thorough
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("backend", ["trace", "sim"])
def test_every_frame_keeps_to_its_size(size: tuple[int, int], backend: str) -> None:
    frames = Frames(size, mission=str(NEWT / "patrol.yaml"), backend=backend)

    assert frames.result.exit_code == 0
    assert all(len(frame) <= size[1] for frame in frames.frames)
    if size[0] >= 60:
        assert max(len(line) for frame in frames.frames for line in frame) <= max(size[0], 80)


@pytest.fixture(scope="module")
def frames() -> Frames:
    return Frames((80, 23), mission=str(NEWT / "patrol.yaml"), backend="sim")


def test_phases_states_waits_and_sensors_are_shown(frames: Frames) -> None:
    text = frames.text()

    for shown in (
        "▶ out", "✓ out", "· home", "○ Grip  NoseHeld", "● Grip  BothHeld", "HoldNose: until",
        "○ detector == near", "s left", "neck ", "⌀ nose", "way ", "pace ", "detector near",
        "patrol on newt in elbow, sim (seed 0)",
    ):  # fmt: skip
        assert shown in text, shown


def test_the_last_frame_says_how_it_ended(frames: Frames) -> None:
    last = "\n".join(frames.frames[-1])

    assert "succeeded" in last
    assert "Back where it began" in last
    assert "▶" not in last


def test_the_robot_moves_in_the_drawing(frames: Frames) -> None:
    drawings = {
        "".join(char for line in frame for char in line if char in BRAILLE)
        for frame in frames.frames
    }

    assert len(drawings) > 3


def test_a_trace_shows_setpoints_instead_of_a_robot() -> None:
    text = Frames((80, 23), mission=str(NEWT / "patrol.yaml"), backend="trace").text()

    assert not set(text) & set(BRAILLE)
    assert "setpoints that would be sent" in text
    assert "fold_neck   -50 %" in text


def test_a_line_is_drawn_without_gaps_and_cut_at_the_edges() -> None:
    canvas = Canvas(10, 1)
    canvas.line(-50.0, 1.5, 50.0, 1.5, "red")

    assert canvas.rows()[0].plain in ("⠒" * 10, "⠤" * 10)


def test_what_lies_outside_is_not_drawn() -> None:
    canvas = Canvas(3, 1)
    canvas.line(-5.0, -5.0, -1.0, 20.0, "red")
    canvas.disc(100.0, 100.0, 3.0, "red")

    assert canvas.rows()[0].plain == "   "


@pytest.mark.parametrize("size", [(80, 23), pytest.param((120, 35), marks=pytest.mark.thorough)])
def test_the_robot_is_drawn_so_large_that_its_wheels_have_numbers(size: tuple[int, int]) -> None:
    frame = Frames(size, mission=str(NEWT / "patrol.yaml"), backend="sim").frames[-1]
    picture = [line[41:] for line in frame if set(line) & set(BRAILLE)]

    assert all(any(number in line for line in picture) for number in "1234")


def test_a_narrow_terminal_shows_the_words_alone_and_cuts_only_what_is_too_long() -> None:
    frames = Frames((40, 20), mission=str(NEWT / "patrol.yaml"), backend="trace").frames
    words = [line for frame in frames for line in frame[1:-4]]

    assert max(map(len, words)) <= 40
    assert not any(line.strip() == "…" or line.endswith("  …") for line in words)


@pytest.mark.thorough
def test_every_motor_is_measured_where_there_is_room() -> None:
    frame = Frames((120, 35), mission=str(NEWT / "patrol.yaml"), backend="sim").frames[-1]

    assert any("of limit" in line and "heat" in line for line in frame)


class Picture:
    """Draws the view as an SVG that needs nothing from elsewhere, at one moment of a run."""

    def __init__(self, size: tuple[int, int], at_s: float) -> None:
        prepared = prepare(Order(mission="mitre_bend", backend="sim"))
        situation = ObservedRun(prepared)
        self._console = Console(
            file=io.StringIO(), record=True, width=size[0], height=size[1],
            force_terminal=True, color_system="truecolor", legacy_windows=False,
        )  # fmt: skip
        self._at_s, self.svg = at_s, ""
        self.view = LiveView(self._console, situation, "4 ×", None)
        situation.run = MissionRun(
            prepared.engine, prepared.backend, observers=[self], companions=prepared.companions
        )
        situation.run.execute()

    def see(self, effects: tuple[Effect, ...], now_s: float) -> None:
        self.view.see(effects, now_s)
        if now_s >= self._at_s and not self.svg:
            self._console.print(self.view, end="")
            svg = self._console.export_svg(title="pirate-run mitre_bend", unique_id="run")
            self.svg = re.sub(r"\s*@font-face \{.*?\}", "", svg, flags=re.DOTALL).replace(
                "Fira Code", "monospace"
            )


@pytest.mark.parametrize("size", [(80, 24), (120, 36)], ids=lambda size: f"{size[0]}x{size[1]}")
def test_the_view_is_as_in_the_documents(size: tuple[int, int]) -> None:
    found = Picture(size, 14.0).svg
    file = ROOT / "docs" / "pictures" / f"run_{size[0]}x{size[1]}.svg"
    if os.environ.get("GOLDEN") == "write":
        file.write_text(found, encoding="utf-8")

    assert found == file.read_text(encoding="utf-8")


ASK = ("docs/examples/ask.yaml", "--backend", "trace", "--speed", "max")


@pytest.mark.parametrize(
    ("key", "code"),
    thorough_but([("1", 0), ("2", 1)], [("1", 0), ("2", 1), ("3", 1), ("\r", 0)]),
)
@pytest.mark.parametrize("form", [(), pytest.param(("--plain",), marks=pytest.mark.thorough)])
def test_a_person_at_a_terminal_is_asked(key: str, code: int, form: tuple[str, ...]) -> None:
    ended, shown, same = on_a_terminal((*ASK, *form), once("[3] stop", key))

    assert ended == code
    assert same
    assert ("phases" in shown) == (form == ())


@pytest.mark.thorough
def test_ctrl_c_at_a_question_leaves_the_terminal_as_it_was() -> None:
    ended, shown, same = on_a_terminal(ASK, once("[3] stop", "\x03"))

    assert (ended, same) == (130, True)
    assert "interrupted" in shown
    assert "Traceback" not in shown


@pytest.mark.thorough
def test_nobody_is_asked_who_says_yes_beforehand() -> None:
    ended, shown, _ = on_a_terminal((*ASK, "--yes"), lambda shown: "")

    assert ended == 0
    assert "[1]" not in shown
