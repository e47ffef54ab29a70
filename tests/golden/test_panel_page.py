"""docs/panel.md says what each button does, in a table and a picture. `make golden` writes both."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from html import escape
from pathlib import Path

from pirate_sm.core import library
from pirate_sm.robot.control_panel.panel_file import Button, read_panel
from pirate_sm.robot.control_panel.presses import action_text

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "panel.md"
PICTURE = ROOT / "docs" / "pictures" / "nanokontrol2.svg"
PANEL, _, _ = read_panel(library.find_panel("nanokontrol2", ROOT))

WIDTH, HEIGHT, GAP = 92, 40, 6
TRANSPORT = (
    ("TRACK_LEFT", "TRACK ◄"), ("TRACK_RIGHT", "TRACK ►"), None, None, None,
    ("CYCLE", "CYCLE"), None, ("SET", "SET"), ("MARKER_LEFT", "MARKER ◄"),
    ("MARKER_RIGHT", "MARKER ►"), ("REW", "◄◄"), ("FF", "►►"), ("STOP", "■"), ("PLAY", "►"),
    ("REC", "●"),
)  # fmt: skip
"""The left half of the face, row by row: control and what is printed on it."""


def does(button: Button) -> str:
    """What the button does, and how it must be pressed for it."""
    text = action_text(button)
    if button.hold:
        text += f", held for {button.hold:g} s"
    return f"{text}, pressed twice" if button.twice else text


def meanings() -> Mapping[str, str]:
    """What stands in the picture on each button."""
    found = {name: does(button) for name, button in PANEL.buttons.items() if "+" not in name}
    for name in PANEL.buttons:
        first, _, last = name.partition("+")
        if last:
            found.setdefault(first, f"with {last}")
            found.setdefault(last, f"with {first}: {action_text(PANEL.buttons[name])}")
    return {name: text.replace("held for ", "") for name, text in found.items()}


def key(x: float, y: float, printed: str, meaning: str) -> str:
    fill = "#d94f3d" if meaning == "stop" else "#f4ead2" if meaning else "#e4e4e4"
    ink = "#ffffff" if meaning == "stop" else "#222222"
    return (
        f'<rect x="{x:g}" y="{y:g}" width="{WIDTH}" height="{HEIGHT}" rx="4" fill="{fill}" '
        f'stroke="#555555"/>'
        f'<text x="{x + 6:g}" y="{y + 14:g}" fill="{ink}" font-size="10">{escape(printed)}</text>'
        f'<text x="{x + WIDTH / 2:g}" y="{y + 31:g}" fill="{ink}" '
        f'text-anchor="middle">{escape(meaning)}</text>'
    )


def drawn() -> Iterator[str]:
    """Yield the face of the panel, from left to right."""
    meaning = meanings()
    across, down = WIDTH + GAP, HEIGHT + GAP
    wide, high = 13 * across + 6 * GAP, 4 * down + 6 * GAP
    yield (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {high}" '
        f'font-family="sans-serif" font-size="11"><title>What each button does</title>'
        f'<rect width="{wide}" height="{high}" rx="10" fill="#fafafa" stroke="#555555"/>'
    )
    top = 3 * GAP
    for number, each in enumerate(TRANSPORT):
        if each is not None:
            name, printed = each
            x, y = 2 * GAP + number % 5 * across, top + (1 + number // 5) * down
            yield key(x, y, printed, meaning.get(name, ""))
    for column in range(8):
        x = 4 * GAP + (5 + column) * across
        centre = x + WIDTH / 4
        yield f'<circle cx="{centre:g}" cy="{top + 16}" r="14" fill="#e4e4e4" stroke="#555555"/>'
        x2 = x + WIDTH * 0.75
        yield f'<rect x="{x2 - 3:g}" y="{top}" width="6" height="36" fill="#cccccc"/>'
        yield f'<rect x="{x2 - 9:g}" y="{top + 12}" width="18" height="10" fill="#999999"/>'
        for row, letter in enumerate("SMR"):
            name = f"{letter}{column + 1}"
            yield key(x, top + (1 + row) * down, name, meaning.get(name, ""))
    yield "</svg>\n"


def rows() -> Iterator[str]:
    yield "| button | does |\n|---|---|"
    for name, button in PANEL.buttons.items():
        yield f"| {name.replace('_', ' ')} | {does(button)} |"


def test_the_picture_shows_what_each_button_does() -> None:
    picture = "\n".join(drawn())
    if os.environ.get("GOLDEN") == "write":
        PICTURE.write_text(picture, encoding="utf-8")
    assert PICTURE.read_text("utf-8") == picture
    printed = {each[0] for each in TRANSPORT if each} | {
        f"{row}{n}" for row in "SMR" for n in range(1, 9)
    }
    assert {part for name in PANEL.buttons for part in name.split("+")} <= printed


def test_the_page_lists_what_each_button_does() -> None:
    text = PAGE.read_text("utf-8")
    before, mark, rest = text.partition("<!-- buttons: written by `make golden` -->\n")
    _, end, after = rest.partition("<!-- end -->")
    assert mark
    assert end
    wanted = f"{before}{mark}" + "\n".join(rows()) + f"\n{end}{after}"
    if os.environ.get("GOLDEN") == "write":
        PAGE.write_text(wanted, encoding="utf-8")
        text = wanted
    assert text == wanted
