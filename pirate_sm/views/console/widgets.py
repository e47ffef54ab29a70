"""The kinds of widgets of the console, each given its content, its panels, and its themes."""

from __future__ import annotations

import os
from collections.abc import Container, Sequence, Set
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from rich.segment import Segment
from rich.style import Style
from rich.text import Text
from textual.app import App, ComposeResult
from textual.color import Color
from textual.content import Content, Span
from textual.events import Click, Resize
from textual.message import Message
from textual.strip import Strip
from textual.theme import Theme as Textual
from textual.widget import Widget
from textual.widgets import Static

from pirate_sm.core.palette import THEMES, Palette, Theme
from pirate_sm.core.visible import visible
from pirate_sm.views.console.availability import sign_of
from pirate_sm.views.showing import alarms, body_panel, panels, picture
from pirate_sm.views.showing import text_styles as styled
from pirate_sm.views.showing.snapshot import Snapshot
from pirate_sm.views.showing.text_styles import (
    ACCENT,
    BAD,
    FLAG,
    GOOD,
    MUTED,
    STRONG,
    WARN,
    Part,
    line,
)

# --- themes -------------------------------------------------------------------------------------


def wear(app: App[Any], name: Theme) -> None:
    """Give the app all themes, and choose one."""
    for each, palette in THEMES.items():
        app.register_theme(_textual(each, palette, plain=app.no_color))
    app.theme = name


def next_theme(app: App[Any]) -> None:
    """Choose the theme after the current one, and say its name."""
    names = list(THEMES)
    app.theme = names[(names.index(app.theme) + 1) % len(names)]  # type: ignore[arg-type]
    app.clear_notifications()
    app.notify(f"theme {app.theme}", timeout=2)


def no_colour() -> dict[str, bool]:
    """Return the options of an app that is to have no colours, as ``NO_COLOR`` asks [no-color.org].

    Textual by itself would make them grey.
    """
    if os.environ.get("NO_COLOR") == "":  # the same as if it were not set
        del os.environ["NO_COLOR"]
    return {"ansi_color": True} if "NO_COLOR" in os.environ else {}


def _textual(name: str, palette: Palette, *, plain: bool) -> Textual:
    """Return the theme of the library with these colours; ``plain``: they will be left out."""
    return Textual(
        name,
        primary=palette["path"],
        secondary=palette["fault"],
        accent=palette["path"],
        success=palette["good"],
        warning=palette["late"],
        error=palette["bad"],
        foreground=palette["ink"],
        background=palette["ground"],
        surface=palette["paper"],
        panel=palette["box"],
        dark=Color.parse(palette["paper"]).brightness < 0.5,
        variables={
            "soft": palette["soft"],
            "line": palette["line"],
            "on-colour": palette["paper"],
            "text-muted": palette["soft"],
            "text-success": palette["good"],
            "text-warning": palette["late"],
            "text-error": palette["bad"],
            "block-cursor-foreground": palette["ink"],
            "block-cursor-background": palette["path_box"],
            "block-cursor-text-style": "bold underline" if plain else "bold",
            "scrollbar": palette["line"],
            "scrollbar-background": palette["ground"],
            "footer-key-foreground": palette["path"],
            "footer-description-foreground": palette["ink"],
            "footer-background": palette["box"],
        },
    )


_THEMED = {
    MUTED: "$soft",
    STRONG: "bold",
    GOOD: "$text-success",
    WARN: "$text-warning",
    BAD: "$text-error",
    ACCENT: "$accent",
    FLAG: "bold reverse",
}
_THEMED |= {f"{FLAG}.{role}": f"bold reverse {_THEMED[role]}" for role in (GOOD, WARN, BAD, ACCENT)}


def themed(text: Text) -> Content:
    """Return the text as Textual content."""
    spans = [
        Span(each.start, each.end, _THEMED[style])
        for each in text.spans
        if (style := str(each.style))
    ]
    return Content(text.plain, spans)


def content_line(*parts: Part) -> Content:
    """Return one line of these parts."""
    return themed(styled.line(*parts))


# --- widgets ------------------------------------------------------------------------------------


_W = TypeVar("_W", bound=Widget)

_WIDE, _HIGH = 120, 36
"""From this size on everything is visible at once."""

_LARGE, _TALL = 150, 44
"""From this size on there is room to spare."""

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


class RequestRow(Static):
    """A request: its key and name, with a sign if it is not available."""

    class Clicked(Message):
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
        self.post_message(self.Clicked(self.asks))


class PipePicture(Widget):
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

    _back = 0

    def look_back(self, pages: int) -> None:
        """Scroll back by pages; forward if negative."""
        self._back = max(0, self._back + pages * max(self.content_size.height - 1, 1))

    def show_snapshot(self, snapshot: Snapshot) -> None:
        """Show as many lines as there is room for."""
        rows, recent = self.content_size.height, snapshot.story.recent
        self._back = min(self._back, max(len(recent) - 1, 0))
        end = len(recent) - self._back
        behind = f", {self._back} lines back (PgDn)" if self._back else ""
        paged = self.app.screen_stack[0].has_class("-paged")
        self.border_title = f"Log{'' if paged else ' (Tab: motors)'}{behind}"
        self.show(panels.log(recent[:end], self.content_size.width, rows))


def panel(name: str, title: str = "") -> Lines:
    """Return a panel with a title."""
    found = Lines(id=name, title=title)
    found.add_class("panel")
    return found


class RobotApp(App[None]):
    """The panels of a robot and its mission, which the console and the viewer both show.

    Args:
        theme: Name of its theme.
    """

    CSS_PATH = Path(__file__).with_name("console.tcss")
    pages: ClassVar[Sequence[str]]
    """Pages of a small terminal, as the stylesheet names them."""

    shown: ClassVar[Set[str]] = {
        *("header", "alarm", "now", "states", "phases", "picture", "body", "motors", "log")
    }
    """Names of the widgets that show a snapshot."""

    def __init__(self, theme: Theme, **options: object) -> None:
        super().__init__(**no_colour(), **options)  # type: ignore[arg-type]
        wear(self, theme)
        self.page = 0

    def below(self) -> ComposeResult:
        """Yield what is below the picture."""
        yield panel("motors")
        log = EventLog(id="log")
        log.add_class("panel")
        yield log

    def on_mount(self) -> None:
        """Draw the picture again in each theme that is chosen."""
        picture = self.on_base(PipePicture, "picture")
        self.theme_changed_signal.subscribe(self, lambda _: picture.restyle())

    def on_resize(self, event: Resize) -> None:
        """Show everything, or one page if the terminal is too small."""
        self.lay_out(event.size.width, event.size.height)

    def lay_out(self, width: int, height: int) -> None:
        """Fit everything to the size of the terminal and the chosen page."""
        paged, large = width < _WIDE or height < _HIGH, width >= _LARGE and height >= _TALL
        pages = {f"-{name}": number == self.page for number, name in enumerate(self.pages)}
        # All together: each change of a class restyles every widget.
        self.screen_stack[0].update_classes({"-paged": paged, "-large": large, **pages})

    def on_base(self, kind: type[_W], name: str) -> _W:
        """Return a widget of the app itself, also behind a dialog."""
        return self.screen_stack[0].query_one(f"#{name}", kind)

    def is_visible(self, name: str) -> bool:
        """Return whether there is room for a widget on the screen."""
        return bool(self.on_base(Widget, name).size)

    def is_whole(self) -> bool:
        """Return whether the app runs and has every widget that shows a snapshot.

        Widgets are added and removed one by one, so a frame that is due in between must be skipped.
        """
        if not (self.is_running and self.screen_stack):
            return False
        return self.shown <= {each.id for each in self.screen_stack[0].walk_children()}

    def action_page(self, by: int = 1) -> None:
        """Show another page of a small terminal; of a large one, the motors or everything else."""
        if len(self.screen_stack) > 1:
            (self.screen.focus_next if by > 0 else self.screen.focus_previous)()
            return
        last = len(self.pages) - 1
        paged = self.screen_stack[0].has_class("-paged")
        self.page = (self.page + by) % (last + 1) if paged else 0 if self.page == last else last
        self.lay_out(*self.size)

    def action_other_theme(self) -> None:
        """Choose the next theme."""
        next_theme(self)

    def show_bar(self, name: str, lines: Sequence[Text]) -> None:
        """Show a bar if it has lines."""
        bar = self.on_base(Lines, name)
        bar.set_class(bool(lines), "on")
        bar.show(lines)

    def show_robot(
        self, snapshot: Snapshot, header: Text, seen: Container[int], *, keys: bool = True
    ) -> None:
        """Show the snapshot in the panels of the robot and its mission, as far as there is room.

        Args:
            snapshot: The moment.
            header: The first line.
            seen: Numbers of the alarms that the operator has acknowledged.
            keys: Whether there are keys for alarms.
        """
        self.on_base(Lines, "header").show([header])
        self.show_bar("alarm", alarms.bar(snapshot, seen, self.size.width, keys=keys))
        self.on_base(Lines, "alarm").set_class(alarms.shows_success(snapshot, seen), "good")
        named = ("states", "body", "motors", "phases")
        states, body, motors, phases = (self.on_base(Lines, name) for name in named)
        if states.size:
            states.show(panels.states(snapshot, states.content_size.width))
        if body.size:
            body.border_title = body_panel.heading(body.content_size.width)
            body.show(body_panel.body(snapshot, body.content_size.width))
        if motors.size:
            motors.border_title = body_panel.motors_heading(motors.content_size.width)
            motors.show(body_panel.motors(snapshot, *motors.content_size))
        if phases.size:
            width, rows = phases.content_size
            phases.border_title = snapshot.scene.mission or "Phases"
            phases.show(panels.phases(snapshot, width, max(rows, 1)))
        self.on_base(EventLog, "log").show_snapshot(snapshot)
