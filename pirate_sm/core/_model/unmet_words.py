"""The wording of unmet conditions, common to all views: what was awaited, is shown, and to do."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees, inf, isinf, isnan

from pirate_sm.core._model.unmet import Unmet
from pirate_sm.core.spelling import listed

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
