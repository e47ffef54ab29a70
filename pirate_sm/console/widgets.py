"""The kinds of widgets of the console; each is given its content."""

from __future__ import annotations

from collections.abc import Sequence, Set

from rich.segment import Segment
from rich.style import Style
from rich.text import Text
from textual.app import App
from textual.color import Color
from textual.events import Click
from textual.message import Message
from textual.strip import Strip
from textual.widget import Widget
from textual.widgets import Static

from pirate_sm.console.reason_lines import sign_of
from pirate_sm.console.themed_lines import themed
from pirate_sm.showing import body_panel, motor_page, panels, picture
from pirate_sm.showing.snapshot import Snapshot
from pirate_sm.showing.text_styles import ACCENT, BAD, FLAG, GOOD, MUTED, STRONG, line
from pirate_sm.visible import visible

_COLOURS = {
    picture.WALL: "soft",
    picture.TOUCH: "warning",
    picture.BODY: "soft",
    picture.HELD: "primary",
    picture.WHEEL: "success",
    picture.FREE: "foreground",
    picture.LIGHT: "warning",
    picture.NOTE: "soft",
}


class Lines(Static):
    """Some lines of text, redrawn only when they change."""

    def __init__(self, *, id: str, title: str = "") -> None:
        super().__init__(id=id, markup=False)
        self.border_title = title
        self._shown: Text | None = None

    def show(self, lines: Sequence[Text]) -> None:
        """Show these lines."""
        text = Text("\n").join(lines)
        if text != self._shown:
            self._shown = text
            self.update(themed(text))


class Row(Static):
    """A request: its key and name, with a sign if it is not available."""

    class Asked(Message):
        """The row was clicked."""

        def __init__(self, name: str) -> None:
            super().__init__()
            self.name = name

    def __init__(self, name: str, key: str) -> None:
        super().__init__(markup=False, classes="row")
        self.asks = name
        self.key = key
        self._shown: tuple[str, str, bool, str] | None = None

    def show(self, label: str, reason: str, *, under_way: bool = False, doubt: str = "") -> None:
        """Show the label: grey if there is a reason, under way, or asked about for a doubt."""
        if self._shown == (label, reason, under_way, doubt):
            return
        self._shown = label, reason, under_way, doubt
        if under_way:
            shown = line((f"▶{self.key:1} ", GOOD), (f" {label}", STRONG))
        elif reason:
            shown = line((f"{sign_of(reason)}{self.key:1}  {label}", MUTED))
        else:
            sign, style = ("!", BAD) if doubt else (" ", ACCENT)
            shown = line((f"{sign}{self.key:1} ", f"{FLAG}.{style}"), (f" {label}", STRONG))
        self.tooltip = visible(reason or doubt) or None
        self.update(themed(shown))

    def on_click(self, event: Click) -> None:
        """Post the request of the row."""
        self.post_message(self.Asked(self.asks))


class Picture(Widget):
    """The robot in its pipe."""

    def __init__(self, *, id: str) -> None:
        super().__init__(id=id)
        self.frames = 0
        self._snapshot: Snapshot | None = None
        self._strips: list[Strip] = []
        self._styles: dict[str, Style] = {}

    def show(self, snapshot: Snapshot) -> None:
        """Draw the snapshot."""
        self._snapshot = snapshot
        self._draw()
        self.frames += 1
        self.refresh()

    def restyle(self) -> None:
        """Take the colours of the theme."""
        colours = self.app.theme_variables
        self._styles = {
            name: Style(color=Color.parse(colours[variable]).hex6)
            for name, variable in _COLOURS.items()
        }
        self._styles[picture.WHEEL] += Style(bold=True)
        if self._snapshot is not None:
            self._draw()
            self.refresh()

    def on_mount(self) -> None:
        """Take the colours of the theme."""
        self.restyle()

    def on_resize(self) -> None:
        """Draw again in the new size."""
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
        """Return one row of the picture."""
        if y < len(self._strips):
            return self._strips[y].apply_style(self.rich_style)
        return Strip.blank(self.size.width, self.rich_style)


class EventLog(Lines):
    """The log, the newest line last, or scrolled back."""

    def __init__(self, *, id: str, title: str) -> None:
        super().__init__(id=id, title=title)
        self._title = title
        self._back = 0

    def look_back(self, pages: int) -> None:
        """Scroll back by pages; forward if negative."""
        self._back = max(0, self._back + pages * max(self.content_size.height - 1, 1))

    def show_snapshot(self, snapshot: Snapshot) -> None:
        """Show as many lines as there is room for."""
        rows, recent = self.content_size.height, snapshot.story.recent
        self._back = min(self._back, max(len(recent) - 1, 0))
        end = len(recent) - self._back
        behind = f", {self._back} lines back (PgDn)" if self._back else ""
        self.border_title = self._title + behind
        self.show(panels.log(recent[:end], self.content_size.width, rows))


def panel(name: str, title: str = "") -> Lines:
    """Return a panel with a title."""
    found = Lines(id=name, title=title)
    found.add_class("panel")
    return found


def is_whole(app: App[None], names: Set[str]) -> bool:
    """Return whether the console runs and has a widget of each of these names.

    Widgets are added and removed one by one, so a frame that is due in between must be skipped.
    """
    if not (app.is_running and app.screen_stack):
        return False
    return names <= {each.id for each in app.screen_stack[0].walk_children()}


def turned(page: int, by: int, names: Sequence[object], *, paged: bool) -> int:
    """Return the next page; where everything else is visible at once that is the last or first."""
    if paged:
        return (page + by) % len(names)
    return 0 if page == len(names) - 1 else len(names) - 1


def show_robot(app: App[None], snapshot: Snapshot) -> None:
    """Show the snapshot in the panels of the robot and its mission, as far as there is room."""
    base = app.screen_stack[0]
    states, body, phases = (
        base.query_one(f"#{name}", Lines) for name in ("states", "body", "phases")
    )
    if states.size:
        states.show(panels.states(snapshot, states.content_size.width))
    if body.size:
        body.border_title = body_panel.heading(body.content_size.width)
        body.show(body_panel.body(snapshot, body.content_size.width))
    motors = base.query_one("#motors", Lines)
    if motors.size:
        motors.border_title = motor_page.heading(motors.content_size.width)
        motors.show(motor_page.motors(snapshot, *motors.content_size))
    if phases.size:
        width, rows = phases.content_size
        phases.border_title = snapshot.scene.mission or "Phases"
        phases.show(panels.phases(snapshot, width, max(rows, 1)))
