"""Joints, wheels and what else is measured, with limits, trends and heat."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import degrees, isnan

from textual.content import Content

from pirate_sm.console.anatomy import Motor
from pirate_sm.console.panels import BAD, GOOD, MUTED, WARN, Part, line
from pirate_sm.console.snapshot import Snapshot

_BARS = " ▁▂▃▄▅▆▇█"
_NEAR, _HIGH = 0.8, 0.95
"""Shares of a limit from which on a value is marked."""

_WITHOUT_TREND = 70
_LEAST_TREND = 8
_WITH_TORQUE = 70

_WRITE: Mapping[str, Callable[[float], str]] = {
    "angle": lambda value: f"{degrees(value):z.1f}°",
    "length": lambda value: f"{value * 1e3:.1f} mm",
    "distance": lambda value: f"{value:z.3f} m",
    "speed": lambda value: f"{value * 1e3:z.0f} mm/s",
    "acceleration": lambda value: f"{value:.1f} m/s²",
}


def body(snapshot: Snapshot, width: int) -> list[Content]:
    """The table, as wide as there is room for."""
    anatomy = snapshot.scene.anatomy
    lines = [_heading("joint", "angle", width)]
    lines += [_motor(snapshot, each, "°", width) for each in (*anatomy.joints, *anatomy.rolls)]
    lines.append(_heading("wheel", "speed", width))
    lines += [_motor(snapshot, each, "", width) for each in anatomy.wheels]
    return [*lines, *_readings(snapshot, width)]


def _heading(name: str, value: str, width: int) -> Content:
    torque = f"{'torque':>9} " if width >= _WITH_TORQUE else ""
    trend = "trend" if width >= _WITHOUT_TREND + _LEAST_TREND else ""
    columns = (
        f"{name:<8}{value:>11} {'of limit':<12}{torque}",
        f"{'current':>7} {'of stall':<9}{'heat':<10} {trend}",
    )
    return line(("".join(columns), MUTED))


def _motor(snapshot: Snapshot, motor: Motor, unit: str, width: int) -> Content:
    signals = snapshot.signals
    value = signals.get(motor.value, float("nan"))
    written = "–"
    if not isnan(value):
        written = f"{degrees(value):z.1f}°" if unit else f"{value:z.2f} rad/s"
    parts: list[Part] = [(f"{motor.name[:8]:<8}", MUTED), f"{written:>11} "]
    parts += _centred(value, motor.limit, marked=bool(unit))
    if width >= _WITH_TORQUE:
        torque = signals.get(motor.torque, float("nan"))
        parts.append(f"{'' if isnan(torque) else f'{torque * 1e3:z.0f} mNm':>9} ")
    parts += _current(snapshot, motor)
    parts += _heat(snapshot, motor)
    room = width - _WITHOUT_TREND
    if room >= _LEAST_TREND:
        parts.append((f" {_trend(snapshot, motor, room - 1)}", "$accent"))
    return line(*parts)


def _centred(value: float, limit: float, *, marked: bool) -> list[Part]:
    """A dot on a scale from minus to plus the limit; an exclamation mark where it is near."""
    half = 5
    if isnan(value) or not limit:
        return [(" " * (2 * half + 2), MUTED)]
    share = max(-1.0, min(1.0, value / limit))
    place = round((share + 1) * half)
    scale = "".join("●" if n == place else ("┼" if n == half else "─") for n in range(2 * half + 1))
    near = marked and abs(value) >= _HIGH * limit
    return [(scale, WARN if near else ""), ("!" if near else " ", WARN)]


def _current(snapshot: Snapshot, motor: Motor) -> list[Part]:
    current = snapshot.signals.get(motor.current, float("nan"))
    if isnan(current):
        return [f"{'–' if motor.current else '':>7} {'':<9}"]
    share = abs(current) / motor.stall_a if motor.stall_a else 0.0
    full = min(6, round(share * 6))
    mark = "!" if share >= _HIGH else " "
    style = BAD if share >= _HIGH else WARN if share >= _NEAR else GOOD
    return [
        f"{current * 1e3:4.0f} mA ",
        ("█" * full, style),
        ("░" * (6 - full), MUTED),
        (f"{mark}  ", style),
    ]


def _heat(snapshot: Snapshot, motor: Motor) -> list[Part]:
    """How long the motor has been as near its stall current as a fault rule allows for a time."""
    state, rules = snapshot.state, snapshot.scene.robot.faults
    if state is None or not motor.heat:
        return [f"{'':<10}"]
    shares = []
    for index in motor.heat:
        since_s = state.faults.since[index]
        spent_s = 0.0 if isnan(since_s) else snapshot.now_s - since_s
        shares.append((spent_s / rules[index].held_s, spent_s, rules[index].held_s))
    share, spent_s, held_s = max(shares)
    if share <= 0:
        return [("cool".ljust(10), MUTED)]
    style = BAD if share >= _NEAR else WARN
    return [(f"{'HOT' if share >= 1 else 'warm'} {spent_s:.0f}/{held_s:.0f}s".ljust(10), style)]


def _trend(snapshot: Snapshot, motor: Motor, room: int) -> str:
    """The last values, each as high as its share of the stall current, or of the largest."""
    values = [abs(each) for each in (snapshot.trends or {}).get(motor.current or motor.value, ())]
    return sparkline(values[-room:], motor.stall_a or max(values, default=0.0))


def sparkline(values: Sequence[float], full: float) -> str:
    """One character for each value."""
    top = len(_BARS) - 1
    if not full:
        return _BARS[1] * len(values)
    return "".join(_BARS[max(1, min(top, round(each / full * top)))] for each in values)


def travelled(snapshot: Snapshot) -> list[Content]:
    """Return how far and how fast, for a screen that has no room for everything."""
    parts: list[Part] = []
    for label, signal, kind in snapshot.scene.anatomy.readings:
        if kind in ("distance", "speed"):
            value = snapshot.signals.get(signal, float("nan"))
            written = "–" if isnan(value) else _WRITE[kind](value)
            parts += [(f"{label} ", MUTED), f"{written}   "]
    return [line(*parts)] if parts else []


def _readings(snapshot: Snapshot, width: int) -> list[Content]:
    cells: list[tuple[str, str]] = []
    for label, signal, kind in snapshot.scene.anatomy.readings:
        value = snapshot.signals.get(signal, float("nan"))
        cells.append((label, "–" if isnan(value) else _WRITE[kind](value)))
    room = 20
    across = max(1, width // room)
    lines = []
    for start in range(0, len(cells), across):
        parts: list[Part] = []
        for label, written in cells[start : start + across]:
            parts += [(f"{label} ", MUTED), written.ljust(max(room - len(label) - 1, 0))]
        lines.append(line(*parts))
    return lines
