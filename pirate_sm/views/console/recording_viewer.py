"""The console's viewer of a recording: it shows everything and controls nothing."""

from __future__ import annotations

from collections.abc import Sequence, Set
from signal import SIGHUP
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.events import Resize
from textual.widgets import Footer

from pirate_sm.core.palette import USUAL, Theme
from pirate_sm.running.runtime.ending import BY_SIGNAL, StopRequests
from pirate_sm.views.console.dialogs import HelpDialog
from pirate_sm.views.console.help_page import recording_lines
from pirate_sm.views.console.key_bindings import LEAVE, both_cases
from pirate_sm.views.console.recorded_snapshots import RecordedSnapshots
from pirate_sm.views.console.widgets import Lines, PipePicture, RobotApp, panel
from pirate_sm.views.showing import panels
from pirate_sm.views.showing.text_styles import ACCENT, FLAG, STRONG, Part, line

FRAMES_PER_S = 20

_RECORDING = "● RECORDING", f"{FLAG}.{ACCENT}"


class RecordingViewer(RobotApp):
    """Scrubs through a recording.

    Args:
        reel: The snapshots of the recording.
        name: Name of the recording.
        requests: Requests to leave.
        theme: Name of its theme.

    Attributes:
        time_s: The time that is shown.
        playing: Whether time goes on.
    """

    TITLE = "recording"
    pages: ClassVar[Sequence[str]] = ("drive", "body", "log", "motors")
    shown: ClassVar[Set[str]] = {*RobotApp.shown, "slider"}
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(both_cases("r"), "play(True)", "Play", key_display="r"),
        Binding(f"{both_cases('p')},space", "play(False)", "Pause", key_display="p"),
        Binding("left", "by(-1)", "1 s back"),
        Binding("right", "by(1)", "1 s on"),
        Binding("shift+left", "by(-0.1)", "0.1 s back", show=False),
        Binding("shift+right", "by(0.1)", "0.1 s on", show=False),
        Binding("down,pagedown", "by(10)", "10 s on", show=False),
        Binding("up,pageup", "by(-10)", "10 s back", show=False),
        Binding("home", "to(0)", "Start", show=False),
        Binding("end", "to(1)", "End", show=False),
        Binding("less_than_sign", "phase(-1)", "Phase before", key_display="<"),
        Binding("greater_than_sign", "phase(1)", "Next phase", key_display=">"),
        Binding("tab", "page", "Page", show=False, priority=True),
        Binding("question_mark", "help", "Help", key_display="?"),
        Binding(both_cases(LEAVE), "quit", "Quit", key_display=LEAVE),
        Binding("ctrl+q", "quit", "Quit", show=False),
        Binding("ctrl+t", "other_theme", "Next theme", show=False),
    ]

    def __init__(
        self,
        reel: RecordedSnapshots,
        name: str,
        *,
        requests: StopRequests | None = None,
        theme: Theme = USUAL,
        **options: object,
    ) -> None:
        super().__init__(theme, **options)
        self.reel = reel
        self.time_s = 0.0
        self.playing = False
        self._recording = name
        self._requests = requests or StopRequests()

    def compose(self) -> ComposeResult:
        """Lay out the console's panels, without those that control the robot."""
        yield Lines(id="header")
        yield Lines(id="alarm")
        with Horizontal(id="main"):
            with Vertical(id="left"):
                yield panel("now", "Now")
                yield panel("states", "States")
                yield panel("phases", "Phases")
            with Vertical(id="rest"):
                with Horizontal(id="top"):
                    yield PipePicture(id="picture")
                yield panel("body")
        yield from self.below()
        yield Lines(id="slider")
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        """Show the first snapshot."""
        self.set_interval(1 / FRAMES_PER_S, self._tick)
        self.call_after_refresh(self.show)

    def on_resize(self, event: Resize) -> None:
        """Show everything in the new size."""
        self.call_after_refresh(self.show)

    def show(self) -> None:
        """Show the snapshot at ``time_s``."""
        if not self.is_whole():
            return
        snapshot = self.reel.at(self.time_s)
        self.on_base(PipePicture, "picture").show(snapshot)
        header = panels.header(snapshot, self.size.width, flag=_RECORDING)
        now = self.on_base(Lines, "now")
        now.show(panels.now(snapshot, now.content_size.width))
        self.show_robot(snapshot, header, (), keys=False)
        self.on_base(Lines, "slider").show([line(*self._slider())])

    def _slider(self) -> list[Part]:
        """Return the slider with the position in the recording."""
        mark = "▶" if self.playing else "‖"
        whole = self.reel.length_s
        said = f" {mark} {self.time_s:8.2f} s of {whole:.2f} s  "
        room = max(self.size.width - len(said) - len(self._recording) - 4, 10)
        at = round(room * (self.time_s / whole if whole else 0.0))
        return [(said, STRONG), "━" * at, ("●", STRONG), "─" * (room - at), f"  {self._recording}"]

    def leave_now(self) -> None:
        """Leave, because the terminal has gone; may be called from any thread."""
        self._requests.ask(BY_SIGNAL[SIGHUP])

    def _tick(self) -> None:
        if self._requests.stop is not None:
            self.exit()
        if not self.playing:
            return
        self._move(self.time_s + 1 / FRAMES_PER_S)
        if self.time_s >= self.reel.length_s:
            self.playing = False
            self.show()

    def _move(self, time_s: float) -> None:
        self.time_s = min(max(time_s, 0.0), self.reel.length_s)
        self.show()

    # --- what a person wants -------------------------------------------------------------------

    def action_play(self, on: bool) -> None:
        """Play, from the start if at the end; or pause."""
        self.playing = on
        if on and self.time_s >= self.reel.length_s:
            self.time_s = 0.0
        self.show()

    def action_by(self, seconds: float) -> None:
        """Move by this many seconds; backward if negative."""
        self._move(self.time_s + seconds)

    def action_to(self, share: float) -> None:
        """Move to this share of the recording."""
        self._move(share * self.reel.length_s)

    def action_phase(self, by: int) -> None:
        """Move to the beginning of the previous or next phase."""
        starts = self.reel.phases_s
        if by > 0:
            later = [each for each in starts if each > self.time_s + 1e-6]
            self._move(later[0] if later else self.reel.length_s)
        else:
            earlier = [each for each in starts if each < self.time_s - 1e-6]
            self._move(earlier[-1] if earlier else 0.0)

    def action_help(self) -> None:
        """Show the help page."""
        self.push_screen(HelpDialog(recording_lines))

    def action_page(self, by: int = 1) -> None:
        """Show another page of a small terminal."""
        super().action_page(by)
        self.call_after_refresh(self.show)
