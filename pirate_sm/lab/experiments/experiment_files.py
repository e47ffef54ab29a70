"""Finds the experiments of a robot: files in the folder ``experiments`` beside its profile."""

from __future__ import annotations

from pathlib import Path
from typing import TypeAlias

from pirate_sm.core.documents import Document, read_document
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import validate
from pirate_sm.core.spelling import nearest, one_of
from pirate_sm.lab.experiments.mission_setups import BendSetup, StraightPipeSetup
from pirate_sm.lab.experiments.traction_setup import TractionSetup

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
