"""Loads the numbers of a twin, and gives them to the profile of a simulated robot."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pirate_sm.core._loading.problems import LoadError, Place, Problems
from pirate_sm.core._loading.problems import Path as Keys
from pirate_sm.core._loading.references import FileKind, refuse_other
from pirate_sm.core._loading.yaml.document import Document, parse_document, read_document
from pirate_sm.core._loading.yaml.validation import try_validate
from pirate_sm.core._model.robot.body import Motor
from pirate_sm.core._model.robot.profile import Profile
from pirate_sm.core._model.robot.simulation import Friction, MotorNumbers, Twin
from pirate_sm.core.errors import UsageError
from pirate_sm.core.on_disk import is_file
from pirate_sm.core.options import OF_PIPE
from pirate_sm.core.units import DIMENSIONLESS, QuantityError, read_quantity

_OF_ONE_KIND = {"hold_torque": "geared", "dead_drag": "geared", "stiffness": "sprung_worm"}
"""Numbers that only one kind of motor has."""


_NUMBER = re.compile(r"(?:(?:motors|joints)\.\w+|friction|noise|tyre)\.\w+")
_NUMBERS = (
    "expected motors.KIND.KEY, joints.JOINT.KEY, friction.KEY, noise.KEY, tyre.KEY or pipe.KEY"
)


def simulated_profile(
    profile: Profile,
    twin: str | None,
    seed: int = 0,
    numbers: Mapping[str, str] = MappingProxyType({}),
) -> Profile:
    """Return the profile for a simulated robot, with the numbers in a file where one is named.

    Args:
        profile: As its file says.
        twin: A file, or a robot of its sample: see :func:`twin_named`.
        seed: Of the run.
        numbers: More numbers, by their keys in such a file: ``motors.bend.stall_torque``. Of the
            two coefficients of friction one alone scales the other with it. Those of the pipe are
            left out.

    Raises:
        LoadError: Everything that is wrong with the file or the numbers.
        UsageError: A number has no such name.
    """
    if twin is not None:
        file, number = twin_named(twin, seed)
        profile = with_twin(profile, load_twin(Path(file), profile, number))
    numbers = {name: text for name, text in numbers.items() if not name.startswith(OF_PIPE)}
    if not numbers:
        return profile
    tree: dict[str, Any] = {"format": 1, "robot": profile.robot}
    for name, text in numbers.items():
        if not _NUMBER.fullmatch(name):
            raise UsageError(f"a robot has no number '{name}': {_NUMBERS}")
        *groups, key = name.split(".")
        inner = tree
        for group in groups:
            inner = inner.setdefault(group, {})
        inner[key] = text
        with suppress(ValueError):  # a plain number is one in files
            inner[key] = float(text)
    if "friction" in tree:
        tree["friction"] = _both(tree["friction"], profile.simulation.friction)
    document = parse_document(json.dumps(tree, indent=0), "the numbers given")  # each in a line
    try:
        return with_twin(profile, twin_in(document, profile))
    except LoadError as error:
        said = _by_line(tree, document, numbers)
        raise LoadError(
            replace(each, place=Place(said[each.place.line]), excerpt="")
            if each.place.line in said
            else each
            for each in error.problems
        ) from None


def _by_line(
    tree: Mapping[str, Any], document: Document, numbers: Mapping[str, str], within: Keys = ()
) -> dict[int, str]:
    """Return the numbers in a document as people give them, by their lines."""
    found = dict[int, str]()
    for key, value in tree.items():
        keys, line = (*within, key), document.place_of((*within, key), key=True).line
        if isinstance(value, Mapping):
            inner = _by_line(value, document, numbers, keys)
            found |= {line: next(iter(inner.values()), "")} | inner
        elif within:
            name = ".".join(map(str, keys))
            found[line] = f"{name} = {numbers.get(name) or f'{value:.6g}'}"
    return found


def _both(given: Mapping[str, Any], own: Friction) -> Mapping[str, Any]:
    """Return numbers of friction with both coefficients; one that is left out keeps its share."""
    coefficients = {"static": own.static, "kinetic": own.kinetic}
    for name in coefficients.keys() & given.keys():
        with suppress(QuantityError, ZeroDivisionError):  # the text is reported later
            share = read_quantity(str(given[name]), DIMENSIONLESS) / coefficients[name]
            return {key: share * value for key, value in coefficients.items()} | dict(given)
    return coefficients | dict(given)


def twin_named(twin: str, seed: int) -> tuple[str, int | None]:
    """Return the file of a twin, and the number in its sample of ``FILE#3`` or ``FILE#seed``.

    If a file has the whole name, that file is meant.
    """
    file, _, which = twin.rpartition("#")
    if file and (which == "seed" or which.isdecimal()) and not is_file(Path(twin)):
        return file, seed if which == "seed" else int(which)
    return twin, None


def load_twin(path: Path, profile: Profile, number: int | None = None) -> Twin:
    """Return the twin in a file, which must be of this robot, or a robot of its sample.

    Raises:
        LoadError: Everything that is wrong with the file.
    """
    document = read_document(path)
    twin = twin_in(document, profile)
    if number is None:
        return twin
    if twin.sample is None:
        problems = Problems(document)
        message = "it has one robot and no `sample`: `pirate fit --robot --write` writes both"
        problems.add("twin.robot", (), message)
        problems.raise_errors()
    return twin.drawn(number)


def twin_in(document: Document, profile: Profile) -> Twin:
    """Return the twin in a document, which must be of this robot.

    Raises:
        LoadError: Everything that is wrong with it.
    """
    problems = Problems(document)
    twin = try_validate(document, Twin, problems)
    if twin is None:
        refuse_other(document, FileKind.TWIN)
    else:
        check_twin(twin, profile, problems)
    problems.raise_errors()
    assert twin is not None
    return twin


def check_twin(twin: Twin, profile: Profile, problems: Problems, within: Keys = ()) -> None:
    """Report a twin of another robot, or of motors that this one does not have.

    Args:
        twin: The twin.
        profile: The robot's profile.
        problems: Takes the faults.
        within: Keys of the twin in its file, where it is a part of one.
    """
    if twin.robot != profile.robot:
        message = f"these are numbers of '{twin.robot}', and the robot is {profile.robot}"
        problems.add("twin.robot", ("robot",), message)
        return
    driven = {s.joint: profile.motors[s.motor] for s in profile.slots if s.joint is not None}
    sampled = {} if twin.sample is None else twin.drawn(0).motors
    for group, what, known, given in (
        (("motors",), "kind of motor", profile.motors, twin.motors),
        (("joints",), "driven joint", driven, twin.joints),
        (("sample", "numbers"), "kind of motor", profile.motors, sampled),
    ):
        for name, numbers in given.items():
            motor, at = known.get(name), (*within, *group, name)
            if motor is None:
                problems.add_unknown("twin.motor", at, what, name, sorted(known), key=True)
                continue
            for key, kind in _OF_ONE_KIND.items():
                if motor.kind != kind and getattr(numbers, key) is not None:
                    message = f"only a {kind} motor has a `{key}`, and '{name}' is {motor.kind}"
                    problems.add("twin.motor", (*at, key), message)


def with_twin(profile: Profile, twin: Twin) -> Profile:
    """Return the profile with the twin's numbers instead of its own.

    A joint with numbers of its own gets a kind of motor of its own.
    """
    motors = {
        name: _numbered(motor, twin.motors.get(name)) for name, motor in profile.motors.items()
    }
    own = {s.name: s for s in profile.slots if s.joint is not None and s.joint in twin.joints}
    names = {name: f"{slot.motor}_of_{slot.joint}" for name, slot in own.items()}
    for name, slot in own.items():
        motors[names[name]] = _numbered(motors[slot.motor], twin.joints[slot.joint or ""])
    boards = tuple(
        board.model_copy(
            update={
                "slots": tuple(
                    slot.model_copy(update={"motor": names.get(slot.name, slot.motor)})
                    for slot in board.slots
                )
            }
        )
        for board in profile.boards
    )
    simulation = profile.simulation
    if twin.friction is not None:
        simulation = simulation.model_copy(update={"friction": twin.friction})
    for name, numbers in (("noise", twin.noise), ("tyre", twin.tyre)):
        if numbers is not None:
            given = numbers.model_dump(exclude_unset=True)
            partly = getattr(simulation, name).model_copy(update=given)
            simulation = simulation.model_copy(update={name: partly})
    changed = {"motors": motors, "boards": boards, "simulation": simulation}
    return profile.model_copy(update=changed)


def _numbered(motor: Motor, numbers: MotorNumbers | None) -> Motor:
    if numbers is None:
        return motor
    return motor.model_copy(update=numbers.model_dump(exclude_none=True))
