"""Slip of a wheel against a speed of the body that was measured over other stretches of time.

A wheel's speed is a mean between two frames, that of the body a mean over what the source outside
averages. While the robot starts or stops the two differ without any slip. What is compared are
therefore the readings that end between two frames of the wheel with the wheel's speeds in all
the time that those readings are made of: a wheel that rolls has had the body's speed among them.
Frames come up to a delay after the motion that they report.
"""

from __future__ import annotations

from math import inf, isnan, nan
from statistics import fmean
from typing import NamedTuple

KEPT_S = 1.0
"""Older stretches are forgotten: boards and sources outside are unknown after less [decided]."""

CHANGING_M_S = 0.010
"""Rim speeds that differ by more belong to a wheel that starts or stops; as much as wheels may
differ that agree (design: 10 mm/s)."""


class Stretch(NamedTuple):
    """A mean speed over some time; at one moment, where both times are equal."""

    since_s: float
    until_s: float
    m_s: float


class Slip(NamedTuple):
    """How fast a wheel slips.

    Attributes:
        slip_m_s: Speed of the rim less that of the body; NaN is unknown.
        body_m_s: The speed of the body that this was made with.
    """

    slip_m_s: float = nan
    body_m_s: float = nan


def lengthened(
    stretches: tuple[Stretch, ...], m_s: float, now_s: float, since_s: float = -inf
) -> tuple[Stretch, ...]:
    """Return the stretches with one more, which ends now; none after an unknown speed.

    Args:
        stretches: Oldest first.
        m_s: The mean speed.
        now_s: When it was reported.
        since_s: When it begins; by default where the last one ends.
    """
    if isnan(m_s):
        return ()
    if since_s == -inf:
        since_s = stretches[-1].until_s if stretches else now_s
    kept = tuple([each for each in stretches if each.until_s >= now_s - KEPT_S])
    return (*kept, Stretch(since_s, now_s, m_s))


def slip_between(rims: tuple[Stretch, ...], readings: tuple[Stretch, ...], delay_s: float) -> Slip:
    """Return how fast a wheel slips.

    While its speed changes slip is the least that explains the difference, and unknown where none
    is needed.

    Args:
        rims: The wheel's rim speeds from frame to frame.
        readings: The speeds of the body, oldest first.
        delay_s: By how much a frame may be later than a reading of the same moment.
    """
    heard = [each for each in readings if rims and each.until_s <= rims[-1].until_s - delay_s]
    if not heard:
        return Slip()
    newest_s = heard[-1].until_s
    frame = next((each for each in reversed(rims) if each.since_s <= newest_s), rims[0])
    used = [each for each in heard if each.until_s >= frame.since_s - delay_s] or heard[-1:]
    since_s, until_s = used[0].since_s, used[-1].until_s + delay_s
    speeds = [e.m_s for e in rims if e.until_s >= since_s and e.since_s <= until_s] or [frame.m_s]
    body_m_s, slowest, fastest = fmean([e.m_s for e in used]), min(speeds), max(speeds)
    if fastest - slowest <= CHANGING_M_S:
        return Slip(fmean(speeds) - body_m_s, body_m_s)
    if slowest <= body_m_s <= fastest:
        return Slip(nan, body_m_s)
    return Slip((slowest if body_m_s < slowest else fastest) - body_m_s, body_m_s)
