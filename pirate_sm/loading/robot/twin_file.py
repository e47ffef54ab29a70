"""Read the numbers that a recording has shown of a robot, and put them into its simulator."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.errors import UsageError
from pirate_sm.loading.file_names import shown
from pirate_sm.loading.yaml.document import read_document
from pirate_sm.loading.yaml.validation import validate
from pirate_sm.model.profile import Profile
from pirate_sm.model.twin import Twin
from pirate_sm.spelling import one_of


def simulated_profile(profile: Profile, file: str | None) -> Profile:
    """Return the profile for a simulated robot, with the numbers in a file where one is named.

    Raises:
        LoadError: Everything that is wrong with the file.
        UsageError: It does not fit the robot.
    """
    return profile if file is None else with_twin(profile, load_twin(Path(file), profile))


def load_twin(path: Path, profile: Profile) -> Twin:
    """Return the twin in a file, which must be of this robot.

    Raises:
        LoadError: Everything that is wrong with the file.
        UsageError: It is of another robot, or of motors that this one does not have.
    """
    twin = validate(read_document(path, shown(path)), Twin)
    if twin.robot != profile.robot:
        raise UsageError(f"{shown(path)} has numbers of '{twin.robot}', this is {profile.robot}")
    for name in twin.motors:
        if name not in profile.motors:
            known = one_of(sorted(profile.motors))
            raise UsageError(f"{shown(path)}: there is no kind of motor '{name}': expected {known}")
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
