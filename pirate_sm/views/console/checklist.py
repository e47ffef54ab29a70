"""The checks before anything moves, as a list that turns green.

It needs the extra `serial`, which a recording is viewed without.
"""

from __future__ import annotations

from functools import partial

from textual.content import Content

from pirate_sm.robot.diagnosis.judgement import CHECKED_EVERY_S, CHECKS
from pirate_sm.robot.diagnosis.listening import OpenLink
from pirate_sm.views.console.dialogs import Help, row
from pirate_sm.views.showing.text_styles import BAD, GOOD, MUTED, WARN

_NOT_TRIED = "not tried, since that moves the robot: drive by hand (↑ ↓) and look at Motors"
_SIGN_OF = {"no-go": ("✕", BAD), "suspicious": ("!", WARN)}


class Checklist(Help):
    """Shows the checks of an open link, which are repeated until it is closed."""

    heading = "Pre-flight: nothing moves, nothing is sent"

    def __init__(self, link: OpenLink) -> None:
        self._link = link.__enter__()
        super().__init__(partial(_lines, link))

    def on_unmount(self) -> None:
        """Check no longer."""
        self._link.__exit__()


def _lines(link: OpenLink) -> list[Content]:
    lines = []
    for name, (right, check) in CHECKS.items():
        wrong = list(check(link.found, link.subject)) if link.found else []
        for level, message in wrong:
            sign, style = _SIGN_OF[level]
            lines.append(row(f"{sign} {name}", message, style))
        if not link.found:
            lines.append(row(f"… {name}", f"listening for {CHECKED_EVERY_S:g} s", MUTED))
        elif not wrong:
            lines.append(row(f"✓ {name}", right, GOOD))
    return [*lines, row("· motors", _NOT_TRIED, MUTED)]
