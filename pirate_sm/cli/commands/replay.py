"""`pirate replay`: replays a recording and reports whether the result is the same."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from pirate_sm.cli.options.recordings import ReplayOptions
from pirate_sm.cli.output.terminal import progress
from pirate_sm.core import library
from pirate_sm.core.effects import Effect, with_reason
from pirate_sm.core.errors import RecordingError, UsageError
from pirate_sm.core.events import Tick
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.core.units import TIME, QuantityError, read_quantity
from pirate_sm.core.visible import visible
from pirate_sm.running.recording.format.header import RunHeader
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.recorded_mission import as_recorded, recorded_fit, recorded_mission
from pirate_sm.running.recording.replay import Difference, Replayed, replay


@contextmanager
def opened_recording(path: str) -> Iterator[Recording]:
    """Open a recording and print its notices; show on a terminal how far it has been read.

    Raises:
        RecordingError: The recording cannot be read.
    """
    with progress(f"reading {visible(path)}") as watch:
        recording = read_recording(Path(path), watch)
        for notice in recording.notices:
            print_visible(f"{path}: {notice}")
        yield recording


def title(recording: Recording) -> str:
    """Return the mission, the backend, its fidelity if coarser, and the date, in one line."""
    header = recording.header
    fidelity = "".join(f" ({name})" for name in header.coarser)
    return f"{header.mission} on {header.backend}{fidelity}, {header.began}"


def print_visible(text: str) -> None:
    """Print a text with all invisible characters written out."""
    print(visible(text))


SAME, DIFFERENT = 0, 1


LONG_S = 900.0
"""From this mission time on, several processes are worth while."""


class ReplayStretch(NamedTuple):
    """The requested part of a run.

    Attributes:
        from_s: Its beginning, 0 or more; ``until_s`` is its end, infinite for that of the run.
    """

    from_s: float = 0.0
    until_s: float = inf


def run_replay(options: ReplayOptions) -> int:
    """Replay a recording and print the result; return the exit code.

    Raises:
        RecordingError: The recording cannot be read or contains nothing to replay.
        LoadError: The files for the replay have errors.
        UsageError: A file or an option does not fit.
    """
    stretch, other = _stretch(options.begin, options.until), _changed(options)
    if other and stretch.from_s:
        raise UsageError(
            "--from continues from what was recorded, so it excludes another --mission"
        )
    path = options.recording
    with opened_recording(path) as recording, _mission(recording, options) as loaded:
        if stretch.from_s > recording.until_s:
            raise RecordingError(
                f"{path} holds nothing after {recording.until_s:.3f} s: nothing was replayed"
            )
        result = _replayed(recording, loaded, options, stretch)
    print_visible(title(recording))
    if result.difference is not None:
        _print_difference(result, loaded, recording.header if other else None)
        return DIFFERENT
    if not result.executed:
        raise RecordingError(
            f"{path} holds nothing to replay: "
            f"{'the stretch' if recording.until_s else 'it'} ends before the engine was started"
        )
    print_visible(_same(result))
    if not recording.complete and result.until_s >= recording.until_s:
        print_visible("the recording ends there")
    return SAME


def _stretch(begin: str | None, until: str | None) -> ReplayStretch:
    """Return the stretch between two times as text, such as ``3 h``.

    Raises:
        UsageError: They are not times, or the end is before the beginning.
    """
    found = ReplayStretch(_time("--from", begin, 0.0), _time("--until", until, inf))
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


def _changed(options: ReplayOptions) -> bool:
    """Return whether other files than the recorded ones are used."""
    return (options.mission, options.robot, options.pipe) != (None, None, None)


def _replayed(
    recording: Recording, loaded: LoadedMission, options: ReplayOptions, stretch: ReplayStretch
) -> Replayed:
    """Replay the stretch, in several processes if it is long."""
    other = _changed(options)
    after = recording.checkpoint(stretch.from_s) if stretch.from_s else None
    if stretch.from_s and after is None:
        print_visible(
            f"no checkpoint up to {stretch.from_s:g} s can be used: it begins at the start"
        )
    jobs = 1 if other or recording.gaps else options.jobs or _jobs(recording, stretch)
    if jobs > 1 and next(recording.checkpoints(after), None) is not None:
        from pirate_sm.running.recording.parallel_replay import replay_shared

        return replay_shared(recording, jobs, after=after, until_s=stretch.until_s)
    return replay(recording, loaded, changed=other, after=after, until_s=stretch.until_s)


def _print_difference(result: Replayed, loaded: LoadedMission, changed: RunHeader | None) -> None:
    """Print the first difference; ``changed`` is the recording's header if files are changed."""
    if result.difference is None:
        return
    recorded, now = _described(result.difference, result.steps)
    for line in recorded:
        print_visible(line)
    for line in now:
        print_visible(line if changed is None else _renamed(line, loaded, changed))


def _jobs(recording: Recording, stretch: ReplayStretch) -> int:
    """Return the number of processors, 1 if several processes do not pay."""
    if min(stretch.until_s, recording.until_s) - stretch.from_s < LONG_S:
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _same(result: Replayed) -> str:
    since = f"from {result.from_s:.3f} s " if result.from_s else ""
    gap = result.gap
    stopped = "" if gap is None else f", where it stops: the next is from {gap.until_s:.3f} s"
    return (
        f"replayed identically: {result.effects} effects of {result.steps} inputs, "
        f"{since}up to {result.until_s:.3f} s{stopped}"
    )


@contextmanager
def _mission(recording: Recording, options: ReplayOptions) -> Iterator[LoadedMission]:
    """Load the mission of the recording, or another in its place."""
    if not _changed(options):
        with recorded_mission(recording.header) as loaded:
            yield loaded
        return
    header = recording.header
    if options.mission is None:
        raise UsageError("name the mission to replay it with by --mission")
    loaded = load_mission(
        library.find_mission(options.mission),
        robot=options.robot,
        pipe=options.pipe,
        settings=header.options.get("settings") or {},
        start_phase=header.options.get("start_phase"),
        states=header.options.get("states"),
        fitted=recorded_fit(header),
    )
    yield as_recorded(loaded, header)


def _described(difference: Difference, steps: int) -> tuple[list[str], list[str]]:
    """Return lines about the recorded effects, and lines about the replayed ones."""
    step = difference.step
    event = field_words(step.event)
    same = f"the first {steps} inputs gave the same; at {step.at_s:.3f} s this one does not:"
    where = f"in the phase {difference.phase}" if difference.phase else "at the start"
    place = f" ({difference.place})" if difference.place else ""
    if difference.remembers:
        parts = ", ".join(difference.remembers)
        left = f"its effects are the same, but the engine's state differs in {parts}"
        return [same, f"  {event}"], [f"  {where}{place}", f"  {left}"]
    recorded = ["  recorded:", *_listed(difference.recorded)]
    now = [f"  now, {where}{place}:", *_listed(difference.replayed)]
    return [same, f"  {event}", *recorded], now


def _listed(effects: tuple[Effect, ...]) -> Iterator[str]:
    if not effects:
        yield "    nothing"
    for effect in effects:
        yield f"    {field_words(effect)}"


def _renamed(line: str, loaded: LoadedMission, header: RunHeader) -> str:
    """Return the line with the names of the replayed files instead of the recorded ones."""
    for old, new in zip(header.files, loaded.documents, strict=False):
        line = line.replace(f"{old.name}:", f"{new.name}:")
    return line


def field_words(thing: Any) -> str:
    """Return an event or effect as one line, with the names and values of its fields.

    Args:
        thing: The event or effect; None for the start of the engine.
    """
    if thing is None:
        return "the start"
    if isinstance(thing, Tick):
        return "the passing of time"
    name = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(thing).__name__).lower()
    fields = zip(thing._fields, thing, strict=True)
    said = [
        f"{field.replace('_', ' ')} {_value(value)}"
        for field, value in fields
        if value != "" and (field, value) != ("unmet", ())
    ]
    return with_reason(name, ", ".join(said))


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple):
        return f"({', '.join(map(_value, value))})"
    return "none" if value is None else str(value)
