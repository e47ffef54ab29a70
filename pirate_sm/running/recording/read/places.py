"""Reads where a robot's wheels were, from recordings with and without messages for viewers."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, nan

from pirate_sm.core.models import Body
from pirate_sm.running.recording.format.engine_topics import SAMPLES, Placed, decode_samples
from pirate_sm.running.recording.read.reader import NS_PER_S, Recording
from pirate_sm.running.recording.viewers.viewer_messages import PLACES, rolls_of, space_of


def recorded_places(recording: Recording, body: Body, since_s: float = -inf) -> Iterator[Placed]:
    """Yield where the wheels were, in order, at times since the run began; skip unknown places.

    Args:
        recording: The recording.
        body: The robot's body.
        since_s: Places before this time may be left out.

    Raises:
        RecordingError: The recording is damaged.
    """
    if not recording.header.viewers:
        for batch in recording.shown(SAMPLES, since_s=since_s):
            for placed in decode_samples(batch.content):
                if placed.wheels:
                    since = placed.at_s - recording.origin_s
                    yield placed._replace(at_s=round(since * NS_PER_S) / NS_PER_S)
        return
    names = [(f"{wheel.name}_x_m", f"{wheel.name}_y_m") for wheel in body.wheels]
    for at_s, shown in ((it.at_s, it.content) for it in recording.shown(PLACES, since_s=since_s)):
        wheels = tuple((shown.get(x, nan), shown.get(y, nan)) for x, y in names)
        space = space_of(shown, [wheel.name for wheel in body.wheels])
        rolls_rad = rolls_of(shown) if space is None else ()
        yield Placed(at_s, bool(shown.get("known")), wheels, space, rolls_rad)
