"""The values that a shell offers for an option or an argument.

Options name these functions. Each takes what is on the command line before the cursor and the
beginning of the word, and yields values with a line about each. They read files and names of entry
points, and neither run nor import what is in them. What cannot be read yields nothing: whoever asks
catches all errors (see ``answer.py``).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any, TypeAlias

import typer

from pirate_sm.errors import PirateError, UsageError
from pirate_sm.loading import library
from pirate_sm.loading.file_names import PROFILE_FILE

Candidate: TypeAlias = tuple[str, str]
"""A value, and a line about it. A value that ends in one of ``OPEN`` goes on."""

OPEN = ("/", "=", ":", ",")

MOST_FILES = 1000
"""So many files of a folder are looked at."""

MOST_RUNS = 20
"""So many recordings of the folder for them are offered, beside those of the working folder."""

RECORDING = ".mcap"


def missions(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the shipped missions, and files."""
    yield from _shipped(library.missions(), typed)
    yield from _yaml(typed, {"mission"})


def missions_or_recordings(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the shipped missions, files of missions, and recordings."""
    yield from _shipped(library.missions(), typed)
    yield from _files(typed, lambda path: path.suffix == RECORDING or _is(path, {"mission"}))


def pipes(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the shipped pipes, and files."""
    yield from _shipped(library.pipes(), typed)
    yield from _yaml(typed, {"pipe"})


def robots(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the shipped robots, and folders."""
    for robot in library.robots():
        if robot.name.startswith(typed):
            yield robot.name, _about(robot / PROFILE_FILE)
    for folder, about in folders(context, typed):
        profile = Path(folder).expanduser() / PROFILE_FILE
        yield (folder.rstrip("/"), _about(profile)) if profile.is_file() else (folder, about)


def cameras(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the shipped cameras, and files."""
    yield from _shipped(library.cameras(), typed)
    yield from _yaml(typed, {"camera"})


def panels(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the shipped control panels, and files."""
    yield from _shipped(library.panels(), typed)
    yield from _yaml(typed, {"panel"})


def scenes(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the scenes of the gallery, and files."""
    for path in library.scenes():
        if path.stem.startswith(typed):
            yield path.stem, _line(_read(path).get("title"))
    yield from _files(typed, lambda path: "scene" in _read(path))


def campaigns(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield files of campaigns, and missions."""
    yield from _shipped(library.missions(), typed)
    yield from _yaml(typed, {"campaign", "mission"})


def drawable(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield missions, robots and pipes, and files of them and of charts."""
    yield from _shipped([*library.missions(), *library.pipes()], typed)
    yield from robots(context, typed)
    yield from _files(typed, lambda path: _is(path, {"mission", "pipe", "robot", "chart"}))


def scripts(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield files with triggers, or with a course of events."""
    yield from _yaml(typed, {"trace script"})


def twins(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield files with numbers of a simulated robot."""
    yield from _yaml(typed, {"twin"})


def checkable(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield YAML files, and folders."""
    yield from _files(typed, lambda path: path.suffix in library.SUFFIXES)


def files(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield all files, and folders."""
    yield from _files(typed, lambda path: True)


def folders(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield folders."""
    yield from _files(typed, lambda path: False)


def recordings(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield recordings of the working folder, and the newest of the folder for recordings."""
    yield from _files(typed, lambda path: path.suffix == RECORDING)
    from pirate_sm.cli.settings import values

    runs = values()["runs"]
    if not typed and runs.value and not runs.refused:
        names = (each.name for each in _entries(Path(runs.value)) if each.name.endswith(RECORDING))
        for name in sorted(names, reverse=True)[:MOST_RUNS]:  # they begin with the time
            yield f"{runs.value}/{name}", ""


def recordings_or_tables(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield recordings, and tables in CSV files."""
    yield from recordings(context, typed)
    yield from _files(typed, lambda path: path.suffix == ".csv")


def charts_in_scxml(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield files in SCXML."""
    yield from _files(typed, lambda path: path.suffix in {".scxml", ".xml"})


def phases(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the phases of the mission on the command line, or in the recording to resume."""
    resumed = context.params.get("resume")
    mission = _recorded_mission(Path(resumed)) if resumed else _mission(context)
    yield from _described(mission.get("phases"))


def phases_in_order(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the phases of the drawn mission as the next ones after a comma."""
    path = library.find_mission(context.params["file"])
    before, comma, _ = typed.rpartition(",")
    for name, about in _described(_read(path).get("phases")):
        if name not in before.split(","):
            yield f"{before}{comma}{name}", about


def phases_of_missions(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield missions, and after a colon their phases."""
    name, colon, _ = typed.rpartition(":")
    if not colon:
        for mission, about in missions(context, typed):
            yield (mission if mission.endswith("/") else f"{mission}:"), about
        return
    for phase, about in _described(_read(library.find_mission(name)).get("phases")):
        yield f"{name}:{phase}", about


def parameters(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the parameters of the mission, and after the sign the value in its file."""
    found = _mapping(_mission(context).get("parameters"))
    for name, parameter in found.items():
        default = _line(_mapping(parameter).get("default"))
        about = _line(_mapping(parameter).get("description"))
        if not typed.startswith(f"{name}="):
            yield f"{name}=", f"{about} ({default})" if about and default else about or default
        elif default:
            yield f"{name}={default}", about


def states(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the regions of the robot's chart, and after the sign their states."""
    yield from _states(_robot(context), typed)


def states_of_several(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield regions and states as the next ones after a comma."""
    before, comma, last = typed.rpartition(",")
    for each, about in _states(_robot(context), last):
        yield f"{before}{comma}{each}", about


def defects(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the known defects of the robot."""
    yield from _described(_mapping(_profile(_robot(context)).get("simulation")).get("defects"))


def joints(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the joints of the robot."""
    listed = _mapping(_profile(_robot(context)).get("body")).get("joints")
    for each in listed if isinstance(listed, list) else ():
        yield _line(_mapping(each).get("name")), ""


def routes(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the routes of the pipe on the command line."""
    pipe = _read(library.find_pipe(context.params["pipe"], Path.cwd()))
    for name, runs in _mapping(pipe.get("routes")).items():
        yield str(name), ", ".join(map(str, runs)) if isinstance(runs, list) else ""


def backends(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the backends, also of other packages."""
    from pirate_sm.backends import known

    yield from _parts(known.ABOUT, known.GROUP)


def detectors(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the detectors, also of other packages; after ``vision:`` the cameras."""
    from pirate_sm.detectors import known

    name, colon, camera = typed.partition(":")
    if not colon:
        for each, about in _parts(known.ABOUT, known.GROUP):
            yield (f"{each}:" if each == known.BY_CAMERA else each), about
    elif name == known.BY_CAMERA:
        for each, about in cameras(context, camera):
            yield f"{name}:{each}", about


def codes(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the codes of findings, and the controls of the robot."""
    from pirate_sm import checking
    from pirate_sm.model.fault_codes import BUILT_IN_FAULTS

    for file in sorted(Path(checking.__file__).with_name("catalogue").glob("*.yaml")):
        for code, entry in _mapping(_read(file).get("codes")).items():
            yield str(code), _line(_mapping(entry).get("title"))
    yield from ((code, each.meaning) for code, each in BUILT_IN_FAULTS.items())
    yield from _described(_profile(_robot(context)).get("controls"))


def experiments(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the experiments of the robot, their parts, and ``all``."""
    for file in sorted((_robot(context) / "experiments").glob("*.yaml")):
        found = _read(file)
        yield _line(found.get("experiment")), _line(found.get("title"))
        for part, mission in _mapping(found.get("missions")).items():
            yield str(part), _line(mission)
    yield "all", ""


def ports(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield names of serial ports; none is opened."""
    for pattern in ("ttyACM*", "ttyUSB*", "serial/by-id/*", "cu.usb*"):
        for each in sorted(Path("/dev").glob(pattern)):
            yield str(each), ""


def words(*of: str) -> Callable[[typer.Context, str], Iterator[Candidate]]:
    """Return a function that yields these words."""

    def found(context: typer.Context, typed: str) -> Iterator[Candidate]:
        yield from ((each, "") for each in of)

    return found


def _shipped(paths: Iterable[Path], typed: str) -> Iterator[Candidate]:
    for path in paths:
        if path.stem.startswith(typed):
            yield path.stem, _about(path)


def _yaml(typed: str, kinds: Collection[str]) -> Iterator[Candidate]:
    return _files(typed, lambda path: _is(path, kinds))


def _files(typed: str, fits: Callable[[Path], bool]) -> Iterator[Candidate]:
    """Yield files and folders whose path begins so; a ``~`` stays as it is."""
    folder, slash, name = typed.rpartition("/")
    inside = Path(f"{folder}{slash}" or ".").expanduser()
    for each in _entries(inside):
        if not each.name.startswith(name) or (each.name[0] == "." and not name):
            continue
        path = inside / each.name
        if each.is_dir():
            yield f"{folder}{slash}{each.name}/", ""
        elif fits(path):
            yield f"{folder}{slash}{each.name}", _about(path)


def _entries(folder: Path) -> list[os.DirEntry[str]]:
    """Return what is in a folder, sorted by name; nothing if it cannot be read."""
    try:
        with os.scandir(folder) as found:
            return sorted(islice(found, MOST_FILES), key=lambda each: each.name)
    except OSError:
        return []


def _is(path: Path, kinds: Collection[str]) -> bool:
    from pirate_sm.checking.file_kinds import kind_of

    return path.suffix in library.SUFFIXES and kind_of(path) in kinds


def _states(robot: Path, typed: str) -> Iterator[Candidate]:
    """Yield the regions of a robot's chart, and after the sign of one its states."""
    chart = _read_extended(robot / _line(_profile(robot).get("chart")))
    for top in _mapping(chart.get("states")).values():
        for region, found in _mapping(_mapping(top).get("states")).items():
            if not typed.startswith(f"{region}="):
                yield f"{region}=", ""
                continue
            for state in _mapping(_mapping(found).get("states")):
                yield f"{region}={str(state).removeprefix(f'{region}.')}", ""


def _parts(ours: Mapping[str, str], group: str) -> Iterator[Candidate]:
    """Yield our parts of a kind, and the names of those of other packages."""
    from pirate_sm.registry import package_name, points_of

    yield from ours.items()
    for point in points_of(group):
        if point.name not in ours:
            yield point.name, f"of the package {package_name(point)}"


def _mission(context: typer.Context) -> Mapping[Any, Any]:
    """Return what is in the file of the mission on the command line."""
    path = _mission_path(context)
    return {} if path is None else _read(path)


def _mission_path(context: typer.Context) -> Path | None:
    for name in ("mission", "old", "campaign", "file"):
        given = context.params.get(name)
        if isinstance(given, str):
            with suppress(UsageError):
                return library.find_mission(given)
    return None


def _robot(context: typer.Context) -> Path:
    """Return the folder of the robot on the command line, else the mission's, else the first."""
    given = context.params.get("robot") or context.params.get("name")
    if isinstance(given, str):
        return library.find_robot(given, Path.cwd())
    path = _mission_path(context)
    named = None if path is None else _read(path).get("robot")
    if path is not None and isinstance(named, str):
        return library.find_robot(named, path.resolve().parent)
    return library.robots()[0]


def _profile(robot: Path) -> Mapping[Any, Any]:
    return _read_extended(robot / PROFILE_FILE)


def _recorded_mission(path: Path) -> Mapping[Any, Any]:
    """Return what was in the file of the mission of a recording."""
    from mcap.records import Attachment
    from mcap.stream_reader import StreamReader

    from pirate_sm.loading.yaml.document import parse_document

    with path.open("rb") as file:
        for record in StreamReader(file, emit_chunks=True).records:
            if isinstance(record, Attachment) and record.name.endswith("_mission.yaml"):
                return _mapping(parse_document(record.data, record.name).data)
    return {}


def _read(path: Path) -> Mapping[Any, Any]:
    """Return what is in a file; nothing if it cannot be read."""
    from pirate_sm.loading.yaml.document import read_document

    try:
        return _mapping(read_document(path).data)
    except (PirateError, OSError, ValueError):
        return {}


def _read_extended(path: Path) -> Mapping[Any, Any]:
    """Return what is in a file and in the one that it extends; nothing if they cannot be read."""
    from pirate_sm.loading.extended_file import read_extended

    try:
        return _mapping(read_extended(path).data)
    except (PirateError, OSError, ValueError):
        return {}


def _about(path: Path) -> str:
    """Return the description in a file; empty if there is none."""
    return _line(_read(path).get("description")) if path.suffix in library.SUFFIXES else ""


def _described(found: Any) -> Iterator[Candidate]:
    """Yield the keys of a mapping with the descriptions in their values."""
    for name, each in _mapping(found).items():
        yield str(name), _line(_mapping(each).get("description"))


def _mapping(found: Any) -> Mapping[Any, Any]:
    return found if isinstance(found, dict) else {}


def _line(found: Any) -> str:
    return str(found) if isinstance(found, str | int | float) else ""
