"""When the lines of a mission began, and where it was to pause."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

from pirate_sm.core import effects as fx
from pirate_sm.core.loading import load_mission
from pirate_sm.core.program import Question
from pirate_sm.views.report.stepping import SteppingNotes

ROOT = Path(__file__).parents[4]
BEND = load_mission(ROOT / "sequences" / "mitre_bend.yaml")
ASK = load_mission(ROOT / "docs" / "examples" / "ask.yaml")


def line_of(text: str, loaded: Any = BEND) -> int:
    lines = loaded.documents[0].lines
    return 1 + next(at for at, each in enumerate(lines) if each.strip().startswith(text))


def places(kind: type[Any], loaded: Any = BEND) -> list[str]:
    return [it.place for it in loaded.program.instructions if isinstance(it, kind)]


def state(loaded: Any = BEND, pc: int = 0, breakpoints: tuple[str, ...] = ()) -> Any:
    return SimpleNamespace(mission=SimpleNamespace(pc=pc, breakpoints=breakpoints))


def test_phases_commands_and_ends_begin_at_their_lines() -> None:
    notes = SteppingNotes(BEND)
    clamp = next(each for each in places(fx_do()) if f":{line_of('- ClampFront')}:" in each)

    notes.take(1.0, [fx.PhaseChange("enter")], state())
    notes.take(2.0, [fx.CommandStatus("ClampFront", "sent", "", clamp)], state())
    notes.take(2.5, [fx.CommandStatus("ClampFront", "accepted", "", clamp)], state())
    notes.take(3.0, [fx.PhaseChange("pass/pass_bend.pass")], state())
    notes.take(4.0, [fx.Ended("succeeded", "", "passed")], state())

    found = notes.contents()
    assert found.begun == (
        (1.0, line_of("enter:")),
        (2.0, line_of("- ClampFront")),
        (3.0, 0),
        (4.0, line_of("passed:")),
    )
    assert {line for _, line in found.begun if line} <= set(found.lines)


def fx_do() -> type[Any]:
    """The kind of instruction that gives a command."""
    return next(type(it) for it in BEND.program.instructions if type(it).__name__ == "Do")


def test_a_command_by_hand_is_at_no_line() -> None:
    notes = SteppingNotes(BEND)
    notes.take(1.0, [fx.CommandStatus("ClampFront", "sent")], state())
    assert notes.contents().begun == ()


def test_a_question_begins_when_it_is_asked_and_not_when_it_is_withdrawn() -> None:
    notes = SteppingNotes(ASK)
    pc = next(n for n, it in enumerate(ASK.program.instructions) if isinstance(it, Question))

    notes.take(1.0, [fx.Ask("Free?", ("yes",))], state(pc=pc))
    notes.take(2.0, [fx.Ask("", ())], state(pc=pc))

    assert notes.contents().begun == ((1.0, line_of("- ask:", ASK)),)


def test_breakpoints_are_noted_as_they_change() -> None:
    notes = SteppingNotes(BEND)
    first, second = places(fx_do())[:2]
    called = next(each for each in places(fx_do()) if "pass_bend" in each)

    for at_s, those in (
        (0.0, (first,)),
        (1.0, (first,)),
        (2.0, (second, called, first)),
        (3.0, ()),
    ):
        notes.take(at_s, [], state(breakpoints=those))

    lines = tuple(int(each.rsplit(":", 2)[1]) for each in (first, second))
    assert notes.contents().breakpoints == ((0.0, lines[:1]), (2.0, lines), (3.0, ()))
