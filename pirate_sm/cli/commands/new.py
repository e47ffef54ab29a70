"""`pirate new`: writes files that run, from a template or as a copy of shipped ones."""

from __future__ import annotations

import os
import re
from importlib import resources
from pathlib import Path
from string import Template

from pirate_sm.cli.options.files import (
    NewCameraOptions,
    NewCampaignOptions,
    NewMissionOptions,
    NewPanelOptions,
    NewPipeOptions,
    NewRobotOptions,
)
from pirate_sm.cli.schema_files import MODELINE, mission_schema_text, schema_text
from pirate_sm.core import library
from pirate_sm.core.errors import UsageError
from pirate_sm.core.generated_missions import mission_on_route
from pirate_sm.core.library import PROFILE_FILE
from pirate_sm.core.loading import LoadedRobot, load_mission, load_robot
from pirate_sm.core.models import Travel
from pirate_sm.core.on_disk import is_file, is_there
from pirate_sm.core.robot import at_rest_in, refusal
from pirate_sm.lab.experiments.needed_extras import is_missing

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")
_ROBOT_FILES = (
    "profile.yaml",
    "chart.yaml",
    "first_mission.yaml",
    "drive_on.yaml",
    "take_bend.yaml",
)

_SCHEMA = "mission.schema.json"
"""Schemas for editors, in the robot's folder."""

_ZEROS = "calibration-*.yaml"
"""The zeros of a robot's joints, which no other robot has."""

_SHIPPED = {
    "robot": library.robots,
    "mission": library.missions,
    "pipe": library.pipes,
    "camera": library.cameras,
    "panel": library.panels,
}
"""The shipped files of each kind that others name."""

_FOLD = 0.8
"""Share of a link's length by which a part reaches out in a pipe that fits."""


def write_mission(options: NewMissionOptions) -> int:
    """Write a mission that runs, NAME.yaml in the working directory; return the exit code.

    Its schema for editors is written next to it, unless the robot's folder has it.

    Raises:
        LoadError: The robot's files cannot be used.
        UsageError: The name is invalid or taken, or there is no such robot.
    """
    name, robot = options.name, options.robot
    _check("mission", name)
    folder = library.find_robot(robot, Path.cwd())
    loaded = load_robot(folder)
    shipped = folder in library.robots()
    own = folder / _SCHEMA
    beside = Path(f"{loaded.profile.robot}.{_SCHEMA}")
    schema = beside if shipped or not is_there(own) else Path(os.path.relpath(own))
    modeline = f"{MODELINE}{schema}"
    called = folder.name if shipped else os.path.relpath(folder)
    if options.pipe is not None:
        text = f"{modeline}\n{_along_route(options, loaded, called)}"
    elif options.route is not None:
        raise UsageError("--route needs the pipe that it leads through: --pipe NAME")
    else:
        text = _fill(
            "mission.yaml",
            name=name,
            modeline=modeline,
            robot=called,
            diameter=f"{_diameter_m(loaded) * 1e3:.0f} mm",
            command=_first_command(loaded),
            commands=", ".join(command.name for command in loaded.normal.commands),
        )
    path = Path(f"{name}.yaml")
    texts = {path: text}
    if not is_there(schema):
        texts[schema] = mission_schema_text(loaded)
    _write(texts)
    print(f"{path} is a mission for {loaded.profile.robot}; run it with: pirate-run {path}")
    return 0


def _along_route(options: NewMissionOptions, loaded: LoadedRobot, robot: str) -> str:
    """Return a mission along a route of a pipe.

    Raises:
        LoadError: The pipe has faults, or the robot does not fit into it.
        UsageError: There is no such pipe or route, or no mission passes one of its joints.
    """
    assert options.pipe is not None
    file = library.find_pipe(options.pipe, Path.cwd())
    travel = loaded.profile.travel and _called_from_here(loaded.profile.travel, loaded.folder)
    profile = loaded.profile.model_copy(update={"travel": travel})
    return mission_on_route(options.name, options.pipe, file, options.route, robot, profile)


def _called_from_here(travel: Travel, folder: Path) -> Travel:
    """Return how a robot travels, with paths to the missions that lie in the robot's folder."""

    def path(call: str) -> str:
        file = library.file_nearby(call, [folder])
        return os.path.relpath(file) if file else call

    turns = [each.model_copy(update={"call": path(each.call)}) for each in travel.turns]
    passages = [
        each.model_copy(update={"calls": tuple(map(path, each.calls))}) for each in travel.passages
    ]
    new = {"last": path(travel.last), "turns": tuple(turns), "passages": tuple(passages)}
    return travel.model_copy(update=new)


def write_pipe(options: NewPipeOptions) -> int:
    """Write a pipe in which the robot fits, NAME.yaml in the working directory; return the code.

    Raises:
        LoadError: The robot's files cannot be used.
        UsageError: The name is invalid or taken, or there is no such robot.
    """
    name = options.name
    _check("pipe", name)
    folder = library.find_robot(options.robot, Path.cwd())
    loaded = load_robot(folder)
    length_m = sum(link.length for link in loaded.profile.body.links)
    text = _fill(
        "round_pipe.yaml" if options.round else "pipe.yaml",
        name=name,
        modeline=_modeline("pipe"),
        diameter=f"{_diameter_m(loaded) * 1e3:.0f} mm",
        start=f"{(1.0 + length_m) / 2 * 1e3:.0f} mm",
    )
    path = _write_with_schema("pipe", name, text)
    print(f"{path} is a pipe for {loaded.profile.robot}; draw it with: pirate graph {path}")
    return 0


def write_campaign(options: NewCampaignOptions) -> int:
    """Write a campaign of a mission, NAME.yaml in the working directory; return the exit code.

    Raises:
        LoadError: The mission's files cannot be used.
        UsageError: The name is invalid or taken, or there is no such mission.
    """
    name = options.name
    _check("campaign", name)
    loaded = load_mission(library.find_mission(options.mission))
    defects = ["none", *list(loaded.loaded_robot.profile.simulation.defects)[:1]]
    text = _fill(
        "campaign.yaml",
        name=name,
        modeline=_modeline("campaign"),
        mission=options.mission,
        defects=", ".join(defects),
    )
    path = _write_with_schema("campaign", name, text)
    print(f"{path} is a campaign; run it with: pirate campaign {path}")
    if missing := is_missing("campaign"):
        print(f"first: {missing}")
    return 0


def write_robot(options: NewRobotOptions) -> int:
    """Write a small robot with a mission that runs into a new folder; return the exit code.

    Schemas for editors are written next to its files.

    Raises:
        LoadError: The robot to be copied has faults.
        UsageError: The name is invalid or taken, or there is no robot to be copied.
    """
    name = options.name
    _check("robot", name)
    folder = Path(name)
    if is_there(folder):
        raise UsageError(f"'{folder}' is there already, nothing was written")
    if options.like is not None:
        texts = _like_robot(options.like, folder)
    else:
        texts = {
            folder / file: _fill(f"robot/{file}", name=name, modeline=_modeline(file))
            for file in _ROBOT_FILES
        }
    texts |= {folder / f"{kind}.schema.json": schema_text(kind) for kind in ("profile", "chart")}
    _write(texts)
    _write({folder / _SCHEMA: mission_schema_text(load_robot(folder))})
    if options.like is not None:
        print(f"{folder}/ is a copy of {options.like}; missions take it with: --robot {folder}")
        return 0
    mission = folder / _ROBOT_FILES[2]
    print(f"{folder}/ is a robot with a mission; run it with: pirate-run {mission}")
    return 0


def _like_robot(like: str, folder: Path) -> dict[Path, str]:
    """Return the texts of a copy of a robot, without its schemas and the zeros of its joints.

    Raises:
        LoadError: The robot has faults.
        UsageError: There is no such robot, or it extends another one.
    """
    source = library.find_robot(like, Path.cwd())
    load_robot(source)
    texts = {}
    for file in sorted(source.rglob("*")):
        if is_file(file) and not file.match("*.schema.json") and not file.match(_ZEROS):
            texts[folder / file.relative_to(source)] = file.read_text("utf-8")
    for file in (folder / PROFILE_FILE, folder / _ROBOT_FILES[1]):
        if base := re.search(r"^extends: *(\S+)", texts.get(file, ""), re.MULTILINE):
            raise UsageError(
                f"'{like}' extends {base[1]}, which a copy would not find; copy that robot"
            )
    profile = folder / PROFILE_FILE
    texts[profile] = _renamed("robot", texts[profile], folder.name)
    return {
        file: re.sub(r"^(# yaml-language-server: \$schema=).*/", r"\1", text)
        for file, text in texts.items()
    }


def write_camera(options: NewCameraOptions) -> int:
    """Write a copy of a camera, NAME.yaml in the working directory; return the exit code.

    Raises:
        UsageError: The name is invalid or taken, or there is no such camera.
    """
    return _write_like("camera", options.name, library.find_camera(options.like, Path.cwd()))


def write_panel(options: NewPanelOptions) -> int:
    """Write a copy of a control panel, NAME.yaml in the working directory; return the exit code.

    Raises:
        UsageError: The name is invalid or taken, or there is no such panel.
    """
    return _write_like("panel", options.name, library.find_panel(options.like, Path.cwd()))


def _write_like(kind: str, name: str, source: Path) -> int:
    _check(kind, name)
    _, _, text = source.read_text("utf-8").partition("\n")  # the first line is its schema's
    text = f"{_modeline(kind)}\n{_renamed(kind, text, name)}"
    path = _write_with_schema(kind, name, text)
    print(f"{path} is a copy of {source.stem}; check it with: pirate check {path}")
    return 0


def _write_with_schema(kind: str, name: str, text: str) -> Path:
    """Write NAME.yaml, and its schema for editors where that is missing; return its path."""
    path, schema = Path(f"{name}.yaml"), Path(f"{kind}.schema.json")
    _write({path: text} if is_there(schema) else {path: text, schema: schema_text(kind)})
    return path


def _renamed(kind: str, text: str, name: str) -> str:
    """Return the text of a file with another name under its key."""
    return re.sub(rf"^{kind}: *\S+", f"{kind}: {name}", text, count=1, flags=re.MULTILINE)


def _check(kind: str, name: str) -> None:
    """Refuse invalid names, and names of shipped files that the new ones would hide."""
    if not _NAME.fullmatch(name):
        raise UsageError(
            f"'{name}' cannot be a name: expected a letter, then letters, digits and underscores"
        )
    shipped = _SHIPPED.get(kind, list)()
    if name in {path.stem for path in shipped}:
        raise UsageError(
            f"there is a shipped {kind} '{name}', and whatever names it would get the new one"
            f" instead: choose another name, such as my_{name}"
        )


def _modeline(file: str) -> str:
    """Return the first line of a file whose schema is next to it, by the file's name or kind."""
    kind = file.partition(".")[0]
    return f"{MODELINE}{'mission' if file in _ROBOT_FILES[2:] else kind}.schema.json"


def _fill(template: str, **values: str) -> str:
    source = resources.files("pirate_sm.cli") / "templates" / template
    return Template(source.read_text("utf-8")).substitute(values)


def _write(texts: dict[Path, str]) -> None:
    """Write all files, or none if one exists already."""
    for path in texts:
        if is_there(path):
            raise UsageError(f"'{path}' is there already, nothing was written")
    for path, text in texts.items():
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("x", encoding="utf-8") as file:
                file.write(text)
        except OSError as error:
            raise UsageError(f"'{path}' cannot be written: {error.strerror}") from None


def _diameter_m(robot: LoadedRobot) -> float:
    """Return a diameter in the middle of the robot's range, h + 2r (thesis eq. 3-2)."""
    body = robot.profile.body
    return _FOLD * min(link.length for link in body.links) + 2 * body.wheel_radius


def _first_command(robot: LoadedRobot) -> str:
    """Return a command that is possible at the start, preferably one that clamps."""
    spec = robot.normal
    start = at_rest_in(spec, spec.table.initial)
    possible = [
        (name, spec.table.follow(spec.table.initial, index))
        for index, name in enumerate(spec.table.commands)
        if not refusal(spec, start, index)
    ]
    holding = [name for name, target in possible if spec.held[target]]
    return (holding or [name for name, _ in possible])[0]
