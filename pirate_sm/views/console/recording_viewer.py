"""The console's viewer of a recording: it shows everything and controls nothing.

Its snapshots come from replaying the recording.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence, Set
from dataclasses import replace
from functools import lru_cache
from signal import SIGHUP
from typing import ClassVar, NamedTuple

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.events import Resize
from textual.widgets import Footer

from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import RecordingError
from pirate_sm.core.events import InSpace, Truth
from pirate_sm.core.geometry import Place, drawn_walls
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.palette import USUAL, Theme
from pirate_sm.running.recording.format.engine_topics import Placed
from pirate_sm.running.recording.read.pieces import Checkpoint, Gap, with_own_times
from pirate_sm.running.recording.read.places import recorded_places
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import engine_of, rerun
from pirate_sm.running.runtime.ending import BY_SIGNAL, StopRequests
from pirate_sm.views.console.availability import LEAVE, both_cases
from pirate_sm.views.console.dialogs import HelpDialog, recording_lines
from pirate_sm.views.console.widgets import Lines, PipePicture, RobotApp, panel
from pirate_sm.views.showing import panels
from pirate_sm.views.showing.robot_anatomy import anatomy_of
from pirate_sm.views.showing.snapshot import Memory, MissionScene, Snapshot, Trends
from pirate_sm.views.showing.text_styles import ACCENT, FLAG, STRONG, Part, line

# --- snapshots ----------------------------------------------------------------------------------


MOST_FRAMES = 4000
"""The most snapshots between two checkpoints. If checkpoints are far apart, or in old recordings
without them, so are the snapshots."""

FINEST_S = 0.1

_MOST_WINDOWS = 8
"""The most stretches between checkpoints whose snapshots are in memory."""


class RecordedSnapshots:
    """The snapshots of a recording, made on demand.

    Args:
        windows: The stretches of the recording that can be replayed separately, in order.
        phases_s: When each phase was entered.
        length_s: Time of the last snapshot.
        frames: Returns the snapshots of the window with this number, in order.
    """

    def __init__(
        self,
        windows: list[_Window],
        phases_s: list[float],
        length_s: float,
        frames: Callable[[int], list[Snapshot]],
    ) -> None:
        self.phases_s = phases_s
        self.length_s = length_s
        self._starts_s = [window.start_s for window in windows]
        self._frames = frames

    def at(self, time_s: float) -> Snapshot:
        """Return the newest snapshot not later than this time, else the first one."""
        frames = self._frames(max(bisect_right(self._starts_s, time_s) - 1, 0))
        return frames[max(bisect_right(frames, time_s, key=lambda frame: frame.now_s) - 1, 0)]


class _Window(NamedTuple):
    """A stretch of a recording.

    Attributes:
        after: The checkpoint at its beginning; None: the start of the run.
        memory: The events before it.
        start_s: Time of its beginning.
    """

    after: Checkpoint | None
    memory: Memory
    start_s: float


def recorded_snapshots(recording: Recording) -> RecordedSnapshots:
    """Return the snapshots of a recording.

    Raises:
        RecordingError: The recording is damaged or empty.
    """
    with recorded_mission(recording.header) as loaded:
        windows, phases_s = _windows(recording, loaded)

    @lru_cache(maxsize=_MOST_WINDOWS)
    def frames(number: int) -> list[Snapshot]:
        return list(_frames(recording, loaded, windows, number))

    if not frames(0):
        raise RecordingError(f"{recording.path} ends before the run began")
    return RecordedSnapshots(windows, phases_s, recording.until_s, frames)


def _windows(recording: Recording, loaded: LoadedMission) -> tuple[list[_Window], list[float]]:
    """Return a window from each checkpoint on, and when each phase was entered."""
    memory = Memory(loaded.robot, nominal=recording.header.nominal)
    windows, phases_s = [_Window(None, memory.twin(), 0.0)], [0.0]
    checkpoints, gaps = recording.checkpoints(), _gaps(recording)
    due = next(checkpoints, None)
    for step in recording.effects():
        while due is not None and due.step < step.number:
            windows.append(_Window(due, memory.twin(), due.at_s))
            due = next(checkpoints, None)
        if gap := gaps.get(step.number):
            memory.lose(gap.from_s, gap.until_s)
        memory.see(step.effects, step.at_s)
        if memory.story.phase.since_s > phases_s[-1]:
            phases_s.append(memory.story.phase.since_s)
    return windows, phases_s


def _gaps(recording: Recording) -> dict[int, Gap]:
    """Return the gaps of a recording, each by the number of the first step after it."""
    return {gap.step: gap for gap in recording.gaps}


def _frames(
    recording: Recording, loaded: LoadedMission, windows: list[_Window], number: int
) -> Iterator[Snapshot]:
    """Yield the snapshots of a window, with trends continued from the window before."""
    begin, window = windows[max(number - 1, 0)], windows[number]
    last = number + 1 == len(windows)
    until_s = recording.until_s if last else windows[number + 1].start_s
    robot = loaded.robot
    engine = engine_of(recording.header, loaded)
    anatomy = anatomy_of(loaded.loaded_robot.profile, robot)
    scene = MissionScene(loaded, engine, anatomy, recording.header.backend)
    memory, gaps = begin.memory.twin(), _gaps(recording)
    places = _RecordedPlaces(recording, loaded)
    trends = Trends()
    every_s, due_s = max(FINEST_S, (until_s - window.start_s) / MOST_FRAMES), window.start_s
    state, last_s = None, 0.0
    places.begin(window.start_s)

    def shown(
        state: EngineState, at_s: float, *, over: bool = False, lost_s: float = 0.0
    ) -> Snapshot:
        what = scene, at_s, state, memory.story, places.at(at_s), not places.known
        ahead_s = recording.origin_s
        found = Snapshot(*what, trends=trends.latest, over=over, ahead_s=ahead_s)
        return replace(found, held_s=lost_s)

    for again in rerun(recording, loaded, begin.after):
        at_s = last_s = again.at_s
        if at_s >= until_s and not last:
            return
        if gap := gaps.get(again.step.number):
            memory.lose(gap.from_s, gap.until_s)
            if state is not None:
                lost_s = gap.until_s - gap.from_s
                yield shown(state, gap.from_s + min(FINEST_S, lost_s), lost_s=lost_s)
        memory.see(with_own_times(again.effects, recording.origin_s), at_s)
        state = again.state or state
        if state is None:
            continue
        trends.look(scene, state, at_s)
        if at_s >= due_s:
            due_s = at_s + every_s
            yield shown(state, at_s)
    if last and state is not None:
        yield shown(state, last_s, over=recording.complete)


class _RecordedPlaces:
    """Reads the robot's positions from the recording."""

    def __init__(self, recording: Recording, loaded: LoadedMission) -> None:
        self._body = loaded.loaded_robot.profile.body
        pipe = loaded.pipe
        self._walls = drawn_walls(pipe.route()) if pipe is not None else ()
        self._places: Iterator[Placed] = iter(())
        self._recording = recording
        self._next: Placed | None = None
        self._newest: tuple[Place, ...] = ()
        self._space: InSpace | None = None
        self.known = False

    def begin(self, since_s: float) -> None:
        """Begin to read positions at this time."""
        self._places = recorded_places(self._recording, self._body, since_s)
        self._next = next(self._places, None)

    def at(self, time_s: float) -> Truth | None:
        """Return the newest position by this time, in order of time; None if none is recorded."""
        while self._next is not None and self._next.at_s <= time_s:
            self.known, self._newest = self._next.known, tuple(self._next.wheels)
            self._space = self._next.space
            self._next = next(self._places, None)
        if not self._newest:
            return None
        truth = Truth(self._newest, self._body.wheel_radius, self._walls, 0.0)
        space = self._space
        return truth if space is None else replace(truth, z_m=space.z_m, rolls_rad=space.rolls_rad)


# --- the viewer ---------------------------------------------------------------------------------


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
        playing: Whether it is playing.
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

    # --- what an operator wants -------------------------------------------------------------------

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
