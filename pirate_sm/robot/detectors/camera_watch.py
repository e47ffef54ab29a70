"""Judges whether a camera can be believed: its faults, each of which silences the detector."""

from __future__ import annotations

from pirate_sm.core.engine import has_come
from pirate_sm.core.events import BuiltInFault, FaultReport, Sighting

SILENT_AFTER_S = 0.5
FROZEN_AFTER_S = 1.0
MOVED_AFTER_S = 1.0
LEAST_SPREAD = 8.0
"""Difference of the 5 % darkest and brightest pixels. Black shows 0, a lens cap 3, gain 0.12 24."""
MOST_RMS_PX = 3.0
"""A camera turned by 0.5 deg shows 4.6 px, which are 5 mm at the robot."""


class CameraWatch:
    """Finds what is wrong with the pictures of a camera.

    Each fault is reported when it begins, and again only if the camera was good in between. The
    limits were measured on synthetic pictures.

    Args:
        blind_after_s: How long nothing of a driven robot may be seen.

    Attributes:
        wrong: The fault that lasts; None while the camera is good.
    """

    def __init__(self, blind_after_s: float) -> None:
        self.wrong: BuiltInFault | None = None
        self._blind_after_s = blind_after_s
        self._last: Sighting | None = None
        self._arrived_s = 0.0
        self._changed_s = self._surveyed_s = self._found_s = 0.0

    def take(self, sighting: Sighting, now_s: float) -> None:
        """Take in a sighting that has arrived."""
        if self._last is None or sighting.digest != self._last.digest:
            self._changed_s = now_s
        if sighting.rms_px is None or sighting.rms_px <= MOST_RMS_PX:
            self._surveyed_s = now_s
        if sighting.marks:
            self._found_s = now_s
        self._last, self._arrived_s = sighting, now_s

    def look(self, now_s: float, why: str, *, driven: bool) -> list[FaultReport]:
        """Return the fault that begins now, if one does.

        Args:
            now_s: Time.
            why: Why the camera gives no pictures; empty if nothing is known.
            driven: Whether wheels are driven.
        """
        if not driven:
            self._found_s = now_s
        was, (self.wrong, detail) = self.wrong, self._fault(now_s, why)
        if self.wrong is None or self.wrong is was:
            return []
        return [self.wrong.report(f"{self.wrong.meaning}{detail}")]

    def _fault(self, now_s: float, why: str) -> tuple[BuiltInFault | None, str]:
        """Return what is wrong now, and what to add to its meaning."""
        last = self._last
        if has_come(now_s, self._arrived_s + SILENT_AFTER_S):
            return BuiltInFault.VISION_SILENT, why and f": {why}"
        if last is None:
            return None, ""
        if has_come(now_s, self._changed_s + FROZEN_AFTER_S):
            return BuiltInFault.VISION_FROZEN, ""
        if last.gray_spread < LEAST_SPREAD:
            spread = f"{last.gray_spread:.0f} of 255"
            return BuiltInFault.VISION_DARK, f": dark and bright differ by {spread}"
        if has_come(now_s, self._surveyed_s + MOVED_AFTER_S):
            off = f"{last.rms_px:.1f} px off; survey it again"
            return BuiltInFault.VISION_MOVED, f": the setup's tags are {off}"
        if has_come(now_s, self._found_s + self._blind_after_s):
            return BuiltInFault.VISION_BLIND, ""
        return None, ""
