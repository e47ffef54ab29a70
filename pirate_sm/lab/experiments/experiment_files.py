"""Finds the experiments of a robot, files in the folder ``experiments`` next to its profile.

What is wrong with one is found before it is run.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TypeAlias

from pirate_sm.core import library
from pirate_sm.core.documents import Document, LoadError, Problems, read_document
from pirate_sm.core.documents import Path as At
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import PROFILE_FILE
from pirate_sm.core.loading import LoadedRobot, load_robot, validate
from pirate_sm.core.on_disk import is_file, resolved
from pirate_sm.core.spelling import nearest, one_of
from pirate_sm.core.units import QuantityError, parse_unit
from pirate_sm.lab.campaign.named_parts import check_defect
from pirate_sm.lab.experiments.setups import BendSetup, StraightPipeSetup, TractionSetup

Setup: TypeAlias = StraightPipeSetup | BendSetup | TractionSetup
ALL = "all"
_FOLDER = "experiments"


def load_experiments(robot: Path) -> tuple[Setup, ...]:
    """Return the experiments of the robot in this folder, in the order of their numbers.

    Raises:
        LoadError: Everything that is wrong with a file.
        UsageError: There is none.
    """
    files = sorted((robot / _FOLDER).glob("*.yaml"))
    if not files:
        raise UsageError(f"the robot has no experiments: there is no file in {robot / _FOLDER}")
    setups = [read_setup(read_document(file)) for file in files]
    return tuple(sorted(setups, key=lambda each: each.experiment))


def read_setup(document: Document) -> Setup:
    """Return what the file says; its keys determine the kind of experiment.

    Raises:
        LoadError: Everything that is wrong with the file.
    """
    keys = document.data if isinstance(document.data, dict) else {}
    if "physics" in keys:
        return validate(document, TractionSetup)
    if "tilts" in keys:
        return validate(document, BendSetup)
    return validate(document, StraightPipeSetup)


def parts_of(setup: Setup) -> tuple[str, ...]:
    """Return the names of an experiment's parts."""
    return tuple(setup.variants if isinstance(setup, TractionSetup) else setup.missions)


def chosen(setups: tuple[Setup, ...], which: list[str]) -> list[tuple[Setup, tuple[str, ...]]]:
    """Return the experiments that are asked for, each with its parts.

    Args:
        setups: All there are.
        which: Numbers of experiments, names of parts, or ``all``.

    Raises:
        UsageError: There is no such experiment.
    """
    known = {part: setup for setup in setups for part in parts_of(setup)}
    numbers = {str(setup.experiment): parts_of(setup) for setup in setups}
    wanted: list[str] = []
    for name in which:
        if name == ALL:
            wanted += known
        elif name in numbers:
            wanted += numbers[name]
        elif name in known:
            wanted.append(name)
        else:
            names = [ALL, *numbers, *known]
            close = nearest(name, names)
            hint = f"did you mean '{close}'?" if close else f"expected {one_of(names)}"
            raise UsageError(f"there is no experiment '{name}': {hint}")
    picked = [(each, tuple(part for part in parts_of(each) if part in wanted)) for each in setups]
    return [(setup, parts) for setup, parts in picked if parts]


# --- the check -----------------------------------------------------------------------------------


_Named = Iterable[tuple[At, str]]
"""Names in a file, each with its path."""


def check_experiment(path: Path) -> tuple[Document, Problems]:
    """Return the file of an experiment, and what is wrong with it.

    Raises:
        LoadError: It cannot be read, or does not have the keys and units of an experiment.
    """
    document = read_document(path)
    setup, problems = read_setup(document), Problems(document)
    parts = parts_of(setup)
    _known(problems, "part of the experiment", _parts(setup), parts)
    for number, row in enumerate(setup.rows):
        try:
            parse_unit(row.unit or "1")
        except QuantityError as error:
            problems.add("experiment.unit", ("rows", number, "unit"), str(error))
    for at, name in _missions(setup):
        try:
            library.find_mission(name)
        except UsageError as error:
            problems.add("experiment.name", at, str(error))
    robot = _robot(path, problems)
    if robot is not None:
        numbers = [*_keys(document.data), *_keys(robot.documents[0].data)]
        _known(problems, "number", _assumed(setup), numbers)
        _check_robot(setup, robot, problems)
    return document, problems


def _known(problems: Problems, kind: str, names: _Named, known: Iterable[str]) -> None:
    """Report names that are not known."""
    listed = list(known)
    for at, name in names:
        if name not in listed:
            problems.add_unknown("experiment.name", at, kind, name, listed)


def _parts(setup: Setup) -> Iterator[tuple[At, str]]:
    """Yield where the file names a part of its experiment."""
    for number, row in enumerate(setup.rows):
        yield ("rows", number, "of"), row.of
    if isinstance(setup, TractionSetup):
        yield ("curves", "of"), setup.curves.of
    elif isinstance(setup, BendSetup):
        yield ("tilts", "of"), setup.tilts.of
    else:
        yield ("shown",), setup.shown


def _assumed(setup: Setup) -> Iterator[tuple[At, str]]:
    """Yield where the file names an assumed number."""
    for number, row in enumerate(setup.rows):
        yield from _listed(("rows", number, "assumes"), row.assumes)


def _keys(data: object, above: str = "") -> Iterator[str]:
    """Yield the keys of nested mappings, each after those above it, with dots between."""
    if isinstance(data, dict):
        for key, value in data.items():
            yield f"{above}{key}"
            yield from _keys(value, f"{above}{key}.")


def _missions(setup: Setup) -> Iterator[tuple[At, str]]:
    if isinstance(setup, TractionSetup):
        return
    for part, name in setup.missions.items():
        yield ("missions", part), name
    if isinstance(setup, BendSetup):
        for value, tilted in setup.tilts.missions.items():
            yield ("tilts", "missions", value, "mission"), tilted.mission


def _robot(path: Path, problems: Problems) -> LoadedRobot | None:
    """Return the robot that the experiment is of; None if its own files have faults."""
    folder = resolved(path).parent.parent
    if not is_file(folder / PROFILE_FILE):
        message = f"an experiment belongs in a folder next to the {PROFILE_FILE} of its robot"
        problems.add("experiment.robot", ("experiment",), message, key=True)
        return None
    try:
        return load_robot(folder)
    except LoadError:
        return None  # reported for the robot


def _check_robot(setup: Setup, robot: LoadedRobot, problems: Problems) -> None:
    """Report wheels, parts, defects and states that the robot does not have."""
    body, table = robot.profile.body, robot.table
    wheels = [wheel.name for wheel in body.wheels]
    if isinstance(setup, TractionSetup):
        _known(problems, "wheel", _listed(("curves", "wheels"), setup.curves.wheels), wheels)
        noise = [(("curves", "noise"), setup.curves.noise)]
        _known(problems, "level of noise", noise, setup.noise)
        _known(problems, "part of the robot", _of_robot(setup), body.parts)
        return
    for place, text in _listed(("defects",), setup.defects):
        check_defect(text, robot.profile, "experiment.name", place, problems)
    if not isinstance(setup, BendSetup):
        _known(problems, "wheel", _listed(("wheels",), setup.wheels), wheels)
        return
    for name, states in setup.snapshots.items():
        at: At = ("snapshots", name)
        if len(states) != len(table.regions):
            message = f"a snapshot has a state of each region, {', '.join(table.regions)}"
            problems.add("experiment.name", at, message)
            continue
        for number, (state, known) in enumerate(zip(states, table.states, strict=True)):
            _known(problems, "state", [((*at, number), state)], known)


def _of_robot(setup: TractionSetup) -> Iterator[tuple[At, str]]:
    """Yield where the file names a part of the robot."""
    for at, by_part in (
        (("physics", "friction"), setup.physics.friction),
        (("control", "friction"), setup.control.friction),
        (("timeline", "clamp"), setup.timeline.clamp),
    ):
        yield from (((*at, part), part) for part in by_part)


def _listed(at: At, names: Iterable[str]) -> Iterator[tuple[At, str]]:
    return (((*at, number), name) for number, name in enumerate(names))
