"""Joints, wheels and motors: what is sent and measured, with limits, trends and heat."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import degrees, isnan, nan, tau

from rich.text import Text

from pirate_sm.views.drawing.canvas import ACROSS, Canvas
from pirate_sm.views.showing.effect_lines import setpoint
from pirate_sm.views.showing.robot_anatomy import MotorReadings, ShownReading
from pirate_sm.views.showing.snapshot import TREND_EVERY_S, TREND_LENGTH, Snapshot, sent_name
from pirate_sm.views.showing.text_styles import (
    ACCENT,
    BAD,
    GOOD,
    MUTED,
    STALE,
    STRONG,
    WARN,
    Part,
    ago,
    flowed,
    line,
)

# --- joints and wheels --------------------------------------------------------------------------


_BARS = " ▁▂▃▄▅▆▇█"
_NEAR, _HIGH = 0.8, 0.95
"""Shares of a limit from which on a value is marked."""

_WITHOUT_TREND = 70
_LEAST_TREND = 7
_WITH_TORQUE = 70
_VALUE = 10
"""Width of a reading, so that those next to it stay where they are."""

_WRITE: Mapping[str, Callable[[float], str]] = {
    "angle": lambda value: f"{degrees(value):z.1f}°",
    "length": lambda value: f"{value * 1e3:.1f} mm",
    "distance": lambda value: f"{value:z.3f} m",
    "speed": lambda value: f"{value * 1e3:z.0f} mm/s",
    "acceleration": lambda value: f"{value:.1f} m/s²",
}


def body(snapshot: Snapshot, width: int) -> list[Text]:
    """Return the table, as wide as there is room for, without its heading."""
    anatomy = snapshot.scene.anatomy
    lines = [_motor(snapshot, each, "°", width) for each in (*anatomy.joints, *anatomy.rolls)]
    lines += [_motor(snapshot, each, "", width) for each in anatomy.wheels]
    return [*lines, *_in_cells(_readings(snapshot), width)]


def heading(width: int) -> str:
    """Return what the columns of the table are."""
    torque = f"{'torque':>9} " if width >= _WITH_TORQUE else ""
    trend = "trend" if width >= _WITHOUT_TREND + _LEAST_TREND else ""
    columns = (
        f"{'motor':<8}{'angle/speed':>11} {'of limit':<12}{torque}",
        f"{'current':>7} {'of stall':<9}{'heat':<10} {trend}",
    )
    return "".join(columns).rstrip()


def briefly(snapshot: Snapshot, width: int) -> list[Text]:
    """Return angles and readings alone, where there is no room for the table."""
    joints = []
    for motor in (*snapshot.scene.anatomy.joints, *snapshot.scene.anatomy.rolls):
        value = snapshot.signals.get(motor.value, nan)
        written = "–" if isnan(value) else _WRITE["angle"](value)
        joints.append((motor.name, _with_age(snapshot, motor.value, written)))
    return _in_cells([*joints, *_readings(snapshot)], width)


def _with_age(snapshot: Snapshot, signal: str, written: str) -> str:
    """Return a value, marked and with its age where it is not that of the current moment."""
    if snapshot.is_fresh(signal):
        return written
    return f"{STALE}{written} {ago(snapshot.age_s(signal))}".rstrip()


def _motor(snapshot: Snapshot, motor: MotorReadings, unit: str, width: int) -> Text:
    signals = snapshot.signals
    value = signals.get(motor.value, nan)
    written = measured(value, angle=bool(unit))
    if not snapshot.is_fresh(motor.value):
        age = ago(snapshot.age_s(motor.value))
        since = f"no report for {age}" if age else "as last reported"
        return line((f"{motor.name[:8]:<8}{STALE + written:>11} {STALE * 11}  {since}", MUTED))
    parts: list[Part] = [(f"{motor.name[:8]:<8}", MUTED), f"{written:>11} "]
    parts += _centred(value, motor.limit, marked=bool(unit))
    if width >= _WITH_TORQUE:
        torque = signals.get(motor.torque, nan)
        parts.append(f"{'' if isnan(torque) else f'{torque * 1e3:z.0f} mNm':>9} ")
    parts += _current(snapshot, motor)
    parts += _heat(snapshot, motor)
    room = width - _WITHOUT_TREND
    if room >= _LEAST_TREND:
        parts.append((f" {_trend(snapshot, motor, room - 1)}", ACCENT))
    return line(*parts)


def measured(value: float, *, angle: bool) -> str:
    """Return the angle or the speed of a motor as text; a dash for an unknown one."""
    if isnan(value):
        return "–"
    return f"{degrees(value):z.1f}°" if angle else f"{value:z.2f} rad/s"


def _centred(value: float, limit: float, *, marked: bool) -> list[Part]:
    """Return a dot on a scale from minus to plus the limit, with an exclamation mark near it."""
    half = 5
    if isnan(value) or not limit:
        return [(" " * (2 * half + 2), MUTED)]
    share = max(-1.0, min(1.0, value / limit))
    place = round((share + 1) * half)
    scale = "".join("●" if n == place else ("┼" if n == half else "─") for n in range(2 * half + 1))
    near = marked and abs(value) >= _HIGH * limit
    return [(scale, WARN if near else ""), ("!" if near else " ", WARN)]


def _current(snapshot: Snapshot, motor: MotorReadings) -> list[Part]:
    current = snapshot.signals.get(motor.current, nan)
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


def _heat(snapshot: Snapshot, motor: MotorReadings) -> list[Part]:
    """Return how long the motor has been at a current that a fault rule allows for a time only."""
    state, rules = snapshot.state, snapshot.scene.robot.faults
    if state is None or not motor.heat:
        return [f"{'':<10}"]
    shares = []
    for index in motor.heat:
        since_s = state.faults.since[index]
        spent_s = 0.0 if isnan(since_s) else snapshot.engine_s - since_s
        shares.append((spent_s / rules[index].held_s, spent_s, rules[index].held_s))
    share, spent_s, held_s = max(shares)
    if share <= 0:
        return [("cool".ljust(10), MUTED)]
    style = BAD if share >= _NEAR else WARN
    return [(f"{'HOT' if share >= 1 else 'warm'} {spent_s:.0f}/{held_s:.0f}s".ljust(10), style)]


def _trend(snapshot: Snapshot, motor: MotorReadings, room: int) -> str:
    """Return the last values, each as high as its share of the stall current, or of the largest."""
    values = [abs(each) for each in (snapshot.trends or {}).get(motor.current or motor.value, ())]
    known = [each for each in values if not isnan(each)]
    return sparkline(values[-room:], motor.stall_a or max(known, default=0.0))


def sparkline(values: Sequence[float], full: float) -> str:
    """Return one character for each value, a gap for NaN."""
    top = len(_BARS) - 1
    shares = [each / full if full else 0.0 * each for each in values]
    return "".join(_BARS[0 if isnan(it) else max(1, min(top, round(it * top)))] for it in shares)


def travelled(snapshot: Snapshot) -> list[Text]:
    """Return how far and how fast, for a screen that has no room for everything."""
    readings = snapshot.scene.anatomy.readings
    parts: list[Part] = []
    for each in readings:
        if each.kind in ("distance", "speed"):
            written = _written(snapshot, each)
            style = MUTED if written.startswith(STALE) else ""
            parts += [(f"{each.label} ", MUTED), (f"{written}  ", style)]
    return [line(*parts)] if parts else []


def _written(snapshot: Snapshot, reading: ShownReading) -> str:
    """Return a reading as shown; a distance begins with that of the runs before this one."""
    value = snapshot.signals.get(reading.signal, nan)
    written = "–" if isnan(value) else _WRITE[reading.kind](value)
    before_m = snapshot.before_m if reading.kind == "distance" else 0.0
    if round(before_m, 2):
        sign = "" if written.startswith("-") else "+"
        written = f"{before_m:z.2f}{sign}{written}"
    return _with_age(snapshot, reading.signal, written)


def _readings(snapshot: Snapshot) -> list[tuple[str, str]]:
    readings = snapshot.scene.anatomy.readings
    return [(each.label, _written(snapshot, each)) for each in readings]


def _in_cells(cells: Sequence[tuple[str, str]], width: int) -> list[Text]:
    """Return the cells, as many side by side as there is room for."""
    shown = []
    for label, written in cells:
        style = MUTED if written.startswith(STALE) else ""
        shown.append(line((f"{label} ", MUTED), (written.ljust(_VALUE), style), " "))
    return flowed(shown, width)


# --- motors -------------------------------------------------------------------------------------


_TEXT = 40
"""Columns of the name and the three numbers; plots have the rest."""

_MOST_ROWS = 3


def motors_heading(width: int) -> str:
    """Return what the columns are."""
    minute = f"{TREND_EVERY_S * TREND_LENGTH:.0f} s"
    numbers = f"{'motor':<8}{'sent':>9} {'measured':>12} {'current':>8} "
    plots = f" {'sent, ' + minute:<{_room(width) + 1}}measured, {minute}"
    return f"{numbers}{plots if len(numbers + plots) <= width else ''}".rstrip()


def motors(snapshot: Snapshot, width: int, height: int) -> list[Text]:
    """Return every motor, in as many lines as there are for each; nothing before the start."""
    everything = snapshot.scene.anatomy.motors
    if snapshot.state is None or not everything:
        return []
    rows = max(1, min(height // len(everything), _MOST_ROWS))
    return [each for motor in everything for each in _motor_lines(snapshot, motor, width, rows)]


def _motor_lines(snapshot: Snapshot, motor: MotorReadings, width: int, rows: int) -> list[Text]:
    trends, slots = snapshot.trends or {}, snapshot.scene.robot.slots
    fresh = snapshot.is_fresh(motor.value)
    lines = [_numbers(snapshot, motor, fresh=fresh), *(line(" " * _TEXT) for _ in range(rows - 1))]
    room, style = _room(width), ACCENT if fresh else MUTED
    if room < ACROSS:
        return lines
    high = slots[motor.slot].high if motor.slot >= 0 else 0.0
    full = high or tau / 2
    sent = _plot(trends.get(sent_name(motor.slot), ()), full, room, rows, style)
    shown = _plot(trends.get(motor.value, ()), motor.limit or tau / 2, room, rows, style)
    return [
        text.append(" ").append_text(one).append(" ").append_text(other)
        for text, one, other in zip(lines, sent, shown, strict=True)
    ]


def _room(width: int) -> int:
    return max((width - _TEXT) // 2 - 1, 0)


def _numbers(snapshot: Snapshot, motor: MotorReadings, *, fresh: bool) -> Text:
    robot, state = snapshot.scene.robot, snapshot.state
    assert state is not None
    sent = (
        setpoint(robot.slots[motor.slot], state.robot.latest[motor.slot]) if motor.slot >= 0 else ""
    )
    value, amperes = (snapshot.signals.get(each, nan) for each in (motor.value, motor.current))
    angle = motor in (*snapshot.scene.anatomy.joints, *snapshot.scene.anatomy.rolls)
    shown = measured(value, angle=angle)
    current = "" if isnan(amperes) else f"{amperes * 1e3:.0f} mA"
    if not fresh:
        shown, current = f"{STALE}{shown}", ago(snapshot.age_s(motor.value))
    style = "" if fresh else MUTED
    parts: list[Part] = [
        (f"{motor.name[:8]:<8}", MUTED),
        (f"{sent:>9} ", STRONG if fresh else MUTED),
    ]
    return line(*parts, (f"{shown:>12} {current:>8} ", style))


def _plot(values: Sequence[float], full: float, columns: int, rows: int, style: str) -> list[Text]:
    """Return a curve between minus and plus a full value, the newest at the right, with gaps."""
    canvas = Canvas(columns, rows)
    step, middle = canvas.width / TREND_LENGTH, (canvas.height - 1) / 2
    before: tuple[float, float] | None = None
    for age, value in enumerate(reversed(values)):
        if isnan(value):
            before = None
            continue
        share = max(-1.0, min(1.0, value / full))
        here = canvas.width - 1 - age * step, middle * (1 - share)
        canvas.line(*(before or here), *here, style)
        before = here
    return canvas.rows()
