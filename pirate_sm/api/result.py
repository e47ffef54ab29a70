"""A run that is over, or a part of one: how it ended, its tables and its report.

Its events are kept in memory during the run and, if asked for, in a recording.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from functools import cached_property, partial
from html import escape
from itertools import chain, takewhile
from math import inf
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from pirate_sm.api.arguments import is_number, path_of
from pirate_sm.core.effects import Effect, Ended
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import Event, InSpace, Stood, Trail, Whereabouts
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.on_disk import is_file
from pirate_sm.core.resuming import AS_DECLARED, Beginning
from pirate_sm.core.sensing import Glide
from pirate_sm.core.spelling import meant
from pirate_sm.running.recording.clamp_forces import clamp_forces
from pirate_sm.running.recording.format.header import RunHeader
from pirate_sm.running.recording.read.pieces import Gap, RecordedStep
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import engine_of, rerun_steps
from pirate_sm.running.recording.tables import SIGNALS, TABLES, TIME, headers, rows_of
from pirate_sm.running.recording.write.recorder import Recorder
from pirate_sm.running.recording.write.sampler import due_steps
from pirate_sm.running.wiring import Prepared
from pirate_sm.running.wiring.run_recorder import RunRecorder, requested_recording, run_header
from pirate_sm.views.report import GENERATOR

if TYPE_CHECKING:  # a check of a mission loads no NumPy
    from pirate_sm.views.report.contents import Report
    from pirate_sm.views.report.poses import Poses

# --- results ------------------------------------------------------------------------------------


Columns: TypeAlias = dict[str, list[Any]]
"""A table: values by the name of their column, which says the unit. Unknown numbers are NaN.

``pandas.DataFrame(columns)`` and ``polars.DataFrame(columns)`` take it as it is.
"""

_FORCE_COLUMNS = ("wheel", "force_N", "least_N", "greatest_N")
_FRAME = '<iframe style="width:100%;height:48em;border:0" srcdoc="{}"></iframe>'


@dataclass(frozen=True)
class Page:
    """A report as one page of HTML, which a notebook shows."""

    html: str = field(repr=False)

    def __repr__(self) -> str:
        return f"<Page of HTML: {len(self.html) // 1000} kB; write(FILE) keeps it>"

    def write(self, path: str | PathLike[str]) -> None:
        """Write the page to a file; one with an earlier page is replaced.

        Raises:
            UsageError: The file cannot be written, or it is something else than such a page.
        """
        place = Path(path)
        try:
            if is_file(place) and GENERATOR not in place.read_bytes():
                raise UsageError(
                    f"{path} exists and is not a report; not overwritten: "
                    "name another file, or remove it"
                )
            place.write_text(self.html, encoding="utf-8")
        except OSError as error:
            raise UsageError(f"{path} cannot be written: {error.strerror}") from None

    def _repr_html_(self) -> str:
        return _FRAME.format(escape(self.html))


@dataclass(frozen=True)
class Run:
    """What happened in a run; it can be pickled.

    Attributes:
        loaded: The mission as it was run.
        header: What was run, and with which options.
        steps: Returns what the engine was given and what came of it, in order.
        poses: Returns where the wheels really were; None where nobody knew.
        gaps: Where steps of a repaired recording are lost.
        notices: What a reader must know, such as that a recording ends early.
        sha256: Hash of the recording that it was read from; empty without one.
        origin_s: When the run began, by the engine's clock; its own times count from there.
    """

    loaded: LoadedMission = field(repr=False)
    header: RunHeader = field(repr=False)
    steps: Callable[[], Iterable[RecordedStep]] = field(repr=False)
    poses: Callable[[], Poses | None] = field(repr=False)
    gaps: tuple[Gap, ...]
    notices: tuple[str, ...] = ()
    sha256: str = ""
    origin_s: float = 0.0

    @property
    def ended(self) -> Ended | None:
        """How the run ended, as the engine says it; None where no end is known."""
        return self._last[0]

    @property
    def outcome(self) -> str:
        """``succeeded``, ``failed``, ``fault`` or ``interrupted``; empty where no end is known."""
        return self.ended.outcome if self.ended else ""

    @property
    def message(self) -> str:
        """Why it ended so, for people; empty where no end is known."""
        return self.ended.message if self.ended else ""

    @property
    def duration_s(self) -> float:
        """Mission time of the last thing that happened, s."""
        return max(self._last[1] - self.origin_s, 0.0)

    @property
    def signals(self) -> Columns:
        """Every signal at each frame of a board: ``time_s`` and a column for each."""
        return self.table(SIGNALS)

    @property
    def commands(self) -> Columns:
        """What became of commands: ``time_s``, ``name``, ``status``, ``reason``, ``place``."""
        return self.table("commands")

    @property
    def states(self) -> Columns:
        """The robot's states after each change: ``time_s`` and a column for each region."""
        return self.table("states")

    @property
    def faults(self) -> Columns:
        """Faults: ``time_s``, ``code``, ``message`` and ``handling``."""
        return self.table("faults")

    def table(self, name: str) -> Columns:
        """Return one table by its name, as ``pirate export --csv`` names its files.

        Its columns are empty where nothing of the kind has happened.

        Raises:
            UsageError: There is no such table in any run.
        """
        if name not in TABLES:
            raise UsageError(f"there is no table '{name}': {meant(str(name), sorted(TABLES))}")
        return self._tables[name]

    @property
    def tables(self) -> tuple[str, ...]:
        """Names of the tables that have rows."""
        return tuple(name for name, columns in self._tables.items() if columns[TIME])

    def normal_forces(self, at_s: float) -> Columns:
        """Return how hard each wheel that holds presses at a time, and all of them together.

        Clamped wheels are statically indeterminate: ``force_N`` is what the statics of the chain
        give with a guess at what braked wheels bear; between ``least_N`` and ``greatest_N`` lie
        all static states that the signals, friction and brakes admit. The last row is their sum.

        Args:
            at_s: Mission time.

        Returns:
            Columns ``wheel``, ``force_N``, ``least_N``, ``greatest_N``; empty where nothing holds
            or too little is known.

        Raises:
            UsageError: That cannot be a time, or SciPy, of the extra ``fit``, is not installed.
            LoadError: The run had a twin whose file is not there any more.
        """
        if not is_number(at_s):
            raise UsageError(f"at_s: expected a time in s, got {at_s!r}")
        state = None
        again = rerun_steps(self._engine, self.steps(), self.gaps, origin_s=self.origin_s)
        for each in takewhile(lambda each: each.at_s <= at_s, again):
            state = each.state
        forces = () if state is None else clamp_forces(self.loaded, state, self.header.options)
        columns = zip(*forces, strict=True) if forces else ((),) * len(_FORCE_COLUMNS)
        return dict(zip(_FORCE_COLUMNS, map(list, columns), strict=True))

    def report(self) -> Page:
        """Return the report: what happened in words, the robot in its pipe, timeline and plots."""
        from pirate_sm.views.report.report_page import html

        return Page(html(self.contents()))

    def contents(self) -> Report:
        """Return the contents of the report as plain values."""
        from pirate_sm.views.report.recording_report import gather
        from pirate_sm.views.report.run_facts import about_run

        about = about_run(self.header, self.loaded, self.notices)
        again = rerun_steps(self._engine, self.steps(), self.gaps, origin_s=self.origin_s)
        report = gather(self.loaded, about, again, self.poses())
        return replace(report, recording=self.sha256)

    def show(self) -> None:
        """Show the report below the cell of a notebook.

        Raises:
            UsageError: This is no notebook.
        """
        try:
            from IPython.display import display
        except ModuleNotFoundError:
            raise UsageError(
                "show() is for notebooks; report().write(FILE) writes a page"
            ) from None
        display(self.report())  # type: ignore[no-untyped-call]

    def __repr__(self) -> str:
        what = f"{self.header.mission} on {self.header.backend}"
        return f"<Run of {what}: {self.outcome or 'no end'} after {self.duration_s:.2f} s>"

    def _repr_html_(self) -> str:
        facts = {
            "mission": self.header.mission,
            "backend": self.header.backend,
            "outcome": self.outcome or "unknown",
            "message": self.message,
            "duration": f"{self.duration_s:.2f} s",
            "faults": ", ".join(dict.fromkeys(self.faults["code"])) or "none",
        }
        rows = "".join(
            f"<tr><th>{name}</th><td>{escape(text)}</td></tr>" for name, text in facts.items()
        )
        return f"<table>{rows}</table>"

    @property
    def _engine(self) -> Engine:
        return engine_of(self.header, self.loaded, every_signal=True)

    @cached_property
    def _last(self) -> tuple[Ended | None, float]:
        """How it ended, and the time of the last thing that happened."""
        end, last_s = None, 0.0
        steps = self.steps.without_frames() if isinstance(self.steps, _KeptSteps) else self.steps()
        for step in steps:
            last_s = max(last_s, step.at_s)
            for effect in step.effects:
                if isinstance(effect, Ended):
                    end = effect
        return end, last_s

    @cached_property
    def _tables(self) -> dict[str, Columns]:
        """Every table, made by giving the engine again what it was given."""
        robot = self.loaded.robot
        named = headers(robot).items()
        tables: dict[str, Columns] = {table: {name: [] for name in names} for table, names in named}
        again = rerun_steps(self._engine, self.steps(), self.gaps, origin_s=self.origin_s)
        for row in rows_of(robot, again, self.origin_s):
            for column, value in zip(tables[row.table].values(), row.values, strict=True):
                column.append(value)
        return tables


def read(recording: str | PathLike[str]) -> Run:
    """Return the run that a recording holds; it stays on the disk and is read when needed.

    Args:
        recording: Path of the ``.mcap`` file.

    Raises:
        RecordingError: It cannot be read, or is of a version that cannot be used any more.
        UsageError: It is no path.
    """
    from pirate_sm.views.report.recording_report import known_poses

    found = read_recording(Path(path_of(recording)))
    with recorded_mission(found.header) as loaded:
        return Run(
            loaded,
            found.header,
            steps=found.steps,
            poses=partial(known_poses, found, loaded),
            gaps=found.gaps,
            notices=found.notices,
            sha256=found.sha256,
            origin_s=found.origin_s,
        )


# --- notes of a run -----------------------------------------------------------------------------


@dataclass(frozen=True)
class _KeptSteps:
    """Returns the steps of a run; other processes can be sent it.

    Frames that were taken together stay together until they are read: one by one they are so many
    objects that Python's garbage collector takes as long as the run.
    """

    kept: tuple[RecordedStep | Glide, ...]

    def __call__(self) -> Iterator[RecordedStep]:
        number = 0
        for each in self.kept:
            for at_s, event, effects in each.in_order() if isinstance(each, Glide) else ():
                yield RecordedStep(number, at_s, event, effects, "engine")
                number += 1
            if isinstance(each, RecordedStep):
                yield each._replace(number=number)
                number += 1

    def without_frames(self) -> Iterator[RecordedStep]:
        """Yield the steps that were taken alone, and the last of those that were not."""
        for each in self.kept:
            if isinstance(each, RecordedStep):
                yield each
            elif times_s := each.times_s():
                yield RecordedStep(0, times_s[-1], None, (), "engine")


@dataclass(frozen=True)
class _KeptPoses:
    """Returns where the wheels were; other processes can be sent it.

    Attributes:
        places: Times, and what the trail has noted at them, or where the robot stood at one.
        read: Reads what a trail has noted; None without any.
        flat: Whether the robot moves in a plane.
    """

    places: tuple[tuple[Sequence[float], bytes | Stood], ...]
    read: Callable[[Sequence[bytes]], Whereabouts] | None
    flat: bool

    def __call__(self) -> Poses | None:
        from pirate_sm.views.report.poses import Poses

        poses = Poses(true=True)
        for at_s, stood in self._stood():
            poses.add(at_s, stood.wheels, None if self.flat else stood.space)
        return poses.thinned() if poses.times_s else None

    def _stood(self) -> Iterator[tuple[float, Stood]]:
        noted = [each for _, each in self.places if isinstance(each, bytes)]
        rows = zip(*self.read(noted), strict=True) if self.read is not None and noted else iter(())
        for times_s, each in self.places:
            for at_s in times_s:
                yield at_s, each if isinstance(each, Stood) else Stood.of(next(rows))


class Notes:
    """A tap that keeps every step in memory and passes it on to a recorder.

    Args:
        prepared: The run.
        header: What was run.
        recorder: Who else keeps the steps.

    Attributes:
        stepwise: Whether the recorder looks at the run after each step.
    """

    def __init__(self, prepared: Prepared, header: RunHeader, recorder: Recorder | None) -> None:
        from pirate_sm.views.report.poses import EVERY_S

        self._every_s = EVERY_S
        self._prepared = prepared
        self._header = header
        self._recorder = recorder
        self._steps: list[RecordedStep | Glide] = []
        self._places: list[tuple[Sequence[float], bytes | Stood]] = []
        self._pose_s = 0.0
        self._trail: Trail | None = None
        self.stepwise = recorder is not None and recorder.stepwise

    @property
    def due_s(self) -> float:
        """Return when the recorder looks at the engine next."""
        return inf if self._recorder is None else self._recorder.due_s

    def start(
        self,
        seen: Sequence[Event],
        now_s: float,
        effects: Sequence[Effect],
        begins: Beginning = AS_DECLARED,
    ) -> None:
        """Note how the engine started."""
        if self._recorder is not None:
            self._recorder.start(seen, now_s, effects, begins)
        self._steps += [RecordedStep(0, now_s, event, (), "seen") for event in seen]
        start = RecordedStep(0, now_s, None, tuple(effects), "start", **begins._asdict())
        self._steps.append(start)
        self._pose(now_s)

    def take(self, event: Event, now_s: float, effects: Sequence[Effect]) -> None:
        """Note one step of the engine."""
        if self._recorder is not None:
            self._recorder.take(event, now_s, effects)
        self._steps.append(RecordedStep(0, now_s, event, tuple(effects), "engine"))
        self._pose(now_s)

    def secure(self) -> None:
        """Return when all that was noted is on the disk, or soon if that takes too long."""
        if self._recorder is not None:
            self._recorder.secure()

    def take_glide(self, glide: Glide) -> None:
        """Note the steps of the engine that were taken at once, and the poses at them."""
        if self._recorder is not None:
            self._recorder.take_glide(glide)
        self._steps.append(glide._replace(after=None, looks=(), trail=None))
        self._trail = trail = glide.trail
        if self._prepared.wheels is None or trail is None or trail.until_s < self._pose_s:
            return
        due_s = due_steps(glide.times_s(), self._pose_s, self._every_s)
        if due_s:
            self._pose_s = due_s[-1] + self._every_s
            self._places.append((due_s, trail.noted(due_s)))

    def abandon(self, now_s: float, effects: Sequence[Effect]) -> None:
        """Note what was done past the engine."""
        if self._recorder is not None:
            self._recorder.abandon(now_s, effects)
        self._steps.append(RecordedStep(0, now_s, None, tuple(effects), "runtime"))

    def run(self, *notices: str) -> Run:
        """Return the run as far as it has come.

        Args:
            notices: What its reader must know; empty ones are left out.
        """
        failure = self._recorder.failure if self._recorder is not None else ""
        early = f"the recording ends early: {failure}" if failure else ""
        read = None if self._trail is None else self._trail.read
        return Run(
            self._prepared.loaded,
            self._header,
            steps=_KeptSteps(tuple(self._steps)),
            poses=_KeptPoses(tuple(self._places), read, self._prepared.in_space is None),
            gaps=(),
            notices=tuple(text for text in (early, *notices) if text),
        )

    def _pose(self, now_s: float) -> None:
        wheels, in_space = self._prepared.wheels, self._prepared.in_space
        if wheels is not None and now_s >= self._pose_s:
            self._pose_s = now_s + self._every_s
            stood = None if self._trail is None else self._trail.at(now_s)
            if stood is None:
                places_m = tuple(chain.from_iterable(wheels()))
                stood = Stood(places_m, in_space() if in_space else InSpace((), ()))
            self._places.append(((now_s,), stood))


@contextmanager
def noted(
    prepared: Prepared, record: str | PathLike[str] | None, state: Callable[[], EngineState | None]
) -> Iterator[Notes]:
    """Keep notes of a run until the block ends.

    Args:
        prepared: The run.
        record: A file that must not exist, for a recording; None: there is none.
        state: Returns the engine's state after the step that was noted last.

    Raises:
        RecordingError: The file cannot be made.
        UsageError: It is no path.
    """
    header = run_header(prepared, inf, datetime.now(UTC).astimezone())
    if record is None:
        yield Notes(prepared, header, None)
        return
    path = Path(path_of(record))
    recording = RunRecorder(prepared, header, requested_recording(path, header))
    recording.follow(prepared, state)
    try:
        yield Notes(prepared, header, recording.recorder)
    finally:
        recording.close(path)
