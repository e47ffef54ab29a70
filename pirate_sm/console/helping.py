"""The help page, written from what this robot has."""

from __future__ import annotations

from collections.abc import Mapping

from textual.content import Content

from pirate_sm.console.reasons import controls
from pirate_sm.console.themed import line
from pirate_sm.showing.snapshot import Snapshot
from pirate_sm.showing.styled import MUTED, STRONG

_ALWAYS = (
    ("Space", "STOP: wheels stop, clamps hold. Works at any time, also over a dialog."),
    ("m", "Choose a mission. It begins paused: the robot is yours first."),
    ("↑ ↓ ← →", "Drive forward and backward; brake."),
    ("1 … 9", "Answer what the mission asks."),
    ("Tab", "Next page, where the terminal is too small for all at once."),
    ("PgUp PgDn", "Earlier and later lines of the log."),
    ("Esc", "The warning has been seen; no more of a series of commands; leave a dialog."),
    ("^p", "Command palette: everything by name."),
    ("^t", "Light or dark."),
    ("q", "Safe state, then leave."),
)

_SIGNS = (
    ("▶ ‖ ■ ◆", "running, paused, ending or over, no mission: by hand"),
    ("● ○", "a state that has been confirmed; one that was only commanded"),
    ("✕ =", "cannot be done now; is so already: the words are the engine's own"),
    ("full disc, ring", "a wheel that touches a wall, one that does not"),
    ("full, outline", "a part of the robot that is held, one that is not"),
    ("rays", "a light that is on"),
    ("!", "near a limit"),
)


def help_lines(letters: Mapping[str, str], snapshot: Snapshot) -> list[Content]:
    """The page."""
    robot = snapshot.scene.robot
    commands = snapshot.scene.loaded.loaded_robot.profile.commands
    lines = [line(("Always", STRONG))]
    lines += [_row(key, text) for key, text in _ALWAYS]
    lines += [line(""), line(("A mission", STRONG))]
    lines += [_row(each.key, each.label) for each in controls(snapshot, None)]
    lines += [line(""), line((f"Commands of {robot.name}", STRONG))]
    lines += [
        _row(letters.get(name, "^p"), f"{name}  {each.description}")
        for name, each in commands.items()
    ]
    if robot.detector_words:
        lines += [line(""), line(("You as the detector, where nobody else is", STRONG))]
        lines += [_row(letters.get(word, "^p"), word) for word in robot.detector_words]
    lines += [line(""), line(("Signs", STRONG))]
    return lines + [_row(sign, text) for sign, text in _SIGNS]


def _row(key: str, text: str) -> Content:
    return line((f"{key:>16}  ", STRONG), (text, MUTED if not text else ""))
