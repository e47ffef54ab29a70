from pathlib import Path

import pytest

from pirate_sm.errors import PirateError
from pirate_sm.loading.robot.loader import load_robot
from pirate_sm.loading.robot.twin_file import load_twin, with_twin

PROFILE = load_robot(Path(__file__).parents[4] / "hardware_profiles" / "pirate_ii").profile


@pytest.fixture
def twin_file(tmp_path: Path) -> Path:
    file = tmp_path / "twin.yaml"
    file.write_text(
        "format: 1\nrobot: pirate_ii\n"
        "motors: {wheel: {hold_torque: 50 mNm}}\n"
        "friction: {static: 0.4, kinetic: 0.3}\n"
    )
    return file


def test_its_numbers_take_the_place_of_the_profiles_and_all_others_stay(twin_file: Path) -> None:
    changed = with_twin(PROFILE, load_twin(twin_file, PROFILE))

    assert changed.motors["wheel"].hold_torque == pytest.approx(0.05)
    assert changed.motors["wheel"].stall_torque == PROFILE.motors["wheel"].stall_torque
    assert changed.motors["bend"] == PROFILE.motors["bend"]
    assert changed.simulation.friction.kinetic == 0.3
    assert changed.simulation.noise == PROFILE.simulation.noise


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("pirate_ii", "eel", "these are numbers of 'eel', and the robot is pirate_ii"),
        ("wheel", "wheels", "no kind of motor 'wheels'"),
        ("50 mNm", "50", "without a unit"),
        (
            "wheel: {",
            "bend: {",
            "only a geared motor has a `hold_torque`",
        ),
        (
            "hold_torque: 50 mNm",
            "stiffness: 2 Nm/rad",
            "only a sprung_worm motor has a `stiffness`",
        ),
        ("kinetic: 0.3", "kinetic: 0.9", "kinetic friction cannot be more"),
    ],
)
def test_what_is_wrong_with_it_is_said(twin_file: Path, old: str, new: str, message: str) -> None:
    twin_file.write_text(twin_file.read_text().replace(old, new))

    with pytest.raises(PirateError, match=message):
        load_twin(twin_file, PROFILE)
