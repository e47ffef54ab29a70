"""Who may press the buttons of a page, and how often."""

from __future__ import annotations

import hmac
import re
import secrets
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

MOST_A_SECOND: Final = 15
"""An operator does not press more often. The run takes more than twice as many."""

LINE: Final = re.compile(r"(?P<do>break|until) (?P<line>[^\x00-\x1f:]{1,120}:[0-9]{1,6})")
"""What is asked for at a line of the mission's file: a breakpoint, or to run until there."""

STOP: Final = "stop"
"""The button whose presses are counted apart from all others."""

_NO_TOKEN = (
    "Only who has the token may act, this page only shows: open the address that the run printed, "
    "with all that follows the #"
)
_TOO_OFTEN = f"Not taken: more than {MOST_A_SECOND} requests in a second"
_OVER = "The run takes no requests any more: it has ended"


class Refusal(NamedTuple):
    """Why a press is not passed on, and the status of HTTP that says so."""

    status: int
    why: str


class Acting:
    """The buttons of the page of a run.

    Args:
        buttons: Their names.
        press: Passes a press on to the run; returns whether the run takes it.
        now: Reads a monotonic clock, s.

    Attributes:
        buttons: Their names.
        token: Viewers who have it may press them.
    """

    def __init__(
        self,
        buttons: Sequence[str],
        press: Callable[[str], bool],
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self.buttons = tuple(buttons)
        self.token = secrets.token_urlsafe(16)
        self._press, self._now = press, now
        self._pressed_s = {stops: deque[float](maxlen=MOST_A_SECOND) for stops in (True, False)}

    def press(self, token: str, button: str) -> Refusal | None:
        """Press a button for a viewer who has shown this token; return why not, if not."""
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            return Refusal(403, _NO_TOKEN)
        if button not in self.buttons and LINE.fullmatch(button) is None:
            return Refusal(400, f"This page has other buttons: {', '.join(self.buttons)}")
        now_s, pressed_s = self._now(), self._pressed_s[button == STOP]
        if len(pressed_s) == MOST_A_SECOND and now_s < pressed_s[0] + 1.0:
            # A stop has been passed on just now, many times.
            return None if button == STOP else Refusal(429, _TOO_OFTEN)
        pressed_s.append(now_s)
        return None if self._press(button) else Refusal(409, _OVER)
