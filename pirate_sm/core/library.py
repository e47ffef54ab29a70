"""Find robots, missions, pipes, cameras and panels by name or by path.

The shipped ones are inside the installed package, or at the root of a source tree.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from pirate_sm.core.errors import UsageError
from pirate_sm.core.on_disk import (
    YAML,
    is_file,
    is_folder,
    is_there,
    listed,
    resolved,
    why_hidden,
)
from pirate_sm.core.spelling import meant, nearest

PROFILE_FILE = "profile.yaml"
_PACKAGE = Path(__file__).resolve().parents[1]
SUFFIXES = YAML
_RECORDING = ".mcap"
_LONGEST_NAME = 100
_LONGEST_MESSAGE = 600


def shown(path: Path) -> str:
    """Return the path for messages, relative if it is inside the current folder.

    A symbolic link is resolved, so that a file has only one name; a broken link keeps its own.
    """
    try:
        here = Path.cwd()
        whole = resolved(path) if is_file(path) or is_folder(path) else path.absolute()
    except (OSError, RuntimeError, ValueError):
        return str(path).replace("\0", "\\0")
    return str(whole.relative_to(here)) if whole.is_relative_to(here) else str(path)


def shipped() -> Path:
    """Return the folder with the shipped files, each kind in a folder of its own."""
    packaged = _PACKAGE / "_data"
    return packaged if is_folder(packaged) else _PACKAGE.parent


def robots() -> list[Path]:
    """Return the folders of the shipped robots."""
    root = shipped() / "hardware_profiles"
    folders = (root / each.name for each in listed(root) if each.is_folder)
    return [folder for folder in folders if is_file(folder / PROFILE_FILE)]


def missions() -> list[Path]:
    """Return the files of the shipped missions."""
    return _files("sequences")


def pipes() -> list[Path]:
    """Return the files of the shipped pipes."""
    return _files("sequences", "pipes")


def cameras() -> list[Path]:
    """Return the files of the shipped cameras."""
    return _files("cameras")


def panels() -> list[Path]:
    """Return the files of the shipped control panels."""
    return _files("panels")


def scenes() -> list[Path]:
    """Return the files of the shipped scenes of the gallery."""
    return _files("demos")


def _files(*folders: str) -> list[Path]:
    folder = shipped().joinpath(*folders)
    return [folder / each.name for each in listed(folder) if each.name.endswith(YAML[0])]


def find_scene(name: str) -> Path:
    """Return the file of the scene of this name or path.

    Raises:
        UsageError: There is none.
    """
    return _find_file("scene", name, None, scenes())


def find_robot(name: str | None, beside: Path | None = None) -> Path:
    """Return the folder of the robot of this name or path.

    Args:
        name: A shipped robot's name, or the path of a folder or of the profile in it; None: the
            first shipped robot.
        beside: A folder to which relative paths refer first.

    Raises:
        UsageError: No such robot exists.
    """
    if name is None:
        return robots()[0]
    for path in _candidates(name, beside):
        if is_file(path / PROFILE_FILE):
            return resolved(path)
        if path.name == PROFILE_FILE and is_file(path):
            return resolved(path.parent)
    if is_path(name):
        for path in _candidates(name, beside):
            if why := why_hidden(path / PROFILE_FILE):
                raise UsageError(f"the robot at '{_cut(name)}' cannot be read: {why}")
        where = f"there is no robot at '{_cut(name)}'"
        raise UsageError(f"{where}: expected a folder with {PROFILE_FILE}")
    return _by_name("robot", name, {path.name: path for path in robots()})


def shadowing(name: str, found: Path) -> str:
    """Return a notice if a local folder hides the shipped robot of this name; empty otherwise.

    Args:
        name: The robot's name in a file.
        found: The folder found under this name.
    """
    known = {path.name: path for path in robots()}
    if is_path(name) or name not in known or resolved(known[name]) == resolved(found):
        return ""
    return f"the robot '{name}' is the one in {shown(found)}, not the shipped one of that name"


def find_mission(name: str, beside: Path | None = None) -> Path:
    """Return the file of the mission of this name or path.

    Args:
        name: A shipped mission's name, or a path.
        beside: The folder of the file that gives the name; what is in there comes first.

    Raises:
        UsageError: There is none.
    """
    return _find_file("mission", name, beside, missions())


def find_pipe(name: str, beside: Path | None = None) -> Path:
    """Return the file of the pipe of this name or path; as for missions.

    Raises:
        UsageError: There is none.
    """
    folders = [] if beside is None else [beside, beside / "pipes"]
    return _find_file("pipe", name, folders, pipes())


def find_camera(name: str, beside: Path | None = None) -> Path:
    """Return the file of the camera of this name or path; in a folder ``cameras`` before ours.

    Raises:
        UsageError: There is none.
    """
    folders = [] if beside is None else [beside, beside / "cameras"]
    return _find_file("camera", name, folders, cameras())


def find_panel(name: str, beside: Path) -> Path:
    """Return the file of the control panel of this name or path; as for missions.

    Raises:
        UsageError: There is none.
    """
    return _find_file("panel", name, [beside, beside / "panels"], panels())


def _find_file(
    kind: str, name: str, beside: Path | Iterable[Path] | None, known: Iterable[Path]
) -> Path:
    folders = [beside] if isinstance(beside, Path) else list(beside or ())
    refuse_recording(name, kind)
    if is_path(name):
        places = [*(folder / name for folder in folders), Path(name)]
        found = [*filter(is_file, places), *filter(why_hidden, places)]
        if not folders:
            found += filter(is_there, places)
        if found:
            return found[0]  # whoever opens it says why it cannot be read
        close = nearest(name, (path.stem for path in known)) if Path(name).name == name else None
        hint = f"; did you mean '{close}'?" if close else ""
        raise UsageError(f"there is no {kind} at '{_cut(name)}'{hint}")
    for folder in folders:
        for suffix in SUFFIXES:
            if is_file(folder / f"{name}{suffix}"):
                return folder / f"{name}{suffix}"
    shipped = {path.stem: path for path in known}
    if name not in shipped and (near := file_nearby(name, folders or [Path()])) is not None:
        raise UsageError(f"there is no {kind} '{_cut(name)}'; did you mean '{near}'?")
    return _by_name(kind, name, shipped)


def refuse_recording(name: str, wanted: str) -> None:
    """Refuse the name of a recording where a file of another kind is wanted.

    Raises:
        UsageError: It is the name of a recording.
    """
    if name.endswith(_RECORDING):
        use = f"use 'pirate report {_cut(name)}' or 'pirate replay {_cut(name)}'"
        raise UsageError(f"expected a {wanted}, and '{_cut(name)}' is a recording: {use}")


def file_nearby(name: str, folders: Iterable[Path]) -> Path | None:
    """Return a file in these folders that the name is meant for without its ending."""
    places = (folder / f"{name}{suffix}" for folder in folders for suffix in SUFFIXES)
    return next(filter(is_file, places), None)


def _candidates(name: str, beside: Path | None) -> list[Path]:
    if not is_path(name):
        return [] if beside is None else [beside / name]
    return [Path(name)] if beside is None else [beside / name, Path(name)]


def is_path(name: str) -> bool:
    """Return whether the name is meant as a path, not as the name of something shipped."""
    return "/" in name or name.endswith(SUFFIXES) or name in {".", ".."}


def _by_name(kind: str, name: str, known: dict[str, Path]) -> Path:
    if name in known:
        return known[name]
    raise UsageError(_unknown(kind, name, sorted(known)))


def _unknown(kind: str, name: str, known: list[str]) -> str:
    """Return the message for an unknown name, with as many known names as fit into it."""
    hints = (meant(name, known, limit=limit) for limit in range(len(known), -1, -1))
    messages = (f"there is no {kind} '{_cut(name)}'; {hint}" for hint in hints)
    return next(message for message in messages if len(message) < _LONGEST_MESSAGE)


def _cut(name: str) -> str:
    shown = name.replace("\0", "\\0")
    return shown if len(shown) <= _LONGEST_NAME else f"{shown[:_LONGEST_NAME]}…"
