"""Loads the numbers of a twin, and gives them to the profile of a simulated robot."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.core._loading.problems import Problems
from pirate_sm.core._loading.references import FileKind, refuse_other
from pirate_sm.core._loading.yaml.document import Document, read_document
from pirate_sm.core._loading.yaml.validation import try_validate
from pirate_sm.core._model.robot.body import Motor
from pirate_sm.core._model.robot.profile import Profile
from pirate_sm.core._model.robot.simulation import MotorNumbers, Twin

_OF_ONE_KIND = {"hold_torque": "geared", "dead_drag": "geared", "stiffness": "sprung_worm"}
"""Numbers that only one kind of motor has."""


def simulated_profile(profile: Profile, twin: str | None, seed: int = 0) -> Profile:
    """Return the profile for a simulated robot, with the numbers in a file where one is named.

    Args:
        profile: As its file says.
        twin: A file, or a robot of its sample: see :func:`twin_named`.
        seed: Of the run.

    Raises:
        LoadError: Everything that is wrong with the file.
    """
    if twin is None:
        return profile
    file, number = twin_named(twin, seed)
    return with_twin(profile, load_twin(Path(file), profile, number))


def twin_named(twin: str, seed: int) -> tuple[str, int | None]:
    """Return the file of a twin, and the number in its sample of ``FILE#3`` or ``FILE#seed``."""
    file, _, which = twin.rpartition("#")
    if file and (which == "seed" or which.isdecimal()):
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


def check_twin(twin: Twin, profile: Profile, problems: Problems) -> None:
    """Report a twin of another robot, or of motors that this one does not have."""
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
            motor, at = known.get(name), (*group, name)
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
    changed = {"motors": motors, "boards": boards, "simulation": simulation}
    return profile.model_copy(update=changed)


def _numbered(motor: Motor, numbers: MotorNumbers | None) -> Motor:
    if numbers is None:
        return motor
    return motor.model_copy(update=numbers.model_dump(exclude_none=True))
