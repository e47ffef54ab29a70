"""`pirate list`: lists the names for missions and command lines."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from pirate_sm.cli.options.files import ListOptions
from pirate_sm.cli.output.terminal import columns_of, wrapped
from pirate_sm.core import library
from pirate_sm.core.documents import read_document
from pirate_sm.core.errors import PirateError
from pirate_sm.core.expressions import EnumType, NumberType
from pirate_sm.core.loading import LoadedRobot, load_robot, validate
from pirate_sm.core.models import Mission, Pipe
from pirate_sm.core.options import keys_of_defect
from pirate_sm.core.registry import Registry
from pirate_sm.core.units import describe
from pirate_sm.core.visible import visible
from pirate_sm.robot.camera import Camera
from pirate_sm.robot.control_panel.panel_file import Panel

Row = Sequence[str]


def list_things(options: ListOptions) -> int:
    """Print these lists, by default all of them; return the exit code.

    Raises:
        LoadError: The robot's files cannot be used.
        UsageError: There is no such robot.
    """
    folders = [library.find_robot(options.robot, Path.cwd())] if options.robot else library.robots()
    for kind in [options.what] if options.what else _LISTS:
        _LISTS[kind](folders)
    return 0


def _robots(folders: Iterable[Path]) -> None:
    rows = [(folder.name, load_robot(folder).profile.description) for folder in folders]
    print_table("robots", rows)


def _commands(folders: Iterable[Path]) -> None:
    for folder in folders:
        profile = load_robot(folder).profile
        other = {name: alias for alias, name in profile.aliases.items()}
        rows = []
        for name, command in profile.commands.items():
            alias = f"also {other[name]}" if name in other else ""
            lets_go = "releases every clamp" if command.lets_go else ""
            about = "; ".join(part for part in (command.description, lets_go, alias) if part)
            rows.append((name, f"at most {command.timeout:g} s", about))
        print_table(f"commands of {folder.name}", rows)


def _signals(folders: Iterable[Path]) -> None:
    for folder in folders:
        print_table(f"signals and states of {folder.name}", _vocabulary(load_robot(folder)))


def _vocabulary(robot: LoadedRobot) -> Iterable[Row]:
    for name, kind in robot.normal.vocabulary.types.items():
        if isinstance(kind, NumberType):
            yield name, describe(kind.dimension)
        elif isinstance(kind, EnumType):
            yield name, " | ".join(kind.values)


def _defects(folders: Iterable[Path]) -> None:
    for folder in folders:
        defects = load_robot(folder).profile.simulation.defects
        rows = [(n, ", ".join(keys_of_defect(d.kind)), d.description) for n, d in defects.items()]
        print_table(f"defects of {folder.name}", rows)


def _missions(_: Iterable[Path]) -> None:
    print_table("missions", [(path.stem, _described(path, Mission)) for path in library.missions()])


def _pipes(_: Iterable[Path]) -> None:
    print_table("pipes", [(path.stem, _described(path, Pipe)) for path in library.pipes()])


def _cameras(_: Iterable[Path]) -> None:
    print_table("cameras", [(path.stem, _described(path, Camera)) for path in library.cameras()])


def _backends(_: Iterable[Path]) -> None:
    from pirate_sm.running.wiring import BACKENDS

    print_table("backends", _plugins(BACKENDS))


def _detectors(_: Iterable[Path]) -> None:
    from pirate_sm.robot.detectors.registry import DETECTORS

    print_table("detectors", _plugins(DETECTORS))


def list_panels(_: Iterable[Path] = ()) -> None:
    """Print the shipped control panels."""
    print_table("panels", [(path.stem, _described(path, Panel)) for path in library.panels()])


def _plugins(registry: Registry[Any]) -> Iterable[Row]:
    """Yield each name with its package, and why it cannot be used if that is so."""
    for each in registry.listed():
        about = f"cannot be used: {each.fault}" if each.fault else each.about
        yield each.name, each.package or "pirate-sm", about


def _described(path: Path, model: type[Mission | Panel | Pipe | Camera]) -> str:
    """Return the description in a file, or the first line of what is wrong with it."""
    try:
        return validate(read_document(path), model).description
    except PirateError as error:
        return error.for_terminal.partition("\n")[0]


def print_table(title: str, rows: Iterable[Row]) -> None:
    """Print rows under a title, in columns."""
    lines = [[visible(str(cell)) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    columns = columns_of()
    before = 2 + sum(width + 2 for width in widths[:-1])
    print(f"{title}:")
    for line in lines or [["(none)"]]:
        cells = [cell.ljust(width) for cell, width in zip(line, widths or [0], strict=True)]
        print(wrapped(f"  {'  '.join(cells)}".rstrip(), columns, before))
    print()


_LISTS: dict[str, Callable[[Iterable[Path]], None]] = {
    "robots": _robots,
    "commands": _commands,
    "signals": _signals,
    "defects": _defects,
    "missions": _missions,
    "pipes": _pipes,
    "cameras": _cameras,
    "backends": _backends,
    "detectors": _detectors,
    "panels": list_panels,
}
