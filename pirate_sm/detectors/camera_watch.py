"""Judges whether a camera can be believed: its faults, each of which silences the detector."""

from __future__ import annotations

from pirate_sm.engine.deadlines import has_come
from pirate_sm.model.events import FaultReport
from pirate_sm.model.fault_codes import BuiltInFault
from pirate_sm.model.sighting import Sighting

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
        wrong: The faults that last.
    """

    def __init__(self, blind_after_s: float) -> None:
        self.wrong: frozenset[BuiltInFault] = frozenset()
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
        """Return the faults that begin now.

        Args:
            now_s: Time.
            why: Why the camera gives no pictures; empty if nothing is known.
            driven: Whether wheels are driven.
        """
        if not driven:
            self._found_s = now_s
        found = self._faults(now_s)
        began = [fault for fault in found if fault not in self.wrong]
        self.wrong = frozenset(found)
        return [
            fault.report(f"{fault.meaning}{_detail(fault, self._last, why)}") for fault in began
        ]

    def _faults(self, now_s: float) -> list[BuiltInFault]:
        if has_come(now_s, self._arrived_s + SILENT_AFTER_S):
            return [BuiltInFault.VISION_SILENT]
        if self._last is None:
            return []
        if has_come(now_s, self._changed_s + FROZEN_AFTER_S):
            return [BuiltInFault.VISION_FROZEN]
        if self._last.gray_spread < LEAST_SPREAD:
            return [BuiltInFault.VISION_DARK]
        if has_come(now_s, self._surveyed_s + MOVED_AFTER_S):
            return [BuiltInFault.VISION_MOVED]
        if has_come(now_s, self._found_s + self._blind_after_s):
            return [BuiltInFault.VISION_BLIND]
        return []


def _detail(fault: BuiltInFault, last: Sighting | None, why: str) -> str:
    if fault is BuiltInFault.VISION_SILENT and why:
        return f": {why}"
    if fault is BuiltInFault.VISION_MOVED and last is not None and last.rms_px is not None:
        return f": the setup's tags are {last.rms_px:.1f} px off; survey it again"
    if fault is BuiltInFault.VISION_DARK and last is not None:
        return f": dark and bright differ by {last.gray_spread:.0f} of 255"
    return ""
