"""Duty cycles by plain numbers, for the engine and compiled for the simulator alike."""

from __future__ import annotations


def position_duty(
    error_rad: float, loss: float, gain: float, threshold_rad: float, least: float, limit: float
) -> float:
    """Return the duty cycle of a position loop; 0 within the threshold or for an unknown angle.

    Args:
        error_rad: How far the joint is from its angle.
        loss: Share of reports that is lost. It reduces the gain: the array that stops the joint
            may come late, so the joint approaches its angle more slowly.
        gain: As in `PositionSpec`; so are the others.
        threshold_rad: Within this the loop is content.
        least: The smallest duty that is not 0.
        limit: The largest.
    """
    if not abs(error_rad) > threshold_rad:
        return 0.0
    size = min(max(abs(error_rad) * gain * (1 - loss), least), limit)
    return size if error_rad > 0 else -size


def quantised(value: float, resolution: float) -> float:
    """Return the value rounded to the resolution of the wire."""
    return round(value / resolution) * resolution
