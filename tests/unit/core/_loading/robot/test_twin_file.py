import re
from pathlib import Path

import pytest

from pirate_sm.core._engine.robot.criteria import TorqueBorne
from pirate_sm.core._loading.robot.commands import constants_of
from pirate_sm.core._loading.robot.loader import (
    LoadedRobot,
    load_robot,
    with_fitted,
)
from pirate_sm.core._loading.robot.twin import (
    load_twin,
    simulated_profile,
    twin_named,
    with_twin,
)
from pirate_sm.core._loading.yaml.document import parse_document
from pirate_sm.core.errors import PirateError
from pirate_sm.running.wiring import Order, load

ROBOT = load_robot(Path(__file__).parents[5] / "hardware_profiles" / "pirate_ii")
PROFILE = ROBOT.profile


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


def test_each_joint_may_have_a_motor_of_its_own(twin_file: Path) -> None:
    """The thesis measured 0.159, 1.92, 0.487 and 0.237 Nm in its four joints."""
    measured = {"gamma_1": 0.159, "gamma_2": 1.92, "gamma_3": 0.487, "gamma_4": 0.237}
    joints = ", ".join(f"{name}: {{stall_torque: {nm} Nm}}" for name, nm in measured.items())
    twin_file.write_text(f"{twin_file.read_text()}joints: {{{joints}}}\n")
    changed = with_twin(PROFILE, load_twin(twin_file, PROFILE))

    given = {s.joint: changed.motors[s.motor] for s in changed.slots if s.joint is not None}
    assert {name: motor.stall_torque for name, motor in given.items()} == pytest.approx(measured)
    assert given["gamma_1"].stiffness == PROFILE.motors["bend"].stiffness
    fitted = with_fitted(ROBOT, parse_document(twin_file.read_text(), "twin.yaml"))
    done = fitted.normal.commands[fitted.table.commands.index("ClampRear")].done
    assert [load.full_nm for load in done.asked(TorqueBorne)] == pytest.approx(
        [0.7 * 0.487, 0.7 * 0.237]
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("motors: {wheel:", "joints: {gamma_9:", "no driven joint 'gamma_9'"),
        ("motors: {wheel:", "joints: {gamma_1:", "only a geared motor has a `hold_torque`"),
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


def fitted(text: str) -> LoadedRobot:
    return with_fitted(ROBOT, parse_document(f"format: 1\nrobot: pirate_ii\n{text}\n", "fit.yaml"))


def test_belief_in_a_fit_reaches_what_a_clamp_asks_for_and_conditions_of_missions() -> None:
    weak = fitted("motors: {bend: {stall_torque: 0.5 Nm}}")

    clamp, assumed = (
        next(found for each in robot.normal.commands if (found := each.done.asked(TorqueBorne)))
        for robot in (weak, ROBOT)
    )
    assert [load.full_nm for load in clamp] == pytest.approx([0.35, 0.35])
    assert [load.least_nm for load in clamp] == [load.least_nm for load in assumed]
    assert constants_of(weak.believed)["gamma_1_stall"].value == 0.5


def test_belief_in_a_fit_leaves_the_simulated_robot_and_its_friction_alone() -> None:
    robot = fitted("motors: {bend: {stall_torque: 0.5 Nm}}\nfriction: {static: 0.9, kinetic: 0.8}")

    assert robot.profile is PROFILE
    assert robot.believed.simulation.friction == PROFILE.simulation.friction


def test_a_fit_of_another_robot_is_refused_where_it_says_so(tmp_path: Path) -> None:
    with pytest.raises(PirateError, match=r"fit.yaml:3:10: .*no kind of motor 'bent'"):
        fitted("motors: {bent: {stall_torque: 0.5 Nm}}")
    with pytest.raises(PirateError, match="these are numbers of 'eel'"):
        with_fitted(ROBOT, parse_document("format: 1\nrobot: eel\n", "fit.yaml"))
    with pytest.raises(PirateError, match="expected a twin, and this is a pipe"):
        with_fitted(ROBOT, parse_document("pipe: p\ndiameter: 1 m\nsegments: []\n", "fit.yaml"))
    with pytest.raises(PirateError, match="nowhere"):
        load(Order("enter_2d", fitted=str(tmp_path / "nowhere.yaml")))


SAMPLE = """
sample:
  numbers: [wheel hold_torque, friction static, friction kinetic]
  assumed: [friction static]
  robots:
    - [0.05, 0.5, 0.4]
    - [0.06, 0.6, 0.5]
"""
PLAIN = "format: 1\nrobot: pirate_ii\nmotors: {bend: {stall_torque: 0.9 Nm}}\n"


@pytest.mark.parametrize(
    ("which", "seed", "hold_nm"),
    [("#0", 7, 0.05), ("#1", 7, 0.06), ("#3", 7, 0.06), ("#seed", 4, 0.05), ("", 4, 0.3)],
)
def test_a_robot_of_the_sample_is_named_by_its_number_or_by_the_seed(
    tmp_path: Path, which: str, seed: int, hold_nm: float
) -> None:
    file = tmp_path / "twin.yaml"
    file.write_text(PLAIN + SAMPLE)

    changed = simulated_profile(PROFILE, f"{file}{which}", seed)

    assert changed.motors["wheel"].hold_torque == pytest.approx(hold_nm)
    assert changed.motors["bend"].stall_torque == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("sample", "message"),
    [
        (SAMPLE.replace("hold_torque", "weight"), "'wheel weight' is not a number of a robot"),
        (SAMPLE.replace("wheel", "wing"), "kind of motor 'wing'"),
        (SAMPLE.replace("wheel", "bend"), "only a geared motor has a `hold_torque`"),
        (SAMPLE.replace("0.05, ", ""), "robot 0 has 2 numbers instead of 3"),
        (SAMPLE.replace("0.06", "-1"), "robot 1 of the sample: wheel hold_torque"),
        (SAMPLE.replace("0.6", "0.1"), "kinetic friction cannot be more than static"),
        (SAMPLE.replace("assumed: [friction", "assumed: [wheel"), "'wheel static' is assumed"),
        (
            SAMPLE.replace("friction static, friction", "friction kinetic, friction"),
            "has a name twice",
        ),
        ("", "it has one robot and no `sample`"),
    ],
)
def test_a_faulty_sample_is_refused(tmp_path: Path, sample: str, message: str) -> None:
    file = tmp_path / "twin.yaml"
    file.write_text(PLAIN + sample)

    with pytest.raises(PirateError, match=re.escape(message)):
        simulated_profile(PROFILE, f"{file}#1")


def test_an_existing_file_is_not_read_as_a_robot_of_a_sample(tmp_path: Path) -> None:
    file = tmp_path / "mine#3"
    assert twin_named(str(file), 0) == (str(tmp_path / "mine"), 3)

    file.write_text(SAMPLE, "utf-8")

    assert twin_named(str(file), 0) == (str(file), None)
