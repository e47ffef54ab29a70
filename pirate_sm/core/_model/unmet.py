"""The conditions that a failed command has waited for, and their wording.

The wording is common to all views: what was awaited, what is shown, and what to do.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees, inf, isinf, isnan, nan
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.core.spelling import listed

Unknown: TypeAlias = Literal["", "silent", "implausible", "missing"]
HARDLY = 0.1
"""A signal that has come nearer by a smaller share of its way counts as not moved [decided]."""


class Unmet(NamedTuple):
    """A limit of one signal that did not hold when a command failed.

    Attributes:
        signal: Name of the signal.
        unit: Its SI unit; empty without one.
        least: The least value that was awaited, SI; ``-inf`` without a limit.
        most: The largest value; ``inf`` without a limit.
        magnitude: Whether the limits are those of the magnitude, whatever the sign.
        value: What the signal shows; NaN where it is unknown.
        age_s: How long ago its board last reported; infinite if it never did, NaN for a signal
            without a board.
        change: By how much the signal has changed since the command, or its present stage, began;
            NaN where it is unknown now or was unknown then.
        unknown: Why the value is unknown; empty where it is known. ``silent``: the board does not
            report. ``implausible``: its readings cannot be true. ``missing``: none of these.
        board: The board that reports the signal; empty without one.
    """

    signal: str
    unit: str
    least: float
    most: float
    magnitude: bool = False
    value: float = nan
    age_s: float = nan
    change: float = nan
    unknown: Unknown = ""
    board: str = ""

    @property
    def still_moves(self) -> bool:
        """Return whether the signal is a rate or a speed that should be smaller."""
        return self.unit.endswith("/s") and not self.unknown and not isinf(self.most - self.least)

    @property
    def hardly_moved(self) -> bool:
        """Return whether the signal has not come nearer to its limits by more than noise."""
        now, began = self.value, self.value - self.change
        if self.magnitude:
            now, began = abs(now), abs(began)
        return self._off(began) - self._off(now) < HARDLY * self._off(began)

    def _off(self, value: float) -> float:
        return max(self.least - value, value - self.most, 0.0)


_SHOWN = {"rad": ("deg", degrees(1)), "Nm": ("mNm", 1000.0), "m": ("mm", 1000.0)}
"""Per SI unit the unit of messages, and the factor to it."""


def unmet_words(unmet: Sequence[Unmet]) -> str:
    """Return what was awaited and what the sensors show instead."""
    return "; ".join(f"{_awaited(each)}, {shown_words(each)}" for each in unmet)


def with_unmet(reason: str, unmet: Sequence[Unmet]) -> str:
    """Return why a command was ended before its time, and what it still awaited."""
    return f"{reason}; it was not done yet: {unmet_words(unmet)}" if unmet else reason


def advice(unmet: Sequence[Unmet], command: str) -> str:
    """Return what to do next after a command failed; empty without unmet conditions."""
    if not unmet:
        return ""
    unknown = [each for each in unmet if each.unknown]
    if unknown:
        boards = listed(dict.fromkeys(each.board for each in unknown if each.board))
        names = listed(dict.fromkeys(each.signal for each in unknown))
        where = f" of {boards}" if boards else ""
        return f"check the sensor of {names} and the cable{where}, then repeat {command}"
    moving = [each.signal for each in unmet if each.still_moves]
    if moving:
        return (
            f"it still moves ({', '.join(moving)}): give {command} more time, or see what moves it"
        )
    resting = [each.signal for each in unmet if each.hardly_moved]
    if resting:
        why = f"see why {listed(dict.fromkeys(resting))} did not come nearer"
        return f"{why} (something blocks it, or its motor has no power), then repeat {command}"
    names = listed(dict.fromkeys(each.signal for each in unmet))
    return f"see what stops {names}, or give {command} more time, then repeat it"


def _awaited(it: Unmet) -> str:
    return f"{it.signal} should be {_range(it)}"


def _range(it: Unmet) -> str:
    sign = " in either direction" if it.magnitude else ""
    if it.least == -it.most and not isinf(it.most):
        return f"within {_quantity(it.most, it.unit)} of zero"
    if it.most == inf:
        return f"at least {_quantity(it.least, it.unit)}{sign}"
    if it.least == -inf:
        return f"at most {_quantity(it.most, it.unit)}{sign}"
    least = _quantity(it.least, it.unit).partition(" ")[0]
    return f"between {least} and {_quantity(it.most, it.unit)}{sign}"


def shown_words(it: Unmet, *, with_change: bool = True) -> str:
    """Return what the signal shows, how old that is, and by how much it has changed."""
    match it.unknown:
        case "silent" if isinf(it.age_s):
            return "has never had a value"
        case "silent":
            return f"has had no value for {_time(it.age_s)}"
        case "implausible":
            return "has no value that can be true"
        case "missing":
            return "has no value"
        case "":
            age = "" if isnan(it.age_s) else f" ({_time(it.age_s)} old)"
            changed = f" and {_changed(it)}" if with_change else ""
            return f"shows {_quantity(it.value, it.unit)}{age}{changed}"


def _changed(it: Unmet) -> str:
    if isnan(it.change):
        return "was unknown before"
    if it.change == 0:
        return "has not changed"
    return f"has changed by {_quantity(it.change, it.unit)}"


def _quantity(value: float, unit: str) -> str:
    shown, scale = _SHOWN.get(unit, (unit, 1.0))
    return f"{float(f'{value * scale:.3g}') + 0.0:g} {shown}".strip()


def _time(age_s: float) -> str:
    return f"{age_s:.3g} s" if age_s >= 1 else f"{age_s * 1000:.0f} ms"
