"""`pirate replay`, `pirate compare` and `pirate export`: what can be made of recordings."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from pirate_sm.errors import UsageError
from pirate_sm.expressions import NumberType
from pirate_sm.loading import library
from pirate_sm.loading.mission import LoadedMission, load_mission
from pirate_sm.model.effects import Effect
from pirate_sm.recording.header import RunHeader
from pirate_sm.recording.reader import Recording, read_recording
from pirate_sm.recording.reloading import as_recorded, recorded_mission
from pirate_sm.recording.replay import Difference, replay
from pirate_sm.showing.visible import visible
from pirate_sm.units import DIMENSIONLESS, format_quantity

SAME, DIFFERENT = 0, 1

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


def run_replay(path: str, changed: Changed) -> int:
    """The recording has been executed again, and it has been said how that went.

    Raises:
        RecordingError: The recording cannot be read.
        LoadError: What it shall be replayed with cannot be used.
        UsageError: Likewise.
    """
    recording = _read(path)
    with _mission(recording, changed) as loaded:
        result = replay(recording, loaded, changed=changed != Changed())
        _say(_headline(recording))
        if result.difference is not None:
            for line in _told(result.difference, result.steps):
                _say(line)
            return DIFFERENT
    _say(
        f"the same came out again: {result.effects} effects of {result.steps} inputs, "
        f"up to {result.until_s:.3f} s"
    )
    if not recording.complete:
        _say("the recording ends there; the run itself was cut short")
    return SAME


def run_compare(first: str, second: str) -> int:
    """Two runs have been laid side by side.

    Raises:
        RecordingError: One of the recordings cannot be read.
    """
    from pirate_sm.recording.compare import compare, course_of

    courses, loadeds, headers = [], [], []
    for path in (first, second):
        recording = _read(path)
        headers.append(recording.header)
        with recorded_mission(recording.header) as loaded:
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
        apart = leg.second_s - leg.first_s
        _say(
            f"{leg.mark:<42} {leg.first_s:>7.2f} s {leg.second_s:>7.2f} s {apart:>+7.2f} s   "
            f"{leg.lasted_first_s:.2f} s, {leg.lasted_second_s:.2f} s"
        )
    if result.parted is not None:
        _say(f"here they part: A comes to '{result.parted[0]}', B to '{result.parted[1]}'")
    _say("")
    if result.deviations:
        _say("farthest apart, for what signals of their kind span:")
    for each in result.deviations[:_MOST_SIGNALS]:
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
        UsageError: Nothing was asked for, or a file cannot be written.
    """
    if wanted == Wanted():
        raise UsageError("say what to export: --csv DIR, --urdf, --lichtblick, --plotjuggler FILE")
    recording = _read(path)
    written: list[str] = []
    with recorded_mission(recording.header) as loaded:
        if wanted.csv is not None:
            from pirate_sm.recording.tables import write_tables

            written += map(str, write_tables(recording, loaded, Path(wanted.csv)))
        for place, text in _texts(loaded, wanted):
            try:
                Path(place).write_text(text, encoding="utf-8")
            except OSError as error:
                raise UsageError(f"{place} cannot be written: {error.strerror}") from None
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


def _read(path: str) -> Recording:
    recording = read_recording(Path(path))
    for notice in recording.notices:
        _say(f"{path}: {notice}")
    return recording


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


def _told(difference: Difference, steps: int) -> Iterator[str]:
    step = difference.step
    event = "the start" if step.event is None else repr(step.event)
    yield f"the first {steps} inputs gave the same; then, at {step.at_s:.3f} s, {event} does not"
    where = f"in the phase {difference.phase}" if difference.phase else "at the start"
    yield f"  {where}" + (f" ({difference.place})" if difference.place else "")
    yield "  recorded:"
    yield from _listed(difference.recorded)
    yield "  now:"
    yield from _listed(difference.replayed)


def _listed(effects: tuple[Effect, ...]) -> Iterator[str]:
    if not effects:
        yield "    nothing"
    for effect in effects:
        yield f"    {effect!r}"


def _say(text: str) -> None:
    print(visible(text))
