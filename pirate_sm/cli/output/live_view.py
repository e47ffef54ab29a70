"""The view of a running mission on a terminal; loaded only if there is one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import Self

from rich.console import Console, ConsoleOptions, RenderResult
from rich.live import Live
from rich.text import Text
from rich.theme import Theme

from pirate_sm.cli.output.event_lines import ObservedRun, how_it_runs
from pirate_sm.cli.people import Operator
from pirate_sm.core.effects import Effect
from pirate_sm.robot.detectors.simple_detectors import WordKeys
from pirate_sm.views.showing import alarms, panels, picture
from pirate_sm.views.showing import body_panel as body
from pirate_sm.views.showing import text_styles as styled
from pirate_sm.views.showing.effect_lines import setpoint
from pirate_sm.views.showing.snapshot import Memory, Snapshot, Trends, scene_of, snapshot_of
from pirate_sm.views.showing.text_styles import BAD, FLAG, GOOD, MUTED, STRONG, WARN, fitted, line

_LEFT = 40
"""Width of the text column; a region and the longest usual name of a state fit in."""

_TABLE, _WITH_TABLE = 70, 30
"""From this size on there is room for all readings of each motor."""

_WITH_SENSORS = 20
"""From this height on there is room for angles and other readings."""

_LEAST_PICTURE = 10, 4


class LiveView:
    """Shows a run in place while it is entered; its last frame remains."""

    def __init__(
        self,
        console: Console,
        observed: ObservedRun,
        speed: str,
        operator: Operator | None,
        words: WordKeys | None = None,
    ) -> None:
        console.push_theme(Theme({**styled.ON_A_TERMINAL, **picture.ON_A_TERMINAL}))
        self._console = console
        self._observed = observed
        self._speed = speed
        self._operator = operator
        self._word_keys = words
        self._scene = scene_of(observed.prepared)
        self._memory = Memory(observed.robot, nominal=self._scene.engine.nominal)
        self._trends = Trends()
        self._spare = 1
        self._live = Live(
            self,
            console=console,
            auto_refresh=False,
            redirect_stdout=False,
            redirect_stderr=False,
            vertical_overflow="crop",
        )

    def __enter__(self) -> Self:
        """Show the first frame."""
        self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the last frame, with how the run ended below it."""
        with suppress(OSError):  # the terminal may have gone, and the run stopped for it
            conclusion = self._conclusion()
            # Keep room for it and for the shell's prompt, so that nothing scrolls away.
            lines = conclusion.plain.splitlines()
            self._spare += sum(-(-len(each) // self._console.width) for each in lines)
            self._live.stop()
            self._console.print(conclusion, soft_wrap=True)

    def _conclusion(self) -> Text:
        there, ended = self._observed, self._memory.story.ended
        if ended is None:
            return Text()
        text, style = there.summary(ended, there.now_s), panels.OUTCOME.get(ended.outcome, BAD)
        conclusion = line((f"{self._scene.mission}: {text}", style))
        left = there.left()
        return conclusion.append("\n").append(line((left, style))) if left else conclusion

    def begin(self) -> None:
        """Print the notices above the view."""
        for notice in self._observed.prepared.notices:
            self._console.print(line((notice, WARN)), soft_wrap=True)

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """Note the effects for the next frame."""
        self._memory.see(effects, now_s)
        self._observed.note(effects)
        if self._memory.story.ended is not None and self._live.is_started:
            self._live.refresh()  # it may be the last one for a while

    def pulse(self, now_s: float) -> None:
        """Draw a new frame."""
        if (state := self._observed.state) is not None:
            self._trends.look(self._scene, state, now_s)
        self._live.refresh()

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Yield the lines of a frame lower than the terminal, so that nothing scrolls."""
        width, height = console.size
        for shown in self.frame(width, height - self._spare):
            shown.no_wrap, shown.end = True, "\n"
            yield shown

    def frame(self, width: int, height: int) -> list[Text]:
        """Return the lines of a frame of this size."""
        snapshot = self._snapshot()
        how = how_it_runs(self._observed.prepared.order)
        lines = [panels.header(snapshot, width, how=how, pace=self._speed)]
        lines += self._bars(snapshot, width)
        beside = width - _LEFT - 1
        table = beside >= _TABLE and height >= _WITH_TABLE and not self._scene.engine.nominal
        brief = not table and height >= _WITH_SENSORS and not self._scene.engine.nominal
        below = _brief(snapshot, width) if brief else []
        log_rows = max(2, (height - len(below) - 18) // 3)
        rows = max(height - len(lines) - len(below) - 1 - log_rows, 0)
        motors = _motors(snapshot, beside) if table else []
        right = [*self._picture(snapshot, beside, rows - len(motors)), *motors]
        lines += _beside(_words(snapshot, rows), right, rows)
        recent = [panels.numbered_line(each) for each in snapshot.story.recent[-log_rows:]]
        lines = [*lines, *below, _title("events", width), *_filled(recent, log_rows)]
        return _cut(lines[:height], width)

    def _snapshot(self) -> Snapshot:
        there, story = self._observed, self._memory.story
        return snapshot_of(
            self._scene,
            there.prepared,
            there.state,
            there.now_s,
            story,
            self._trends,
            over=story.ended is not None,
        )

    def _bars(self, snapshot: Snapshot, width: int) -> list[Text]:
        """Return lines about problems of the link and about the keys."""
        trouble = alarms.trouble(snapshot, width)
        bars = [line((fitted(each, width).plain, f"{FLAG}.{BAD}")) for each in trouble]
        if self._word_keys and not snapshot.over:
            bars.append(line((self._word_keys.offered, WARN)))
        return bars + (panels.question(snapshot, width) if self._operator else [])

    def _picture(self, snapshot: Snapshot, columns: int, rows: int) -> list[Text]:
        if columns < _LEAST_PICTURE[0] or rows < _LEAST_PICTURE[1]:
            return _filled([], rows)
        if not snapshot.scene.engine.nominal:
            return picture.draw(snapshot, columns, rows).rows()
        heading = _title("setpoints that would be sent", columns)
        return [heading, *_setpoints(snapshot, self._memory.story.changed, rows - 1)]


def _words(snapshot: Snapshot, rows: int) -> list[Text]:
    """Return phases, waits and states; the phases get the room that the others leave."""
    states = panels.states(snapshot, _LEFT)
    most = max(3, min(6, rows - len(states) - 6))
    now = _filled(panels.now(snapshot, _LEFT)[:most], most)
    room = max(rows - len(states) - len(now) - 3, 1)
    return [
        _title("phases", _LEFT),
        *_filled(panels.phases(snapshot, _LEFT, room), room),
        _title("now", _LEFT),
        *now,
        _title("states", _LEFT),
        *states,
    ]


def _motors(snapshot: Snapshot, width: int) -> list[Text]:
    return [_title(body.heading(width), width, lead=""), *body.body(snapshot, width)]


def _brief(snapshot: Snapshot, width: int) -> list[Text]:
    return [_title("sensors", width), *body.briefly(snapshot, width)]


def _setpoints(snapshot: Snapshot, changed: frozenset[int], rows: int) -> list[Text]:
    """Return every slot with its setpoint, with those of the last change emphasized."""
    slots = snapshot.scene.robot.slots
    values = snapshot.story.setpoints or (0.0,) * len(slots)
    wide = max(len(slot.name) for slot in slots)
    down = min(rows, len(slots)) or 1
    lines = [line() for _ in range(down)]
    for index, (slot, value) in enumerate(zip(slots, values, strict=True)):
        style = STRONG if index in changed else (GOOD if value else MUTED)
        lines[index % down].append_text(
            line((f"{slot.name:<{wide}} {setpoint(slot, value):>7}  ", style))
        )
    return lines


def _title(text: str, width: int, lead: str = "─ ") -> Text:
    """Return a heading that fills the line."""
    return line((lead, MUTED), (text, STRONG), (f" {'─' * (width - len(lead + text) - 1)}", MUTED))


def _filled(lines: list[Text], rows: int) -> list[Text]:
    return lines + [Text()] * (rows - len(lines))


def _beside(left: list[Text], right: list[Text], rows: int) -> Iterable[Text]:
    """Yield the lines of two columns side by side."""
    for number in range(rows):
        whole = fitted(left[number] if number < len(left) else Text(), _LEFT).append(" ")
        yield whole.append_text(right[number]) if number < len(right) else whole


def _cut(lines: list[Text], width: int) -> list[Text]:
    """Cut the lines off at this width; return them."""
    for each in lines:
        each.rstrip()
        each.truncate(width, overflow="ellipsis")
    return lines
