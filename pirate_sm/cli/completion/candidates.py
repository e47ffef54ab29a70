"""The values that a shell offers for an option or an argument, from what is in files.

Options name these functions and those of :mod:`named_files`. Each takes what is on the command line
before the cursor and the beginning of the word, and yields values with a line about each. They read
files and names of entry points, and neither run nor import what is in them. What cannot be read
yields nothing: whoever asks catches all errors (see ``answer.py``).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import typer

from pirate_sm.cli.completion.named_files import cameras, missions
from pirate_sm.cli.completion.reading import (
    RECORDING,
    Candidate,
    described,
    items,
    line,
    mapping,
    read,
    read_extended,
    recorded,
)
from pirate_sm.core.errors import UsageError
from pirate_sm.core.files import PROFILE_FILE, library
from pirate_sm.core.on_disk import opened
from pirate_sm.core.options import KEYS, keys_of

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
    for key in keys_of(line(mapping(known.get(name)).get("kind"))):
        yield f"{before}{key}=", KEYS[key].meaning


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
    from pirate_sm.robot import known

    yield from _parts(known.BACKENDS, known.BACKEND_GROUP)


def detectors(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the detectors, also of other packages; after ``vision:`` the cameras."""
    from pirate_sm.robot import known

    name, colon, camera = typed.partition(":")
    if not colon:
        for each, about in _parts(known.DETECTORS, known.DETECTOR_GROUP):
            yield (f"{each}:" if each == known.BY_CAMERA else each), about
    elif name == known.BY_CAMERA:
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
