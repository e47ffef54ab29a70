"""The values that a shell offers for an option or an argument, from files and their names.

Options name these functions. Each takes what is on the command line before the cursor and the
beginning of the word, and yields values with a line about each. They read files and names of entry
points, and neither run nor import what is in them. What cannot be read yields nothing: the caller
catches all errors (see ``answer.py``).
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from pirate_sm.core import library
from pirate_sm.core.errors import PirateError, UsageError
from pirate_sm.core.library import PROFILE_FILE
from pirate_sm.core.on_disk import is_file, is_folder, opened
from pirate_sm.core.options import DEFECT_KEYS, OF_PIPE, keys_of_defect

if TYPE_CHECKING:
    import typer

# --- reading for a shell ------------------------------------------------------------------------


Candidate: TypeAlias = tuple[str, str]
"""A value, and a line about it."""

OPEN = ("/", "=", ":", ",")
"""Signs after which a value continues."""

RECORDING = ".mcap"


def read(path: Path) -> Mapping[Any, Any]:
    """Return what is in a file; nothing if it cannot be read."""
    from pirate_sm.core.documents import read_document

    try:
        return mapping(read_document(path).data)
    except (PirateError, OSError, ValueError):
        return {}


def read_extended(path: Path) -> Mapping[Any, Any]:
    """Return what is in a file and in the one that it extends; nothing if they cannot be read."""
    from pirate_sm.core import documents

    try:
        return mapping(documents.read_extended(path).data)
    except (PirateError, OSError, ValueError):
        return {}


def recorded(path: Path, role: str) -> Mapping[Any, Any]:
    """Return what was in the file of a recording's mission or robot; it may be cut off."""
    from mcap.records import Attachment, Chunk
    from mcap.stream_reader import StreamReader

    from pirate_sm.core.documents import parse_document

    with opened(path) as file:
        for record in StreamReader(file, emit_chunks=True).records:
            if isinstance(record, Attachment) and record.name.endswith(f"_{role}.yaml"):
                return mapping(parse_document(record.data, record.name).data)
            if isinstance(record, Chunk):  # the run begins, and the files come before it
                break
    return {}


def about_file(path: Path) -> str:
    """Return the description in a file; empty if there is none."""
    return line(read(path).get("description")) if path.suffix in library.SUFFIXES else ""


def described(found: Any) -> Iterator[Candidate]:
    """Yield the keys of a mapping with the descriptions in their values."""
    for name, each in mapping(found).items():
        yield str(name), line(mapping(each).get("description"))


def mapping(found: Any) -> Mapping[Any, Any]:
    """Return a mapping as it is; of anything else an empty one."""
    return found if isinstance(found, dict) else {}


def items(found: Any, key: str) -> list[Any]:
    """Return the list at a key of a mapping; an empty one if there is none."""
    listed = mapping(found).get(key)
    return listed if isinstance(listed, list) else []


def line(found: Any) -> str:
    """Return a text or a number as text; of anything else an empty one."""
    return str(found) if isinstance(found, str | int | float) else ""


# --- names and files ----------------------------------------------------------------------------


MOST_FILES = 1000
"""The most files of a folder that are read."""

MOST_RUNS = 20
"""The most recordings that are offered from the folder for recordings; the newest ones."""


def _of(
    shipped: Callable[[], Iterable[Path]], fits: Callable[[Path], bool]
) -> Callable[[typer.Context, str], Iterator[Candidate]]:
    """Return a function that yields shipped names, and the files that fit."""

    def found(context: typer.Context, typed: str) -> Iterator[Candidate]:
        yield from _shipped(shipped(), typed)
        yield from _files(typed, fits)

    return found


missions = _of(library.missions, lambda path: _is(path, {"mission"}))
missions_or_recordings = _of(
    library.missions, lambda path: path.suffix == RECORDING or _is(path, {"mission"})
)
coverable = _of(
    library.missions, lambda path: path.suffix == RECORDING or _is(path, {"campaign", "mission"})
)
campaigns = _of(library.missions, lambda path: _is(path, {"campaign", "mission"}))
pipes = _of(library.pipes, lambda path: _is(path, {"pipe"}))
cameras = _of(library.cameras, lambda path: _is(path, {"camera"}))
panels = _of(library.panels, lambda path: _is(path, {"panel"}))
scripts = _of(tuple, lambda path: _is(path, {"trace script"}))
twins = _of(tuple, lambda path: _is(path, {"twin"}))
charts_in_scxml = _of(tuple, lambda path: path.suffix in {".scxml", ".xml"})
checkable = _of(tuple, lambda path: path.suffix in library.SUFFIXES)
files = _of(tuple, lambda path: True)
folders = _of(tuple, lambda path: False)


def robots(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the shipped robots, and folders."""
    for robot in library.robots():
        if robot.name.startswith(typed):
            yield robot.name, about_file(robot / PROFILE_FILE)
    for folder, about in folders(context, typed):
        profile = Path(folder).expanduser() / PROFILE_FILE
        yield (folder.rstrip("/"), about_file(profile)) if is_file(profile) else (folder, about)


def scenes(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the scenes of the gallery, and files."""
    for path in library.scenes():
        if path.stem.startswith(typed):
            yield path.stem, line(read(path).get("title"))
    yield from _files(typed, lambda path: "scene" in read(path))


def drawable(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield missions, robots and pipes, and files of them and of charts."""
    yield from _shipped([*library.missions(), *library.pipes()], typed)
    yield from robots(context, typed)
    yield from _files(typed, lambda path: _is(path, {"mission", "pipe", "robot", "chart"}))


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


def _shipped(paths: Iterable[Path], typed: str) -> Iterator[Candidate]:
    for path in paths:
        if path.stem.startswith(typed):
            yield path.stem, about_file(path)


def _files(typed: str, fits: Callable[[Path], bool]) -> Iterator[Candidate]:
    """Yield files and folders whose path begins so; a ``~`` stays as it is."""
    folder, slash, name = typed.rpartition("/")
    inside = Path(f"{folder}{slash}" or ".").expanduser()
    for each in _entries(inside):
        if not each.name.startswith(name) or (each.name[0] == "." and not name):
            continue
        path = inside / each.name
        if is_folder(each.path):
            yield f"{folder}{slash}{each.name}/", ""
        elif fits(path):
            yield f"{folder}{slash}{each.name}", about_file(path)


def _entries(folder: Path) -> list[os.DirEntry[str]]:
    """Return what is in a folder, sorted by name; nothing if it cannot be read."""
    try:
        with os.scandir(folder) as found:
            return sorted(islice(found, MOST_FILES), key=lambda each: each.name)
    except OSError:
        return []


def _is(path: Path, kinds: Collection[str]) -> bool:
    from pirate_sm.core.documents import kind_of

    return path.suffix in library.SUFFIXES and kind_of(path) in kinds


# --- values in files ----------------------------------------------------------------------------


LONGEST_LINE = 100_000
"""The most characters that are read of the first line of a table."""

_CONDITIONS = ("when", "operator", "after")
"""The keys of a trigger that say when it fires."""

_NUMBER = re.compile(r"_\d+(?=_|$)")


def phases(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the phases of the mission on the command line, or in the recording to resume."""
    resumed = context.params.get("resume")
    path = Path(resumed).expanduser() if resumed else None
    mission = _mission(context) if path is None else recorded(path, "mission")
    yield from described(mission.get("phases"))


def phases_in_order(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the phases of the drawn mission as the next ones after a comma."""
    path = library.find_mission(context.params["file"])
    before, comma, _ = typed.rpartition(",")
    for name, about in described(read(path).get("phases")):
        if name not in before.split(","):
            yield f"{before}{comma}{name}", about


def phases_of_missions(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield missions, and after a colon their phases."""
    name, colon, _ = typed.rpartition(":")
    if not colon:
        for mission, about in missions(context, typed):
            yield (mission if mission.endswith("/") else f"{mission}:"), about
        return
    for phase, about in described(read(library.find_mission(name)).get("phases")):
        yield f"{name}:{phase}", about


def triggers(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the triggers of the mission and of those that it calls, and time limits."""
    path = _mission_path(context)
    if path is not None:
        yield from dict(_triggers(path, set())).items()
        yield "within", "the time limit of a wait"


def _triggers(path: Path, seen: set[Path]) -> Iterator[Candidate]:
    """Yield the named triggers of a mission, each with its condition."""
    if path in seen:
        return
    seen.add(path)
    for step in _mappings(read(path).get("phases")):
        for each in items(step, "wait"):
            trigger = mapping(each)
            if name := line(trigger.get("name") or trigger.get("go")):
                yield name, next((line(trigger[k]) for k in _CONDITIONS if k in trigger), "")
        if isinstance(called := step.get("call"), str):
            with suppress(UsageError):
                yield from _triggers(library.find_mission(called, path.resolve().parent), seen)


def _mappings(found: Any) -> Iterator[Mapping[Any, Any]]:
    """Yield all mappings in data, from outside to inside."""
    if isinstance(found, dict):
        yield found
        found = list(found.values())
    for each in found if isinstance(found, list) else ():
        yield from _mappings(each)


def cells(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the cells of the campaign, by the names of its missions."""
    path = Path(context.params["campaign"]).expanduser()
    for each in items(read(path), "missions"):
        entry = mapping(each)
        mission = line(each) or line(entry.get("mission"))
        yield line(entry.get("name")) or Path(mission).stem, mission


def parameters(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the parameters of the mission, and after the sign the value in its file."""
    found = mapping(_mission(context).get("parameters"))
    for name, parameter in found.items():
        default = line(mapping(parameter).get("default"))
        about = line(mapping(parameter).get("description"))
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
    """Yield the known defects of the robot, and after a colon or comma the numbers they take."""
    known = mapping(mapping(_profile(_robot(context)).get("simulation")).get("defects"))
    name, colon, _ = typed.partition(":")
    if not colon:
        yield from described(known)
        return
    before = typed[: max(typed.rfind(":"), typed.rfind(",")) + 1]
    for key in keys_of_defect(line(mapping(known.get(name)).get("kind"))):
        yield f"{before}{key}=", DEFECT_KEYS[key].meaning


def numbers(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the numbers of the robot that a twin may have, with those in its profile, or a pipe."""
    from pirate_sm.core.models import PARTS_OF_A_TWIN
    from pirate_sm.simulation.changed_pipe import PIPE_NUMBERS

    yield from ((f"{OF_PIPE}{name}=", "") for name in PIPE_NUMBERS)
    profile = _profile(_robot(context))
    groups = {f"motors.{name}": each for name, each in mapping(profile.get("motors")).items()}
    groups |= {name: mapping(profile.get("simulation")).get(name) for name in ("friction", "noise")}
    for group, found in groups.items():
        for key, value in mapping(found).items():
            if key in PARTS_OF_A_TWIN[group.partition(".")[0]].model_fields:
                yield f"{group}.{key}=", line(value)


def factors(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield what `pirate margins` can change: numbers of the pipe and the robot, and of defects."""
    if ":" in typed:
        yield from defects(context, typed)
        return
    known = [each for each in numbers(context, typed) if not each[0].startswith("friction.")]
    yield from ((name.removeprefix(OF_PIPE).removesuffix("="), value) for name, value in known)
    yield from ((f"{name}:", about) for name, about in defects(context, ""))


def joints(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the joints of the robot."""
    for each in items(_profile(_robot(context)).get("body"), "joints"):
        yield line(mapping(each).get("name")), ""


def signals(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the signals in the first recording or table, ``{}`` for the number of a wheel."""
    path = Path(context.params["runs"][0]).expanduser()
    if path.suffix == RECORDING:
        profile = recorded(path, "profile")
        channels = (each for board in items(profile, "boards") for each in items(board, "channels"))
        names = [*(line(mapping(each).get("signal")) for each in channels)]
        names += map(str, mapping(profile.get("derived")))
    else:
        with opened(path) as table:
            names = table.readline(LONGEST_LINE).decode("utf-8-sig").strip().split(",")
    for name in dict.fromkeys(_NUMBER.sub("_{}", name) for name in names if name):
        yield name, ""


def routes(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the routes of the pipe on the command line."""
    pipe = read(library.find_pipe(context.params["pipe"], Path.cwd()))
    for name, runs in mapping(pipe.get("routes")).items():
        yield str(name), ", ".join(map(str, runs)) if isinstance(runs, list) else ""


def backends(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the backends, also of other packages."""
    from pirate_sm.robot import part_names

    yield from _parts(part_names.BACKENDS, part_names.BACKEND_GROUP)


def detectors(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the detectors, also of other packages; after ``vision:`` the cameras."""
    from pirate_sm.robot import part_names

    name, colon, camera = typed.partition(":")
    if not colon:
        for each, about in _parts(part_names.DETECTORS, part_names.DETECTOR_GROUP):
            yield (f"{each}:" if each == part_names.BY_CAMERA else each), about
    elif name == part_names.BY_CAMERA:
        for each, about in cameras(context, camera):
            yield f"{name}:{each}", about


def codes(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the codes of findings, and the controls of the robot."""
    from pirate_sm import checking
    from pirate_sm.core.events import BUILT_IN_FAULTS

    for file in sorted(Path(checking.__file__).with_name("catalogue").glob("*.yaml")):
        for code, entry in mapping(read(file).get("codes")).items():
            yield str(code), line(mapping(entry).get("title"))
    yield from ((code, each.meaning) for code, each in BUILT_IN_FAULTS.items())
    yield from described(_profile(_robot(context)).get("controls"))


def experiments(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the experiments of the robot, their parts, and ``all``."""
    for file in sorted((_robot(context) / "experiments").glob("*.yaml")):
        found = read(file)
        yield line(found.get("experiment")), line(found.get("title"))
        for part, mission in mapping(found.get("missions")).items():
            yield str(part), line(mission)
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


def _states(robot: Path, typed: str) -> Iterator[Candidate]:
    """Yield the regions of a robot's chart, and after the sign of one its states."""
    chart = read_extended(robot / line(_profile(robot).get("chart")))
    for top in mapping(chart.get("states")).values():
        for region, found in mapping(mapping(top).get("states")).items():
            if not typed.startswith(f"{region}="):
                yield f"{region}=", ""
                continue
            for state in mapping(mapping(found).get("states")):
                yield f"{region}={str(state).removeprefix(f'{region}.')}", ""


def _parts(ours: Mapping[str, str], group: str) -> Iterator[Candidate]:
    """Yield our parts of a kind, and the names of those of other packages."""
    from pirate_sm.core.registry import package_name, points_of

    yield from ours.items()
    for point in points_of(group):
        if point.name not in ours:
            yield point.name, f"of the package {package_name(point)}"


def _mission(context: typer.Context) -> Mapping[Any, Any]:
    """Return what is in the file of the mission on the command line."""
    path = _mission_path(context)
    return {} if path is None else read(path)


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
    named = None if path is None else read(path).get("robot")
    if path is not None and isinstance(named, str):
        return library.find_robot(named, path.resolve().parent)
    return library.robots()[0]


def _profile(robot: Path) -> Mapping[Any, Any]:
    return read_extended(robot / PROFILE_FILE)
