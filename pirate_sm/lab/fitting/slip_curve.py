"""The relation of slip and friction of a wheel: direct estimates, two fitted curves, and refusals.

A value that the data cannot give is unknown, with the reason.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import pairwise, product
from math import nan, pi, sin, sqrt
from pathlib import Path

import numpy as np

from pirate_sm.core.errors import UsageError, not_installed
from pirate_sm.core.loading import load_pipe
from pirate_sm.lab.fitting.measurements import Estimate, estimate_of
from pirate_sm.simulation.arrays import Floats
from pirate_sm.views.drawing.svg.plot import Plot, PlotSeries

# --- Gaussian processes --------------------------------------------------------------------------
# Equation 2-21 lacks the inverse of the covariance, 2-22 has the wrong sign before its noise.
# Values are centred; log σ_f, log l and log σ_n are those of the greatest likelihood, found along
# the analytic gradient (Rasmussen and Williams 2006, eq. 5.9).


try:
    from scipy.optimize import Bounds, least_squares, minimize
except ModuleNotFoundError:
    raise not_installed("a curve of slip and friction", "scipy", "fit") from None

_FLAT, _ENOUGH = 1e-6, 1e-14
"""The search ends where the gradient of the log likelihood is below the first, or where a step
raises it by less than the second, as a share."""

_BELOW, _ABOVE = np.array([7.0, 5.0, 9.0]), np.array([7.0, 5.0, 7.0])
"""How far the logs are searched to each side of the start."""

_LEAST_NOISE = 1e-10
"""Variance added for the sake of the arithmetic, over that of the curve."""


@dataclass(frozen=True)
class GaussianProcess:
    """A process that was given points.

    Attributes:
        x: Where its points lie.
        mean: What was subtracted from their values.
        logs: log σ_f, log l, log σ_n.
        likelihood: Log marginal likelihood.
        factor: Lower triangle of the covariance's Cholesky decomposition.
        weights: The covariance's inverse times the centred values.
    """

    x: Floats
    mean: float
    logs: Floats
    likelihood: float
    factor: Floats
    weights: Floats

    def __call__(self, x: Floats) -> tuple[Floats, Floats]:
        """Return mean and standard deviation of the curve, without its noise (eq. 2-21, 2-22)."""
        across = _covariance(self.x, x, self.logs)
        halfway = np.linalg.solve(self.factor, across)
        variance = np.exp(2 * self.logs[0]) - np.sum(halfway**2, axis=0)
        return self.mean + across.T @ self.weights, np.sqrt(np.maximum(variance, 0.0))


def fit_process(x: Floats, y: Floats) -> GaussianProcess:
    """Return the Gaussian process of the points.

    Args:
        x: Where they lie.
        y: Their values, with white noise.

    Raises:
        UsageError: There are fewer than three points.
    """
    x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if len(x) < 3:
        raise UsageError(f"a Gaussian process needs at least 3 points, got {len(x)}")
    spread, width = max(float(np.std(y)), 1e-9), max(float(np.ptp(x)), 1e-9)
    starts = [np.log([spread, share * width, 0.1 * spread]) for share in (0.03, 0.1, 0.3)]
    centred = y - np.mean(y)
    tops = [_climb(x, centred, start) for start in starts]
    logs = max(tops, key=lambda each: _likelihood(x, centred, each)[0])
    likelihood, _, factor, weights = _likelihood(x, centred, logs)
    return GaussianProcess(x, float(np.mean(y)), logs, likelihood, factor, weights)


def _covariance(one: Floats, other: Floats, logs: Floats) -> Floats:
    """Return the covariances between two sets of places (eq. 2-14)."""
    apart = (np.asarray(one)[:, None] - np.asarray(other)[None, :]) / np.exp(logs[1])
    covariance: Floats = np.exp(2 * logs[0] - 0.5 * apart**2)
    return covariance


def _likelihood(x: Floats, y: Floats, logs: Floats) -> tuple[float, Floats, Floats, Floats]:
    """Return log likelihood, its gradient, the Cholesky factor and the weights."""
    clean = _covariance(x, x, logs)
    noise = np.exp(2 * logs[2])
    extra = _LEAST_NOISE * np.exp(2 * logs[0])
    factor: Floats = np.linalg.cholesky(clean + (noise + extra) * np.eye(len(x)))
    inverse = np.linalg.inv(factor)
    precision = inverse.T @ inverse
    weights: Floats = precision @ y
    likelihood = -0.5 * (y @ weights) - np.sum(np.log(np.diag(factor)))
    likelihood -= 0.5 * len(x) * np.log(2 * np.pi)
    pull = np.outer(weights, weights) - precision
    apart = (x[:, None] - x[None, :]) ** 2 / np.exp(2 * logs[1])
    gradient = np.array(
        [np.sum(pull * clean), 0.5 * np.sum(pull * clean * apart), noise * np.trace(pull)]
    )
    return float(likelihood), gradient, factor, weights


def _climb(x: Floats, y: Floats, start: Floats) -> Floats:
    """Return the logs of the parameters at a top of the likelihood."""

    def downhill(logs: Floats) -> tuple[float, Floats]:
        try:
            likelihood, gradient, *_ = _likelihood(x, y, logs)
        except np.linalg.LinAlgError:
            return np.inf, np.zeros(3)
        return -likelihood, -gradient

    # A length of far more or less than what the points span, or no noise, says nothing more.
    bounds = Bounds(start - _BELOW, start + _ABOVE)
    options = {"gtol": _FLAT, "ftol": _ENOUGH}
    found = minimize(downhill, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return np.asarray(found.x, dtype=np.float64)


# --- the Magic formula ---------------------------------------------------------------------------

NAMES = ("B", "C", "D", "E")
_BOUNDS = (0.0, 1.0, 0.0, -np.inf), (np.inf, 2.0, np.inf, 1.0)
_SURE = 1.96
"""Standard deviations that hold 95 % of a normal distribution."""


@dataclass(frozen=True)
class MagicFormula:
    """A fitted curve y = D sin(C atan(B x − E (B x − atan(B x)))).

    Attributes:
        parameters: B, C, D, E.
        interval: Half the width of each parameter's 95 % interval; infinite where the data do not
            determine it.
        misfit: Root mean square of what the curve is off by.
    """

    parameters: Floats
    interval: Floats
    misfit: float

    def __call__(self, x: Floats) -> Floats:
        """Return the curve's values."""
        return magic(x, self.parameters)

    @property
    def limit(self) -> float:
        """The value that the curve comes to where x is large."""
        _, shape, peak, curvature = self.parameters
        return float(peak * sin(shape * pi / 2)) if curvature < 1 else float("nan")


def magic(x: Floats, parameters: Floats) -> Floats:
    """Return the Magic formula's values for B, C, D, E."""
    stiffness, shape, peak, curvature = parameters
    scaled = stiffness * np.asarray(x, dtype=np.float64)
    bent = scaled - curvature * (scaled - np.arctan(scaled))
    values: Floats = peak * np.sin(shape * np.arctan(bent))
    return values


def fit_magic(x: Floats, y: Floats) -> MagicFormula:
    """Return the Magic formula that is nearest to the points by least squares.

    Args:
        x: Slip, not negative: its speed, or −λ.
        y: Friction, not negative.

    Raises:
        UsageError: There are fewer points than a curve of four parameters needs.
    """
    if len(x) <= len(NAMES):
        raise UsageError(f"a Magic formula needs more than {len(NAMES)} points, got {len(x)}")
    middle, most = float(np.median(x)), max(float(np.max(y)), 1e-6)
    starts = product((0.3 / middle, 3.0 / middle, 30.0 / middle), (1.5,), (most,), (0.0, -6.4))
    fits = [
        least_squares(lambda at: magic(x, at) - y, start, bounds=_BOUNDS, x_scale="jac")
        for start in starts
    ]
    best = min(fits, key=lambda each: float(each.cost))
    squares = 2.0 * float(best.cost)
    return MagicFormula(best.x, _interval(best.jac, squares), sqrt(squares / len(x)))


def _interval(slope: Floats, squares: float) -> Floats:
    """Return half the width of each parameter's interval, from the residuals' own spread."""
    rows, columns = slope.shape
    try:
        variance = np.diag(np.linalg.inv(slope.T @ slope)) * squares / (rows - columns)
    except np.linalg.LinAlgError:
        return np.full(columns, np.inf)
    return np.where(variance >= 0, _SURE * np.sqrt(np.abs(variance)), np.inf)


# --- curves --------------------------------------------------------------------------------------


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


# --- plots ---------------------------------------------------------------------------------------


_PLACES = 300


def slip_plot(curve: SlipCurve, title: str) -> Plot:
    """Return medians of the points, the Magic formula, and the Gaussian process with its band."""
    slip, friction = curve.bins
    series = [PlotSeries("medians of the points", slip.tolist(), friction.tolist(), "dots")]
    if curve.magic is not None and curve.process is not None:
        x = np.geomspace(slip.min(), slip.max(), _PLACES)
        mean, deviation = curve.process(np.log10(x))
        low, high = mean - _SURE * deviation, mean + _SURE * deviation
        series = [
            PlotSeries("", x.tolist(), low.tolist(), "band", high.tolist(), colour=2),
            *series,
            PlotSeries("Gaussian process, 95 %", x.tolist(), mean.tolist(), colour=2),
            PlotSeries("Magic formula", x.tolist(), curve.magic(x).tolist(), colour=1),
        ]
    return Plot(title, "slip speed, m/s", "friction in use |F| / N", tuple(series), log_x=True)


# --- friction of a pipe --------------------------------------------------------------------------


_BLOCK = re.compile(r"^friction:.*\n(?:[ \t]+.*\n)*", re.MULTILINE)


def friction_line(static: float, kinetic: float) -> str:
    """Return the line that gives a pipe this friction."""
    return f"friction: {{static: {max(static, kinetic):.3f}, kinetic: {kinetic:.3f}}}"


def pipe_with_friction(path: Path, static: float, kinetic: float) -> str:
    """Return the text of a pipe file with this friction instead of its own; all else stays.

    Raises:
        LoadError: The file is not a pipe.
        UsageError: It cannot be changed line by line.
    """
    _, document = load_pipe(path)
    line, text = f"{friction_line(static, kinetic)}\n", document.text
    text = text if text.endswith("\n") else f"{text}\n"
    if text.lstrip().startswith("{"):
        raise UsageError(f"'{path}' is written in braces: put in by hand {line.strip()}")
    if "friction" in document.data:
        return _BLOCK.sub(line, text, count=1)
    return text + line
