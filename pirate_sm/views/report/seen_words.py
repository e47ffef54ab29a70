"""The camera's picture of each moment at which a detector word began, as a strip of the page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.viewers.viewer_messages import PICTURES
from pirate_sm.views.report.contents import Lane, Photo
from pirate_sm.views.report.timeline import DETECTOR

_NEAR_S = 0.6
"""Pictures are recorded twice a second, and with each word."""

_MOST = 24


def photos_of(recording: Recording, lanes: Iterable[Lane]) -> tuple[Photo, ...]:
    """Return the picture nearest to the beginning of each word; none without a camera."""
    words = [span for lane in lanes if lane.name == DETECTOR for span in lane.spans][:_MOST]
    nearest: dict[int, tuple[float, Photo]] = {}
    if not words:
        return ()
    for shown in recording.shown(PICTURES):
        for number, word in enumerate(words):
            off_s = abs(shown.at_s - word.start_s)
            if off_s <= min(_NEAR_S, nearest.get(number, (_NEAR_S, None))[0]):
                photo = Photo(word.start_s, word.text, str(shown.content.get("data", "")))
                nearest[number] = off_s, photo
    return tuple(nearest[number][1] for number in sorted(nearest))


def seen_words(photos: Sequence[Photo]) -> str:
    """Return the section of the page with these pictures; empty without any."""
    if not photos:
        return ""
    figures = "\n".join(
        f'<li><button type="button" data-at="{photo.at_s:.3f}">'
        f'<img alt="What the camera saw" src="data:image/jpeg;base64,{escape(photo.jpeg)}">'
        f"<b>{escape(photo.word)}</b><time>{photo.at_s:.2f} s</time></button></li>"
        for photo in photos
    )
    return (
        '<section class="wide" aria-labelledby="seen-title">\n'
        '<h2 id="seen-title">What the camera saw at each word</h2>\n'
        f'<ol class="strip seen">\n{figures}\n</ol>\n</section>'
    )
