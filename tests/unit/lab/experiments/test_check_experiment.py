"""Faults in the files of experiments are found by the check, with their places."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from pirate_sm.core.documents import LoadError, Problem
from pirate_sm.lab.experiments.experiment_files import check_experiment

PIRATE = Path(__file__).parents[4] / "hardware_profiles" / "pirate_ii"


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("robots") / "pirate_ii"
    shutil.copytree(PIRATE, folder)
    return folder


def found(robot: Path, number: int, old: str, new: str) -> list[Problem]:
    """What is said of a shipped experiment in which one text stands for another."""
    text = (PIRATE / "experiments" / f"experiment_{number}.yaml").read_text("utf-8")
    assert old in text
    file = robot / "experiments" / "changed.yaml"
    file.write_text(text.replace(old, new, 1), "utf-8")
    try:
        _, problems = check_experiment(file)
    except LoadError as error:
        return list(error.problems)
    return list(problems.all)


@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_shipped_experiment_has_no_fault(number: int) -> None:
    _, problems = check_experiment(PIRATE / "experiments" / f"experiment_{number}.yaml")

    assert problems.all == ()


@pytest.mark.parametrize(
    ("number", "old", "new", "code", "said"),
    [
        (1, "title:", "titel:", "unknown-key", "titel"),
        (1, "step: 10 ms", "step: 10", "quantity", "without a unit"),
        (1, "1a: exp_1a_both", "1a: exp_1a_bth", "experiment.name", "no mission 'exp_1a_bth'"),
        (1, "[wheels_3_4_dead]", "[wheels_dead]", "experiment.name", "no defect 'wheels_dead'"),
        (1, "wheels: [wheel_1,", "wheels: [wheel_7,", "experiment.name", "no wheel 'wheel_7'"),
        (1, "shown: 1a", "shown: 1x", "experiment.name", "no part of the experiment '1x'"),
        (1, "{of: 1a, what", "{of: 4a, what", "experiment.name", "'4a'"),
        (1, 'unit: "Nm"', "unit: newtons", "experiment.unit", "newtons"),
        (2, "Unclamped, Unaligned", "Unclampt, Unaligned", "experiment.name", "'Unclampt'"),
        (2, "[Free, Free, Unclamped", "[Free, Unclamped", "experiment.name", "of each region"),
        (2, "tilts:\n  of: 2c", "tilts:\n  of: 2d", "experiment.name", "'2d'"),
        (2, "cannot: not modelled", "cannot: not reproducible", "value", "'cannot: not modelled'"),
        (2, "between:", "shape:", "value", "'between'"),
        (3, "curves: {of: 3d", "curves: {of: 3e", "experiment.name", "'3e'"),
        (3, "noise: slipping", "noise: sliping", "experiment.name", "level of noise 'sliping'"),
        (3, "wheels: [wheel_1", "wheels: [wheel_9", "experiment.name", "no wheel 'wheel_9'"),
    ],
)
def test_a_fault_is_found_at_its_place(
    robot: Path, number: int, old: str, new: str, code: str, said: str
) -> None:
    (problem,) = found(robot, number, old, new)

    assert problem.code == code
    assert said in f"{problem.message} {problem.expected}"
    assert problem.place.line > 1
    assert problem.place.column > 0
    near = {line for line in problem.excerpt.split() if line}
    assert any(word.strip("[{,:") in problem.excerpt for word in new.split()), near


def test_an_assumed_number_is_one_of_the_experiment_or_of_the_robot(robot: Path) -> None:
    (problem,) = found(robot, 3, "assumes: [control.gain", "assumes: [control.gian")

    assert problem.code == "experiment.name"
    assert "no number 'control.gian'" in problem.message


def test_all_faults_are_told_at_once(robot: Path) -> None:
    text = (PIRATE / "experiments" / "experiment_1.yaml").read_text("utf-8")
    text = text.replace("1a: exp_1a_both", "1a: nothing").replace("shown: 1a", "shown: 1x")
    file = robot / "experiments" / "two.yaml"
    file.write_text(text, "utf-8")

    assert len(check_experiment(file)[1].all) == 2


def test_an_experiment_stands_beside_its_robot(tmp_path: Path) -> None:
    file = tmp_path / "experiment_1.yaml"
    shutil.copy(PIRATE / "experiments" / "experiment_1.yaml", file)

    (problem,) = check_experiment(file)[1].all

    assert problem.code == "experiment.robot"


def test_faults_of_the_robot_are_not_the_experiments(robot: Path, tmp_path: Path) -> None:
    broken = tmp_path / "pirate_ii"
    shutil.copytree(PIRATE, broken)
    (broken / "profile.yaml").write_text("format: 1\nrobot: pirate_ii\n", "utf-8")

    assert check_experiment(broken / "experiments" / "experiment_1.yaml")[1].all == ()
