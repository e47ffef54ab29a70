"""Joint zeros: kept, found again, refused with a place, and subtracted where sensors are read."""

from __future__ import annotations

import shutil
from math import degrees, radians
from pathlib import Path

import pytest

from pirate_sm.core._engine.sensing.known_signals import nothing_known
from pirate_sm.core._engine.sensing.signal_table import observe
from pirate_sm.core._loading.problems import LoadError
from pirate_sm.core._loading.robot.loader import LoadedRobot, load_robot
from pirate_sm.core._model.events import SensorFrame
from pirate_sm.core.errors import UsageError
from pirate_sm.core.on_disk import replace_file
from pirate_sm.robot import calibration_files as calibrations
from pirate_sm.robot.calibration_files import (
    Calibration,
    find_calibration,
    joints_of,
    keep_calibration,
    load_calibration,
    newest_calibration,
    summary,
    with_zeros,
)

ROOT = Path(__file__).resolve().parents[3]
COUNTS_PER_REV = 4096


@pytest.fixture(autouse=True)
def users_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "config"
    monkeypatch.setattr(calibrations, "user_config_path", lambda *_, **__: folder)
    return folder / "calibrations" / "pirate_ii"


@pytest.fixture
def robot(tmp_path: Path) -> LoadedRobot:
    shutil.copytree(ROOT / "hardware_profiles" / "pirate_ii", tmp_path / "robot")
    return load_robot(tmp_path / "robot")


def made(date: str = "2026-11-21", **zeros_deg: float) -> Calibration:
    zeros = {name: radians(zero) for name, zero in (zeros_deg or {"gamma_1": 1.25}).items()}
    return Calibration(format=1, robot="pirate_ii", date=date, port="/dev/ttyACM0", zeros=zeros)


def faults(text: str, robot: LoadedRobot) -> list[str]:
    path = robot.folder / "calibration-2026-11-21.yaml"
    path.write_text(text, "utf-8")
    with pytest.raises(LoadError) as caught:
        load_calibration(path, robot)
    return [f"{each.place.line}: {each.message}" for each in caught.value.problems]


def test_what_was_kept_is_read_again(robot: LoadedRobot) -> None:
    path = keep_calibration(made(gamma_1=1.25, gamma_3=-0.5), robot)

    assert path == robot.folder / "calibration-2026-11-21.yaml"
    found = newest_calibration(robot)
    assert found is not None
    assert {name: round(degrees(z), 3) for name, z in found.zeros.items()} == {
        "gamma_1": 1.25,
        "gamma_3": -0.5,
    }
    assert summary(found) == (
        "joint zeros of 2026-11-21 applied: gamma_1 +1.2 deg, gamma_3 -0.5 deg"
    )


def test_a_robot_without_a_calibration_has_none(robot: LoadedRobot) -> None:
    assert find_calibration(robot) is None
    assert newest_calibration(robot) is None


def test_the_newest_counts_wherever_it_stands(robot: LoadedRobot, users_folder: Path) -> None:
    keep_calibration(made("2026-11-20"), robot)
    users_folder.mkdir(parents=True)
    shutil.copy(keep_calibration(made("2026-11-21"), robot), users_folder)
    newer = users_folder / "calibration-2026-11-22.yaml"
    (users_folder / "calibration-2026-11-21.yaml").rename(newer)

    assert find_calibration(robot) == newer


def test_of_one_day_the_one_beside_the_profile_counts(
    robot: LoadedRobot, users_folder: Path
) -> None:
    path = keep_calibration(made(), robot)
    users_folder.mkdir(parents=True)
    shutil.copy(path, users_folder)

    assert find_calibration(robot) == path


def test_it_goes_to_the_users_folder_where_the_robots_cannot_be_written_to(
    robot: LoadedRobot, users_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(path: Path, content: bytes) -> None:
        if path.parent == robot.folder:
            raise PermissionError(13, "Permission denied")
        replace_file(path, content)

    monkeypatch.setattr(calibrations, "replace_file", refuse)

    assert keep_calibration(made(), robot).parent == users_folder
    assert newest_calibration(robot) is not None


def test_without_any_folder_it_says_so(robot: LoadedRobot, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path, content: bytes) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(calibrations, "replace_file", refuse)

    with pytest.raises(UsageError, match=r"cannot be written, .*Permission denied"):
        keep_calibration(made(), robot)


GOOD = """\
format: 1
robot: pirate_ii
date: 2026-11-21
zeros:
  gamma_1: 1.2 deg
"""


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("1.2 deg", "1.2", "5: expected an angle such as '28 deg', got '1.2' without a unit"),
        ("1.2 deg", "31 deg", "5: 31.0 deg is too far from zero to be calibrated away"),
        ("gamma_1", "gama_1", "5: there is no joint 'gama_1'"),
        ("gamma_1", "phi", "5: there is no joint 'phi'"),
        ("robot: pirate_ii", "robot: newt", "2: this is the calibration of 'newt'"),
        ("2026-11-21", "2026-11-20", "3: the file's name says 2026-11-21, this says 2026-11-20"),
    ],
)
def test_a_fault_is_told_with_its_line(robot: LoadedRobot, old: str, new: str, fault: str) -> None:
    assert faults(GOOD.replace(old, new), robot) == [fault]


def test_only_joints_that_we_bring_to_angles_ourselves_have_zeros(robot: LoadedRobot) -> None:
    assert joints_of(robot) == ("gamma_1", "gamma_2", "gamma_3", "gamma_4")


def test_a_zero_is_subtracted_from_what_is_read_and_from_all_that_follows(
    robot: LoadedRobot,
) -> None:
    zero = radians(10)
    plain, calibrated = robot.normal, with_zeros(robot.normal, {"gamma_1": zero})
    still = (0.0,) * len(plain.slots)

    def seen(spec, counts: float, name: str) -> float:
        sensing = nothing_known(spec)
        for now, value in enumerate((0.0, counts / 2, counts)):
            frame = SensorFrame(22, (value, 0.0, 0.0, 0.0, 0.0, 0.0))
            sensing, _ = observe(spec, sensing, frame, still, still, float(now))
        return sensing.numbers[spec.vocabulary.numbers.index(name)]

    counts = COUNTS_PER_REV / 4
    assert degrees(seen(plain, counts, "gamma_1")) == pytest.approx(90)
    assert degrees(seen(calibrated, counts, "gamma_1")) == pytest.approx(80)
    assert seen(calibrated, counts, "gamma_rate_1") == pytest.approx(
        seen(plain, counts, "gamma_rate_1")
    )
    shift = COUNTS_PER_REV / 36
    assert seen(calibrated, counts + shift, "diameter_front") == pytest.approx(
        seen(plain, counts, "diameter_front")
    )
    assert seen(calibrated, counts, "theta_1") == seen(plain, counts, "theta_1")
