"""The few kinds of widgets that the console is made of; each is given what it shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich.segment import Segment
from rich.style import Style
from textual.color import Color
from textual.content import Content
from textual.events import Click
from textual.message import Message
from textual.strip import Strip
from textual.widget import Widget
from textual.widgets import Static

from pirate_sm.console import picture
from pirate_sm.console.panels import MUTED, told_line
from pirate_sm.console.snapshot import Snapshot
from pirate_sm.showing.visible import visible

_QUIET = "quiet"

_COLOURS = {
    picture.WALL: _QUIET,
    picture.TOUCH: "warning",
    picture.BODY: _QUIET,
    picture.HELD: "primary",
    picture.WHEEL: "success",
    picture.FREE: "foreground",
    picture.LIGHT: "accent",
    picture.NOTE: _QUIET,
}


class Lines(Static):
    """Some lines of text; drawn again only when they are others than before."""

    def __init__(self, *, id: str, title: str = "") -> None:
        super().__init__(id=id, markup=False)
        self.border_title = title
        self._shown: Content | None = None

    def show(self, lines: Sequence[Content]) -> None:
        """These lines are shown."""
        content = Content("\n").join(lines)
        if self._shown is None or not content.is_same(self._shown):
            self._shown = content
            self.update(content)


class Row(Static):
    """One thing that can be asked for: its key, its name, and why not where it cannot be."""

    class Asked(Message):
        """Somebody has clicked on it."""

        def __init__(self, name: str) -> None:
            super().__init__()
            self.name = name

    def __init__(self, name: str, key: str, wide: int) -> None:
        super().__init__(markup=False, classes="row")
        self.asks = name
        self._key = key
        self._wide = wide
        self._shown: tuple[str, str, bool, bool] | None = None

    def show(
        self, label: str, reason: str, *, under_way: bool = False, said_above: bool = False
    ) -> None:
        """Show the label, greyed with the reason where there is one.

        Args:
            label: What it is called.
            reason: Why it cannot be asked for; empty where it can.
            under_way: Whether it is being done.
            said_above: Whether the reason stands above all rows already.
        """
        if self._shown == (label, reason, under_way, said_above):
            return
        self._shown = label, reason, under_way, said_above
        label = f"{visible(label):<{self._wide}}"
        key = f" {self._key or ' '} "
        if under_way:
            content = Content.assemble((key, MUTED), " ", (label, "bold"), ("▶ under way", ""))
        elif reason:
            why = "" if said_above else visible(marked(reason))
            content = Content.assemble((key, MUTED), " ", (label, MUTED), (why, MUTED))
        else:
            content = Content.assemble((key, "bold reverse $accent"), " ", (label, "bold"))
        self.tooltip = visible(reason) or None
        self.update(content)

    def on_click(self, event: Click) -> None:
        """It is asked for."""
        self.post_message(self.Asked(self.asks))


def marked(reason: str) -> str:
    """Return the engine's reason with a sign for its first word: unneeded, or impossible."""
    kind, colon, rest = reason.partition(": ")
    signs = {"unneeded": "=", "impossible": "✕"}
    return f"{signs[kind]} {rest}" if colon and kind in signs else f"✕ {reason}"


class Picture(Widget):
    """The robot in its pipe."""

    def __init__(self, *, id: str) -> None:
        super().__init__(id=id)
        self.frames = 0
        self._snapshot: Snapshot | None = None
        self._strips: list[Strip] = []
        self._styles: dict[str, Style] = {}

    def show(self, snapshot: Snapshot) -> None:
        """The snapshot is drawn."""
        self._snapshot = snapshot
        self._draw()
        self.frames += 1
        self.refresh()

    def restyle(self) -> None:
        """The colours are those of the theme."""
        colours = self.app.theme_variables
        self._styles = {
            name: Style(color=_colour(colours, variable)) for name, variable in _COLOURS.items()
        }
        self._styles[picture.WHEEL] += Style(bold=True)
        if self._snapshot is not None:
            self._draw()
            self.refresh()

    def on_mount(self) -> None:
        """It is in the colours of the theme."""
        self.restyle()

    def on_resize(self) -> None:
        """It fills its new size."""
        if self._snapshot is not None:
            self._draw()

    def _draw(self) -> None:
        assert self._snapshot is not None
        width, height = self.content_size
        canvas = picture.draw(self._snapshot, width, height)
        self._strips = [
            Strip([Segment(text, self._styles.get(style)) for text, style in pieces], width)
            for pieces in canvas.runs()
        ]

    def render_line(self, y: int) -> Strip:
        """One row of the picture."""
        if y < len(self._strips):
            return self._strips[y].apply_style(self.rich_style)
        return Strip.blank(self.size.width, self.rich_style)


def _colour(variables: Mapping[str, str], name: str) -> str:
    """A colour of the theme; ``quiet`` is halfway between its foreground and background."""
    if name != _QUIET:
        return Color.parse(variables[name]).hex6
    return Color.parse(variables["foreground"]).blend(Color.parse(variables["surface"]), 0.5).hex6


class EventLog(Lines):
    """What has happened, the newest last, or what had happened some lines before."""

    def __init__(self, *, id: str, title: str) -> None:
        super().__init__(id=id, title=title)
        self._title = title
        self._back = 0

    def look_back(self, pages: int) -> None:
        """Earlier lines are shown, or later ones with a negative number."""
        self._back = max(0, self._back + pages * max(self.content_size.height - 1, 1))

    def tell(self, snapshot: Snapshot) -> None:
        """The lines that there is room for."""
        rows, recent = self.content_size.height, snapshot.story.recent
        self._back = min(self._back, max(len(recent) - rows, 0))
        end = len(recent) - self._back
        behind = f", {self._back} lines back (PgDn)" if self._back else ""
        self.border_title = self._title + behind
        self.show([told_line(each) for each in recent[max(end - rows, 0) : end]])
