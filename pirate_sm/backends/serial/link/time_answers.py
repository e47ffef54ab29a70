"""Answer a device's requests for the time."""

from __future__ import annotations

from math import inf, isnan, nan

from pirate_sm.rosserial.frames import encode
from pirate_sm.rosserial.topics import TIME, time_payload

TIME_PERIOD_S = 2.5
"""A configured device asks for the time so often, and falls silent when 11 s bring no answer."""

_TIME_COPIES = 3
_TIME_AGAIN_S = 0.4


class TimeAnswers:
    """Says when the next answer is due, and makes it.

    The time is told more than once for a request, and also when a request must have been lost: a
    device that is not answered for long stops publishing.

    Args:
        epoch_s: Added to the time it gives what the device is told, seconds since 1970.

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
        """Whether the device has ever asked."""
        return not isnan(self._asked_s)

    def request(self, now: float) -> None:
        """Take in that the device asks for the time now."""
        self._asked_s = self.due_s = now
        self._copies = 0

    def answer(self) -> bytes:
        """Return the frame with the time of the device's request; it adds what has passed."""
        asked_s = self._asked_s
        self._copies += 1
        if self._copies < _TIME_COPIES:
            self.due_s = asked_s + self._copies * _TIME_AGAIN_S
        else:
            self._asked_s, self._copies = asked_s + TIME_PERIOD_S, 0
            self.due_s = self._asked_s + _TIME_AGAIN_S  # unless it asks before
        return encode(TIME, time_payload(self._epoch_s + asked_s))
