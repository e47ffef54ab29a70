"""Answers a device's requests for the time."""

from __future__ import annotations

from math import inf, isnan, nan

from pirate_sm.rosserial.frames import encode
from pirate_sm.rosserial.topics import TIME, time_payload

TIME_PERIOD_S = 2.5
"""A configured device requests the time this often, and stops after 11 s without an answer."""

_TIME_COPIES = 3
_TIME_AGAIN_S = 0.4


class TimeAnswers:
    """Makes the answers to requests for the time, and says when the next is due.

    Each request is answered more than once, and an overdue request is answered as well, because a
    device without answers stops publishing.

    Args:
        epoch_s: Added to the time it gives the device's time, seconds since 1970.

    Attributes:
        due_s: When the next answer is due; infinite before the first request.
    """

    def __init__(self, epoch_s: float) -> None:
        self.due_s = inf
        self._epoch_s = epoch_s
        self._asked_s = nan
        self._copies = 0

    @property
    def requested(self) -> bool:
        """Whether the device has ever requested the time."""
        return not isnan(self._asked_s)

    def request(self, now: float) -> None:
        """Handle the device's request for the time."""
        self._asked_s = self.due_s = now
        self._copies = 0

    def answer(self) -> bytes:
        """Return the frame that answers the last request; the device adds the time since then."""
        asked_s = self._asked_s
        self._copies += 1
        if self._copies < _TIME_COPIES:
            self.due_s = asked_s + self._copies * _TIME_AGAIN_S
        else:
            self._asked_s, self._copies = asked_s + TIME_PERIOD_S, 0
            self.due_s = self._asked_s + _TIME_AGAIN_S  # unless it requests it before
        return encode(TIME, time_payload(self._epoch_s + asked_s))
