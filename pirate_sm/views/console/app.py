"""The console: shows the snapshots of a session and lays out its panels."""

from __future__ import annotations

from collections.abc import Iterable, Sequence, Set
from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult, SystemCommand
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, ItemGrid, Vertical
from textual.content import Content
from textual.events import Event, Key
from textual.screen import Screen
from textual.widgets import Footer

from pirate_sm.core.palette import USUAL, Theme
from pirate_sm.robot.control_panel.panel_reader import PressSource
from pirate_sm.running.runtime.ending import Stop
from pirate_sm.views.console import availability, hand_back
from pirate_sm.views.console.availability import (
    CONTROLS,
    LEAVE,
    MISSIONS,
    Request,
    arrows_for,
    both_cases,
    letters_for,
    obstacles,
    ways,
)
from pirate_sm.views.console.check_process import CheckCall, ask_here
from pirate_sm.views.console.checklist import Checklist
from pirate_sm.views.console.dialogs import Dialog, Help, ObservationDialog, help_lines
from pirate_sm.views.console.driving import is_still
from pirate_sm.views.console.operator_actions import PanelActions
from pirate_sm.views.console.session import OperatorSession
from pirate_sm.views.console.stepping import BreakpointList
from pirate_sm.views.console.terminal_driver import STOP_KEY
from pirate_sm.views.console.widgets import (
    EventLog,
    Lines,
    PipePicture,
    RequestRow,
    RobotApp,
    panel,
)
from pirate_sm.views.showing import panels
from pirate_sm.views.showing.body_panel import travelled
from pirate_sm.views.showing.snapshot import Snapshot
from pirate_sm.views.showing.text_styles import FLAG, MUTED, Part, line

FRAMES_PER_S = 25
_WORDS_EVERY = 3
"""Text is updated with every third frame, which is as fast as people can read."""

_SHORT = {"go": "Run", "pause": "Pause", "hand_back": "Hand"}
"""Labels of the controls in the last line, which has no room for all of them at 80 columns."""

CRASHED = Stop("a fault in the console", 4)


class Console(PanelActions, RobotApp):
    """The operator's console.

    Args:
        session: Runs the missions. It is started when the console is shown.
        pressed: Where buttons are pressed: a control panel, opened, and the page of its runs.
        ask_check: Asks the check about missions, in a process of its own where a stop must not
            wait for the answer.
        frames_per_s: How often it shows the newest snapshot by itself; 0 is never.
        theme: Name of its theme.

    Attributes:
        failure: The exception that ended the console; None without one.
    """

    TITLE = "pirate console"
    pages: ClassVar[Sequence[str]] = ("drive", "mission", "body", "log", "motors")
    shown: ClassVar[Set[str]] = RobotApp.shown | {
        *("pages", "commands", "controls", "why", "link", "question")
    }
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(STOP_KEY, "stop", "STOP", priority=True),
        *(
            Binding(
                both_cases(letter),
                f"control('{name}')",
                _SHORT.get(name, name.title()),
                show=name in _SHORT,
                key_display=letter,
            )
            for name, letter in CONTROLS.items()
        ),
        Binding(both_cases(MISSIONS), "missions", "Missions", key_display=MISSIONS),
        Binding("number_sign", "preflight", "Pre-flight", key_display="#"),
        Binding("exclamation_mark", "alarms", "Alarms", key_display="!"),
        Binding("asterisk", "breakpoints", "Breakpoints", show=False),
        Binding("question_mark", "help", "Help", key_display="?"),
        Binding(both_cases(LEAVE), "leave", "Quit", key_display=LEAVE),
        Binding("ctrl+q", "leave", "Quit", show=False),
        Binding("ctrl+c", "leave", "Quit", show=False, priority=True),
        Binding("tab", "page(1)", "Page", show=False, priority=True),
        Binding("shift+tab", "page(-1)", "Page before", show=False, priority=True),
        Binding("pageup", "look_back(1)", "Earlier lines", show=False),
        Binding("pagedown", "look_back(-1)", "Later lines", show=False),
        Binding("escape", "seen", "Seen", show=False),
        Binding("at", "say", "Say a place", show=False),
        Binding("plus", "faster(1)", "Faster", show=False),
        Binding("minus", "faster(-1)", "Slower", show=False),
        Binding("equals_sign", "limit", "Where a drive stops", show=False),
        Binding("ctrl+t", "other_theme", "Next theme", show=False),
        *(Binding(str(digit), f"answer({digit})", "Answer", show=False) for digit in range(1, 10)),
    ]

    def __init__(
        self,
        session: OperatorSession,
        *pressed: PressSource,
        ask_check: CheckCall = ask_here,
        frames_per_s: float = FRAMES_PER_S,
        theme: Theme = USUAL,
        **options: object,
    ) -> None:
        super().__init__(theme, **options)
        self.session = session
        self.pressed = pressed
        self.seen: set[int] = set()
        self.ask_check = ask_check
        self._frames_per_s = frames_per_s
        self.failure: Exception | None = None
        self.faults = []
        self._frame = 0
        scene = session.latest.scene
        names = list(scene.loaded.loaded_robot.profile.commands)
        self.letters = letters_for([*names, *scene.robot.detector_words])
        self._rows = {name: RequestRow(name, self.letters.get(name, "")) for name in names}
        self._controls = {
            each.name: RequestRow(each.name, each.key)
            for each in availability.controls(session.latest, None)
        }

    # --- missions -------------------------------------------------------------------------

    def compose(self) -> ComposeResult:
        """Yield every panel once; the stylesheet shows and hides them by size."""
        yield Lines(id="header")
        yield Lines(id="alarm")
        yield Lines(id="pages")
        with Horizontal(id="main"):
            with Vertical(id="left"):
                with ItemGrid(id="commands", classes="panel") as commands:
                    commands.border_title = "Commands"
                    yield from self._rows.values()
                with ItemGrid(id="controls", classes="panel") as controls:
                    controls.border_title = "Mission control"
                    yield from self._controls.values()
                yield panel("now", "Now")
                yield panel("why", "Not now (?: in full)")
                yield panel("link", "Link (#: checks)")
            with Vertical(id="rest"):
                with Horizontal(id="top"):
                    yield PipePicture(id="picture")
                    with Vertical(id="right"):
                        yield panel("states", "States")
                        yield panel("phases", "Phases")
                yield panel("body")
        yield from self.below()
        yield Lines(id="question")
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        """Start the session and show it."""
        for name, letter in self.letters.items():
            known = name in self._rows
            action = f"command('{name}')" if known else f"word('{name}')"
            self.bind(both_cases(letter), action, show=False)
        for arrow, name in arrows_for(self.session.latest.scene.robot).items():
            drives = name in ways(self.session.latest.scene.robot)
            self.bind(arrow, f"{'drive' if drives else 'command'}('{name}')", show=False)
        self.session.start()
        if self._frames_per_s:
            self.set_interval(1 / self._frames_per_s, self.show)

    async def on_event(self, event: Event) -> None:
        """Ignore a key that was pressed before the dialog that it would answer could be read."""
        meant_for_it = isinstance(event, Key) and event.key != STOP_KEY
        if isinstance(event, Key):
            self.pressed_s = event.time
        if not (meant_for_it and self.is_unread(event.time)):
            await super().on_event(event)

    # --- what it shows ------------------------------------------------------------------------

    def show(self) -> None:
        """Show the newest snapshot."""
        snapshot = self.session.latest
        if not self.is_whole():
            return
        self._frame += 1
        if self.is_visible("picture"):
            self.on_base(PipePicture, "picture").show(snapshot)
        if self._frame % _WORDS_EVERY == 1 or snapshot.over:
            self.show_words(snapshot)
        self.heed_panel()
        self.keep_up(snapshot)
        if isinstance(self.screen, Dialog) and self.is_outdated(self.screen):
            self.screen.dismiss(None)
        if isinstance(self.screen, Checklist) and snapshot.over:
            self.screen.dismiss(None)
        if isinstance(self.screen, ObservationDialog) and not is_still(snapshot):
            self.screen.dismiss(None)
        if snapshot.over and self.session.quitting.stop is not None:
            self.exit()

    def show_words(self, snapshot: Snapshot) -> None:
        """Show everything but the picture, and what is open to be read."""
        self.show_robot(snapshot, panels.header(snapshot, self.size.width), self.seen)
        series = hand_back.bar(self.session.giver.series)
        self.show_bar("question", series or panels.question(snapshot, self.size.width))
        self.on_base(Lines, "pages").show([_tabs(self.page)])
        self._show_rows(snapshot)
        if self.is_visible("now"):
            now = self.on_base(Lines, "now")
            state = None if snapshot.over else snapshot.state
            by_hand = state is not None and state.mission.paused
            more = self.session.driving.lines() if by_hand else []
            more += [] if self.is_visible("body") else travelled(snapshot)
            now.show([*panels.now(snapshot, now.content_size.width), *more])
        link = self.on_base(Lines, "link")
        link.set_class(snapshot.link is not None, "on")
        link.show(panels.link(snapshot))
        if isinstance(self.screen, Help | BreakpointList):
            self.screen.renew()

    def _show_rows(self, snapshot: Snapshot) -> None:
        """Show the requests that are possible, and the reasons for the others, each reason once."""
        motion = snapshot.state.robot.motion if snapshot.state is not None else None
        doing = snapshot.scene.robot.commands[motion.command].name if motion else ""
        commands, controls = [], []
        for name, row in self._rows.items():
            reason = availability.command_reason(snapshot, name)
            doubt = availability.drive_doubt(snapshot, name)
            row.show(name, reason, under_way=name == doing and snapshot.live, doubt=doubt)
            if name != doing:
                commands.append(Request(row.key, reason))
        for control in availability.controls(snapshot, self.starts(snapshot)):
            self._controls[control.name].show(control.label, control.reason)
            controls.append(Request(control.key, control.reason))
        asked = {"commands": commands, "mission control": controls}
        shown = {name: each for name, each in asked.items() if self.is_visible(_PANELS[name])}
        why = self.on_base(Lines, "why")
        why.show(obstacles(shown, snapshot.scene.robot, *why.content_size) if shown else [])

    # --- what does not move the robot ---------------------------------------------------------

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool:
        """Return whether an action is possible: no stop by a key that types a space."""
        return not (action == "stop" and self.typing)

    def action_look_back(self, pages: int) -> None:
        """Show earlier or later lines of the log."""
        self.on_base(EventLog, "log").look_back(pages)

    def action_help(self) -> None:
        """Show the help page."""
        self.push_screen(Help(self._help_lines))

    def _help_lines(self) -> list[Content]:
        latest = self.session.latest
        return help_lines(self.letters, latest, self.starts(latest))

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """Return the commands of the palette: everything that the keys do."""
        yield from self.palette()
        yield SystemCommand("Help", "Every key and sign", self.action_help)
        yield SystemCommand("Next theme", "Light, dark, high contrast", self.action_other_theme)
        yield SystemCommand("Quit", "Safe state, then leave", self.action_leave)

    # --- when something breaks ----------------------------------------------------------------

    def _handle_exception(self, error: Exception) -> None:
        """Bring the robot to its safe state before the error is shown."""
        self.session.quit(CRASHED)
        self.failure = self.failure or error
        super()._handle_exception(error)

    def _fatal_error(self) -> None:
        """Close the console; the caller reports the error in one sentence."""
        self._close_messages_no_wait()


_PANELS = {"commands": "commands", "mission control": "controls"}


def _tabs(page: int) -> Text:
    parts: list[Part] = [" "]
    for number, title in enumerate(map(str.title, Console.pages)):
        here = number == page
        parts.append((f"[{title}]" if here else f" {title} ", FLAG if here else ""))
    return line(*parts, ("  Tab: next page", MUTED))
