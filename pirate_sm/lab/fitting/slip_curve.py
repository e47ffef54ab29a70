"""The relation of slip and friction of a wheel: direct estimates, two fitted curves, and refusals.

A value that the data cannot give is unknown, with the reason.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import nan

import numpy as np

from pirate_sm.core.errors import UsageError
from pirate_sm.lab.fitting.estimate import Estimate, estimate_of
from pirate_sm.lab.fitting.gaussian_process import GaussianProcess, fit_process
from pirate_sm.lab.fitting.magic_formula import MagicFormula, fit_magic
from pirate_sm.simulation.arrays import Floats

PLATEAU_FROM_M_S = 0.005
"""Slip speeds above it show kinetic friction (dynamics [D])."""

_PEAK_FROM, _PEAK_UP_TO = 0.5, 1.6
"""Static friction is looked for between these shares of the threshold: at rest it is not used."""

_NEAR = 0.15
"""Points this near to the threshold, as a share of it, are evidence of the peak's height."""

_QUANTILE = 0.999
_LEAST_POINTS = 20
"""Fewer points are no evidence of a peak or of a plateau."""

_MAGIC_BINS, _PROCESS_BINS = 60, 170
_LEAST_BINS = 12
_SURE = 1.96


@dataclass(frozen=True)
class SlipCurve:
    """What a run says of the friction of a wheel, or of several.

    Attributes:
        points: How many were used.
        most_slip_m_s: The highest slip speed among them.
        static: The peak, directly.
        kinetic: The plateau, directly.
        bins: Medians of slip speed and friction, by slip, to which the Magic formula is fitted.
        magic: The fitted Magic formula; None where there are too few points.
        magic_peak: Of its curve.
        magic_plateau: Of its curve.
        process: The Gaussian process over log10 of the slip speed; None where there are too few.
        process_peak: Of its curve.
    """

    points: int
    most_slip_m_s: float
    static: Estimate
    kinetic: Estimate
    bins: tuple[Floats, Floats]
    magic: MagicFormula | None
    magic_peak: Estimate
    magic_plateau: Estimate
    process: GaussianProcess | None
    process_peak: Estimate


def fit_slip_curve(slip: Floats, friction: Floats, threshold: float | None = None) -> SlipCurve:
    """Return what the points say of static and kinetic friction.

    Args:
        slip: Slip speeds, m/s, either way, in the order of time.
        friction: Friction coefficients in use, |F| / N, either way; NaN where unknown.
        threshold: Slip speed of static friction, m/s; None: where friction is highest.

    Raises:
        UsageError: No point is known.
    """
    known = np.isfinite(slip) & np.isfinite(friction)
    slip, friction = np.abs(slip[known]), np.abs(friction[known])
    if not len(slip):
        raise UsageError(
            "slip and friction are never known at the same time: nothing can be fitted"
        )
    bins = medians(slip, friction, _MAGIC_BINS)
    finer = medians(slip, friction, _PROCESS_BINS)
    peak_at = threshold or _highest(*bins)
    enough = len(bins[0]) >= _LEAST_BINS
    magic = fit_magic(*bins) if enough else None
    process = fit_process(np.log10(finer[0]), finer[1]) if enough else None
    most = float(np.max(slip))
    static = _static(slip, friction, peak_at)
    kinetic = _kinetic(slip, friction)
    return SlipCurve(
        points=len(slip),
        most_slip_m_s=most,
        static=static,
        kinetic=kinetic,
        bins=bins,
        magic=magic,
        magic_peak=_magic_peak(magic, static, most),
        magic_plateau=_magic_plateau(magic, kinetic),
        process=process,
        process_peak=_process_peak(process, static),
    )


def medians(slip: Floats, friction: Floats, count: int) -> tuple[Floats, Floats]:
    """Return medians of slip and friction in at most this number of bins, equally wide in log slip.

    What is below a thousandth of the highest slip is left out: it is rest, not slip.
    """
    most = float(np.max(slip))
    if most <= 0:
        return np.zeros(0), np.zeros(0)
    least = max(most * 1e-3, min(float(np.min(slip[slip > 0])), most))
    place = np.floor(
        np.log(np.maximum(slip, 1e-12) / least) / np.log(most / least * 1.0001) * count
    )
    order = np.argsort(place, kind="stable")
    edges = np.searchsorted(place[order], np.arange(count + 1))
    groups = [order[a:b] for a, b in pairwise(edges) if b > a]
    return (
        np.array([np.median(slip[each]) for each in groups]),
        np.array([np.median(friction[each]) for each in groups]),
    )


def _highest(slip: Floats, friction: Floats) -> float:
    """Return the slip speed at which friction is highest, m/s; 0 without any."""
    return float(slip[np.argmax(friction)]) if len(slip) else 0.0


def _static(slip: Floats, friction: Floats, peak_at: float) -> Estimate:
    """Return the quantile of friction around the threshold; a bound where nothing slips."""
    around = (slip > _PEAK_FROM * peak_at) & (slip < _PEAK_UP_TO * peak_at)
    bound = float(np.quantile(friction, _QUANTILE))
    if np.max(slip, initial=0.0) < _PEAK_UP_TO * peak_at:
        reason = "slip never goes beyond the peak: friction may be higher than what was used"
        return Estimate(low=bound, reason=reason)
    near = np.abs(slip - peak_at) < _NEAR * peak_at
    if np.count_nonzero(near) < _LEAST_POINTS:
        return Estimate(low=bound, reason="too few points around the peak")
    return estimate_of(friction[around], lambda values: float(np.quantile(values, _QUANTILE)))


def _kinetic(slip: Floats, friction: Floats) -> Estimate:
    """Return the median of friction where the wheel surely slips."""
    above = slip > PLATEAU_FROM_M_S
    count = int(np.count_nonzero(above))
    if count < _LEAST_POINTS:
        reason = (
            f"{count} points above {PLATEAU_FROM_M_S * 1000:g} mm/s of slip, "
            f"a plateau needs {_LEAST_POINTS}"
        )
        return Estimate(reason=reason)
    return estimate_of(friction[above], lambda values: float(np.median(values)))


def _magic_peak(magic: MagicFormula | None, static: Estimate, most: float) -> Estimate:
    if magic is None or not static.known:
        return Estimate(reason=static.reason or "too few points for a curve")
    curve = magic(np.geomspace(most * 1e-4, most, 400))
    half = float(magic.interval[2])
    value = float(np.max(curve))
    return Estimate(value, value - half, value + half)


def _magic_plateau(magic: MagicFormula | None, kinetic: Estimate) -> Estimate:
    """Return what the curve comes to; without points that slip it would be a guess."""
    if magic is None or not kinetic.known:
        return Estimate(reason=kinetic.reason or "too few points for a curve")
    # Beyond the points the curve is a guess, so its plateau is what it has among them.
    return Estimate(magic.limit, nan, nan) if magic.limit > 0 else Estimate(reason="no plateau")


def _process_peak(process: GaussianProcess | None, static: Estimate) -> Estimate:
    if process is None or not static.known:
        return Estimate(reason=static.reason or "too few points for a curve")
    curve, deviation = process(process.x)  # between far points it may go anywhere
    top = int(np.argmax(curve))
    half = _SURE * float(deviation[top])
    return Estimate(float(curve[top]), float(curve[top]) - half, float(curve[top]) + half)
