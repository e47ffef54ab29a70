"""The view as a whole: an observer that remembers and a watcher that redraws."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import Self

from rich.console import Console, ConsoleOptions, RenderResult
from rich.live import Live
from rich.text import Text

from pirate_sm.cli.asking import Operator
from pirate_sm.cli.live import panels
from pirate_sm.cli.live.drawing import draw
from pirate_sm.cli.live.gauges import gauges
from pirate_sm.cli.situation import Situation
from pirate_sm.detectors.keys import WordKeys
from pirate_sm.model.effects import Effect
from pirate_sm.showing.memory import Memory
from pirate_sm.showing.telling import summary
from pirate_sm.showing.visible import visible

_LEFT = 42
"""Width of the column of words; a region and the longest usual name of a state fit in."""


class View:
    """Shows a run in place while it is entered; its last frame stays."""

    def __init__(
        self,
        console: Console,
        situation: Situation,
        speed: str,
        operator: Operator | None,
        words: WordKeys | None = None,
    ) -> None:
        self._console = console
        self._situation = situation
        self._speed = speed
        self._operator = operator
        self._word_keys = words
        self._memory = Memory(situation.robot, nominal=situation.prepared.engine.nominal)
        self._gauges = gauges(situation.prepared.loaded.loaded_robot.profile)
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
        """The first frame stands."""
        self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        """The last frame stands, and below it how the run ended."""
        with suppress(OSError):  # the terminal may have gone, and the run stopped for it
            conclusion = self._conclusion()
            # Room for it and for the shell's prompt, so that nothing scrolls away.
            self._spare += -(-len(conclusion.plain) // self._console.width)
            self._live.stop()
            self._console.print(conclusion)

    def _conclusion(self) -> Text:
        there, ended = self._situation, self._memory.ended
        if ended is None:
            return Text()
        text = summary(ended, there.now_s, there.distance_m(), there.odometry_m())
        mission = there.prepared.loaded.mission.mission
        return Text(f"{mission}: {visible(text)}", panels.OUTCOME[ended.outcome])

    def begin(self) -> None:
        """What a person must know stands above the view."""
        for notice in self._situation.prepared.notices:
            self._console.print(Text(visible(notice), "yellow"))

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """It has taken note; the next frame shows it."""
        self._memory.see(effects, now_s)

    def pulse(self, now_s: float) -> None:
        """There is a new frame."""
        self._live.refresh()

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """The frame, a little less high than the terminal, so that nothing scrolls."""
        width, height = console.size
        for found in self.frame(width, height - self._spare):
            line = _shown(found)
            line.truncate(width, overflow="ellipsis")
            line.no_wrap, line.end = True, "\n"
            yield line

    def frame(self, width: int, height: int) -> list[Text]:
        """Lines of a frame of this size."""
        there, memory = self._situation, self._memory
        lines = [panels.header(there, memory, self._speed, width)]
        below = self._gauge_lines(width)
        told = max(2, (height - len(below) - 18) // 3)
        rows = max(height - 1 - len(below) - 1 - told, 0)
        lines += _beside(self._words(rows), self._picture(width - _LEFT - 1, rows), rows)
        lines += below
        lines.append(panels.title("events", width))
        recent = panels.events(memory, told)
        for line in recent:
            line.truncate(width, overflow="ellipsis")
        lines += recent + [Text()] * (told - len(recent))
        return lines[:height]

    def _gauge_lines(self, width: int) -> list[Text]:
        if self._situation.prepared.engine.nominal:
            return []
        found = panels.sensors(self._situation, self._gauges, width)
        return [panels.title("sensors", width), *found]

    def _words(self, rows: int) -> list[Text]:
        """Phases, what is waited for, states; the phases get what room the others leave."""
        there, memory = self._situation, self._memory
        states = [*panels.states(there.robot, memory), panels.words(there)]
        most = max(3, min(6, rows - len(states) - 6))
        waiting = panels.waiting(there, memory, self._operator, self._word_keys, _LEFT)[:most]
        if memory.ended is None:
            waiting = _filled(waiting, most)
        room = max(rows - len(states) - len(waiting) - 3, 1)
        return [
            panels.title("phases", _LEFT),
            *_filled(panels.phases(there, memory, room), room),
            panels.title("waiting for", _LEFT),
            *waiting,
            panels.title("states", _LEFT),
            *states,
        ]

    def _picture(self, columns: int, rows: int) -> list[Text]:
        truth = self._situation.truth()
        if columns < 10 or rows < 4:
            return []
        if truth is not None:
            return draw(truth, columns, rows)
        ideal = self._situation.prepared.engine.nominal
        heading = panels.title("setpoints that would be sent" if ideal else "setpoints", columns)
        return [heading, *panels.setpoints(self._situation.robot, self._memory, rows - 1)]


def _shown(line: Text) -> Text:
    """The line, without its colours where control characters had to be written out."""
    plain = visible(line.plain)
    return line if plain == line.plain else Text(plain, line.style)


def _filled(lines: list[Text], rows: int) -> list[Text]:
    return lines + [Text()] * (rows - len(lines))


def _beside(left: list[Text], right: list[Text], rows: int) -> Iterable[Text]:
    """Two columns side by side."""
    for number in range(rows):
        line = left[number].copy() if number < len(left) else Text()
        line.truncate(_LEFT, overflow="ellipsis", pad=True)
        line.append(" ")
        if number < len(right):
            line.append_text(right[number])
        yield line
