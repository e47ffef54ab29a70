"""Read the numbers that a recording has shown of a robot, and put them into its simulator."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.loading.file_names import shown
from pirate_sm.loading.problems import Problems
from pirate_sm.loading.yaml.document import read_document
from pirate_sm.loading.yaml.validation import validate
from pirate_sm.model.profile import Profile
from pirate_sm.model.twin import Twin


def load_twin(path: Path, profile: Profile) -> Twin:
    """Return the twin in a file, which must be of this robot.

    Raises:
        LoadError: Everything that is wrong with the file.
    """
    document = read_document(path, shown(path))
    twin = validate(document, Twin)
    problems = Problems(document)
    if twin.robot != profile.robot:
        message = f"these are numbers of '{twin.robot}'"
        problems.add("twin.robot", ("robot",), message, expected=profile.robot)
    for name in twin.motors:
        if name not in profile.motors:
            problems.add_unknown(
                "twin.motor", ("motors", name), "motor", name, profile.motors, key=True
            )
    problems.raise_errors()
    return twin


def with_twin(profile: Profile, twin: Twin) -> Profile:
    """Return the profile with the twin's numbers in place of its own.

    It is for a simulated robot only: the engine keeps what the profile says.
    """
    motors = {
        name: motor.model_copy(update=twin.motors[name].model_dump(exclude_none=True))
        if name in twin.motors
        else motor
        for name, motor in profile.motors.items()
    }
    simulation = profile.simulation
    if twin.friction is not None:
        simulation = simulation.model_copy(update={"friction": twin.friction})
    return profile.model_copy(update={"motors": motors, "simulation": simulation})
