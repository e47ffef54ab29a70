"""What each motor was sent, next to what is measured of it, with the last minute of both."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan, nan, tau

from rich.text import Text

from pirate_sm.views.drawing.canvas import ACROSS, Canvas
from pirate_sm.views.showing.body_panel import measured
from pirate_sm.views.showing.effect_lines import setpoint
from pirate_sm.views.showing.live_snapshots import TREND_EVERY_S, TREND_LENGTH, sent_name
from pirate_sm.views.showing.robot_anatomy import MotorReadings
from pirate_sm.views.showing.snapshot import Snapshot
from pirate_sm.views.showing.text_styles import ACCENT, MUTED, STALE, STRONG, Part, ago, line

_TEXT = 40
"""Columns of the name and the three numbers; plots have the rest."""

_MOST_ROWS = 3


def heading(width: int) -> str:
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
    return [each for motor in everything for each in _motor(snapshot, motor, width, rows)]


def _motor(snapshot: Snapshot, motor: MotorReadings, width: int, rows: int) -> list[Text]:
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
