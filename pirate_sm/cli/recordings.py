"""`pirate replay`, `pirate compare` and `pirate export`: what can be made of recordings."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from pathlib import Path

from pirate_sm.cli.outputs import refuse_losses, write_file
from pirate_sm.cli.progress import progress
from pirate_sm.cli.worded import worded
from pirate_sm.errors import RecordingError, UsageError
from pirate_sm.expressions import NumberType
from pirate_sm.loading import library
from pirate_sm.loading.mission import LoadedMission, load_mission
from pirate_sm.model.effects import Effect
from pirate_sm.recording.header import RunHeader
from pirate_sm.recording.reader import Recording, read_recording
from pirate_sm.recording.reloading import as_recorded, recorded_mission
from pirate_sm.recording.replay import Difference, Replayed, replay
from pirate_sm.units import DIMENSIONLESS, TIME, QuantityError, format_quantity, read_quantity
from pirate_sm.visible import visible

SAME, DIFFERENT = 0, 1

LONG_S = 900.0
"""From so much mission time on it is worth while to share a replay out among processes."""

_MOST_SIGNALS = 12


@dataclass(frozen=True)
class Changed:
    """What a recording is replayed with in place of its own texts; empty: nothing."""

    mission: str | None = None
    robot: str | None = None
    pipe: str | None = None


@dataclass(frozen=True)
class Wanted:
    """What a recording is exported to: a folder of tables, and files."""

    csv: str | None = None
    urdf: str | None = None
    lichtblick: str | None = None
    plotjuggler: str | None = None


@dataclass(frozen=True)
class Stretch:
    """The part of a run that is asked for, as the command line says it.

    Attributes:
        from_s: Where it begins, 0 or more; ``until_s`` where it ends, infinite for the end.
    """

    from_s: float = 0.0
    until_s: float = inf

    @classmethod
    def of(cls, from_: str | None, until: str | None) -> Stretch:
        """The stretch between two times in words, ``3 h``.

        Raises:
            UsageError: They are no times, or it ends before it begins.
        """
        found = cls(_time("--from", from_, 0.0), _time("--until", until, inf))
        if found.until_s <= 0:
            raise UsageError("--until must be later than the start of the run: nothing is left")
        if found.until_s <= found.from_s:
            raise UsageError("--until must be later than --from")
        return found


def _time(option: str, text: str | None, otherwise: float) -> float:
    if text is None:
        return otherwise
    try:
        time_s = read_quantity(text, TIME)
    except QuantityError as error:
        raise UsageError(f"{option}: {error}") from None
    if not time_s >= 0:
        raise UsageError(f"{option}: a time since the run began is not negative")
    return time_s


def run_replay(path: str, changed: Changed, stretch: Stretch, jobs: int | None) -> int:
    """The recording has been executed again, and it has been said how that went.

    Args:
        path: The recording.
        changed: What it is replayed with in place of its own texts.
        stretch: What of it.
        jobs: Among how many processes it is shared out; None: as many as there are processors
            where it is long.

    Raises:
        RecordingError: The recording cannot be read, or there is nothing to execute in it.
        LoadError: What it shall be replayed with cannot be used.
        UsageError: Likewise.
    """
    other = changed != Changed()
    if other and stretch.from_s:
        raise UsageError("--from goes on from what was recorded, so it excludes another --mission")
    with _reading(path) as recording, _mission(recording, changed) as loaded:
        if stretch.from_s > recording.until_s:
            raise RecordingError(
                f"{path} holds nothing after {recording.until_s:.3f} s: nothing was executed again"
            )
        after = recording.checkpoint(stretch.from_s) if stretch.from_s else None
        if stretch.from_s and after is None:
            _say(f"no checkpoint up to {stretch.from_s:g} s can be used: it begins at the start")
        jobs = 1 if other else jobs or _jobs(recording, stretch)
        if jobs > 1 and next(recording.checkpoints(after), None) is not None:
            from pirate_sm.recording.sharing import replay_shared

            result = replay_shared(recording, jobs, after=after, until_s=stretch.until_s)
        else:
            until_s = stretch.until_s
            result = replay(recording, loaded, changed=other, after=after, until_s=until_s)
    _say(_headline(recording))
    if result.difference is not None:
        recorded, now = _told(result.difference, result.steps)
        for line in recorded:
            _say(line)
        for line in now:
            _say(_renamed(line, loaded, recording.header) if other else line)
        return DIFFERENT
    if not result.executed:
        raise RecordingError(
            f"{path} holds nothing to execute again: "
            f"{'the stretch' if recording.until_s else 'it'} ends before the engine was started"
        )
    _say(_same(result))
    if not recording.complete and result.until_s >= recording.until_s:
        _say("the recording ends there")
    return SAME


def _jobs(recording: Recording, stretch: Stretch) -> int:
    """As many processes as there are processors, where that is worth while."""
    if min(stretch.until_s, recording.until_s) - stretch.from_s < LONG_S:
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _same(result: Replayed) -> str:
    since = f"from {result.from_s:.3f} s " if result.from_s else ""
    return (
        f"the same came out again: {result.effects} effects of {result.steps} inputs, "
        f"{since}up to {result.until_s:.3f} s"
    )


def run_compare(first: str, second: str) -> int:
    """Two runs have been laid side by side.

    Raises:
        RecordingError: One of the recordings cannot be read.
    """
    from pirate_sm.recording.compare import compare, course_of

    courses, loadeds, headers = [], [], []
    for path in (first, second):
        with _reading(path) as recording, recorded_mission(recording.header) as loaded:
            headers.append(recording.header)
            courses.append(course_of(recording, loaded))
            loadeds.append(loaded)
        _say(f"{'B' if len(courses) > 1 else 'A'}: {_headline(recording)}")
    _say("")
    for line in _told_apart(*headers):
        _say(line)
    result = compare(*courses)
    _say("")
    _say(f"{'what the mission comes to':<42} {'A':>9} {'B':>9} {'B - A':>9}   lasted A, B")
    for leg in result.legs:
        later_s = leg.second_s - leg.first_s
        _say(
            f"{leg.mark:<42} {leg.first_s:>7.2f} s {leg.second_s:>7.2f} s {later_s:>+7.2f} s   "
            f"{leg.lasted_first_s:.2f} s, {leg.lasted_second_s:.2f} s"
        )
    if result.parted is not None:
        _say(f"here they part: A comes to '{result.parted[0]}', B to '{result.parted[1]}'")
    _say("")
    apart = [each for each in result.deviations if each.most > 0]
    if result.deviations and not apart:
        _say("every signal is the same in A and B")
    if apart:
        _say("farthest apart, for what signals of their kind span:")
    for each in apart[:_MOST_SIGNALS]:
        kind = loadeds[0].robot.vocabulary.types[each.name]
        dimension = kind.dimension if isinstance(kind, NumberType) else DIMENSIONLESS
        most, typical, a, b = (
            format_quantity(float(f"{value:.4g}"), dimension)
            for value in (each.most, each.typical, each.first, each.second)
        )
        _say(
            f"  {each.name:<16} up to {most}, typically {typical}; "
            f"most after '{each.where}' at {each.at_s:.2f} s of A: {a} and {b}"
        )
    return DIFFERENT if result.parted is not None else SAME


def _told_apart(first: RunHeader, second: RunHeader) -> Iterator[str]:
    """What the two runs were not alike in, a line each."""
    from pirate_sm.recording.circumstances import unlike

    found = unlike(first, second)
    if not found:
        yield "A and B were made with the same seed, parameters and files"
        return
    names, ones = (max(len(each[column]) for each in found) for column in (0, 1))
    yield f"{'what differed':<{max(names, 13)}}  {'A':<{max(ones, 1)}}  B"
    for each in found:
        yield f"{each.name:<{max(names, 13)}}  {each.first:<{max(ones, 1)}}  {each.second}"


def run_export(path: str, wanted: Wanted) -> int:
    """The recording's topics are tables, its robot a URDF, and so on, as was asked for.

    Raises:
        RecordingError: The recording cannot be read, or a folder cannot be written.
        UsageError: Nothing was asked for, a file cannot be written, or a recording or another of
            the files would be lost for it.
    """
    if wanted == Wanted():
        raise UsageError("say what to export: --csv DIR, --urdf, --lichtblick, --plotjuggler FILE")
    if "" in (wanted.csv, wanted.urdf, wanted.lichtblick, wanted.plotjuggler):
        raise UsageError("a folder or a file has a name: '' is none")
    places = (wanted.csv, wanted.urdf, wanted.lichtblick, wanted.plotjuggler)
    refuse_losses(Path(place) for place in places if place is not None)
    written: list[str] = []
    with _reading(path) as recording, recorded_mission(recording.header) as loaded:
        if wanted.csv is not None:
            from pirate_sm.recording.tables import write_tables

            written += map(str, write_tables(recording, loaded, Path(wanted.csv)))
        for place, text in _texts(loaded, wanted):
            write_file(Path(place), text)
            written.append(place)
    for file in written:
        _say(file)
    return 0


def _texts(loaded: LoadedMission, wanted: Wanted) -> Iterator[tuple[str, str]]:
    """Each file that was asked for with its text."""
    from pirate_sm.recording import layouts
    from pirate_sm.recording.urdf import urdf

    if wanted.urdf is not None:
        yield wanted.urdf, urdf(loaded.loaded_robot.profile)
    if wanted.lichtblick is not None:
        yield wanted.lichtblick, layouts.lichtblick_layout(loaded)
    if wanted.plotjuggler is not None:
        yield wanted.plotjuggler, layouts.plotjuggler_layout(loaded)


@contextmanager
def _reading(path: str) -> Iterator[Recording]:
    """The recording; while the block goes through it, a terminal shows how far it has come."""
    with progress(f"reading {visible(path)}") as watch:
        recording = read_recording(Path(path), watch)
        for notice in recording.notices:
            _say(f"{path}: {notice}")
        yield recording


@contextmanager
def _mission(recording: Recording, changed: Changed) -> Iterator[LoadedMission]:
    """The mission of the recording, or a changed one in its place."""
    if changed == Changed():
        with recorded_mission(recording.header) as loaded:
            yield loaded
        return
    header = recording.header
    if changed.mission is None:
        raise UsageError("say with --mission which mission it shall be replayed with")
    loaded = load_mission(
        library.find_mission(changed.mission),
        robot=changed.robot,
        pipe=changed.pipe,
        settings=header.options.get("settings") or {},
        start_phase=header.options.get("start_phase"),
        states=header.options.get("states"),
    )
    yield as_recorded(loaded, header)


def _headline(recording: Recording) -> str:
    header = recording.header
    return f"{header.mission} on {header.backend}, {header.began}"


def _told(difference: Difference, steps: int) -> tuple[list[str], list[str]]:
    """Lines about what was recorded, and then about what comes out now."""
    step = difference.step
    event = worded(step.event)
    same = f"the first {steps} inputs gave the same; then, at {step.at_s:.3f} s, this does not:"
    where = f"in the phase {difference.phase}" if difference.phase else "at the start"
    place = f" ({difference.place})" if difference.place else ""
    if difference.remembers:
        parts = ", ".join(difference.remembers)
        left = f"its effects are the same; what the engine remembers then is not: {parts}"
        return [same, f"  {event}"], [f"  {where}{place}", f"  {left}"]
    recorded = ["  recorded:", *_listed(difference.recorded)]
    now = [f"  now, {where}{place}:", *_listed(difference.replayed)]
    return [same, f"  {event}", *recorded], now


def _listed(effects: tuple[Effect, ...]) -> Iterator[str]:
    if not effects:
        yield "    nothing"
    for effect in effects:
        yield f"    {worded(effect)}"


def _renamed(line: str, loaded: LoadedMission, header: RunHeader) -> str:
    """The line with the files that are executed now in place of those that were recorded."""
    for old, new in zip(header.files, loaded.documents, strict=False):
        line = line.replace(f"{old.name}:", f"{new.name}:")
    return line


def _say(text: str) -> None:
    print(visible(text))
