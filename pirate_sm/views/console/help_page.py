"""The help page, made for the present robot."""

from __future__ import annotations

from collections.abc import Mapping
from textwrap import wrap

from textual.content import Content

from pirate_sm.views.console.availability import Entries, command_reason, controls
from pirate_sm.views.console.themes import line
from pirate_sm.views.showing.snapshot import Snapshot
from pirate_sm.views.showing.text_styles import STRONG

_KEYS, _WIDE = 16, 50
"""Columns of the keys and of their meaning; both fit into a terminal of 80 columns."""

_ALWAYS = (
    ("Space", "STOP: wheels stop, clamps hold. Works at any time, also over a dialog."),
    ("m", "Choose a mission. It begins paused: the robot is yours first."),
    ("↑ ↓", "Drive forward, backward for as long as the key is held."),
    ("← →", "Stop the wheels."),
    ("+ -", "Drive faster, slower by hand, from the next drive on."),
    ("@", "Type where wheel 1 is and what is seen, while nothing moves."),
    ("=", "Where a drive by hand stops: after a distance, before the joint."),
    ("1 … 9", "Answer what the mission asks."),
    ("Tab", "Next page, if the terminal is too small for all of it."),
    ("PgUp PgDn", "Earlier and later lines of the log."),
    ("#", "Pre-flight: the checks of pirate doctor on the open port, repeated."),
    ("!", "Every alarm with its time, in full; Enter there acknowledges one."),
    ("Esc", "The alarms shown are seen; no more of a series of commands; leave a dialog."),
    ("?", "This page; ↑ ↓ PgUp PgDn move it."),
    ("^p", "Command palette: everything by name."),
    ("^t", "Next theme: dark, light, two of high contrast, the colours of Okabe and Ito."),
    ("q", "Safe state, then leave."),
)

_LOOKING_BACK = (
    ("r", "Play; at the end from the start."),
    ("p Space", "Pause."),
    ("← →", "1 s back, 1 s on; with Shift 0.1 s."),
    ("↑ ↓", "10 s back, 10 s on; so do PgUp and PgDn."),
    ("< >", "The phase before, the next one."),
    ("Home End", "The start, the end."),
    ("Tab", "Next page, if the terminal is too small for all of it."),
    ("?", "This page."),
    ("^t", "Next theme."),
    ("q", "Leave."),
)

_SIGNS = (
    ("▶ ‖ ■ ◆", "running, paused, ending or over, no mission: by hand"),
    ("✓ ▶ ▷ ·", "a phase that was left, the current one, one that has called it, not entered"),
    ("● ○", "a state that has been confirmed; one that was only commanded"),
    ("■ ?", "commanded and stopped: 0 is sent; not shown now, or a fault contradicts it"),
    ("12s", "after a state: how long ago sensors, an echo or the operator showed it"),
    ("┄1.2 3s", "what a value was when it was last reported, and how long ago"),
    (
        "1A 2B 3~ 4– 5?",
        "wheel 1 touches wall A, 2 wall B, 3 out of the plane of its part, 4 none; 5 is not known",
    ),
    ("thick wall", "where a wheel touches it"),
    ("dial", "where side A of a part points, looking ahead: up, right, down, left"),
    ("✕ =", "cannot be done now; is so already: the words are the engine's own"),
    ("full disc, ring", "a wheel that touches a wall, one that does not"),
    ("full, outline", "a part of the robot that is held, one that is not"),
    ("rays, dashes", "a light that is on; the robot as it was last heard"),
    ("!", "near a limit; before a key: a fault contradicts it, so it asks first"),
)


def help_lines(
    letters: Mapping[str, str], snapshot: Snapshot, entries: Entries | None
) -> list[Content]:
    """Return the help page of the console, with all of why something cannot be done now."""
    robot = snapshot.scene.robot
    commands = snapshot.scene.loaded.loaded_robot.profile.commands
    lines = [line(("Always", STRONG))]
    lines += [row(key, text) for key, text in _ALWAYS]
    lines += [line(""), line(("A mission", STRONG))]
    lines += [
        row(each.key, _with_reason(each.label, each.reason)) for each in controls(snapshot, entries)
    ]
    lines += [line(""), line((f"Commands of {robot.name}", STRONG))]
    lines += [
        row(
            letters.get(name, "^p"),
            _with_reason(f"{name}  {each.description}", command_reason(snapshot, name)),
        )
        for name, each in commands.items()
    ]
    if robot.detector_words:
        lines += [line(""), line(("You as the detector, if there is no other", STRONG))]
        lines += [row(letters.get(word, "^p"), word) for word in robot.detector_words]
    return lines + _signs()


def _with_reason(text: str, reason: str) -> str:
    return f"{text}. Not now: {reason}" if reason else text


def recording_lines() -> list[Content]:
    """Return the help page of the viewer of a recording."""
    return [
        line(("A recording", STRONG)),
        *(row(key, text) for key, text in _LOOKING_BACK),
        *_signs(),
    ]


def _signs() -> list[Content]:
    return [line(""), line(("Signs", STRONG)), *(row(sign, text) for sign, text in _SIGNS)]


def row(key: str, text: str, style: str = STRONG) -> Content:
    """Return a sign with its meaning, in as many lines as that needs."""
    first, *more = wrap(text, _WIDE) or [""]
    head = line((f"{key:>{_KEYS}}  ", style), first)
    return Content("\n").join([head, *(line(" " * (_KEYS + 2) + each) for each in more)])
