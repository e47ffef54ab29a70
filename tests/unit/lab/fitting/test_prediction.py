import os
from pathlib import Path

import numpy as np
import pytest

import pirate_sm
from pirate_sm.core.errors import UsageError
from pirate_sm.lab.fitting.measurements import MeasuredFile, read_measured
from pirate_sm.lab.fitting.prediction import (
    DURATION,
    LOAD,
    SLIP,
    CommandValue,
    Predicted,
    band,
    coverage,
    in_processes,
    predict,
    quantities,
    widening,
)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory, back_and_forth: Path) -> Path:
    file = tmp_path_factory.mktemp("prediction") / "run.mcap"
    pirate_sm.run(str(back_and_forth), ruler=True, record=file)
    return file


@pytest.fixture(scope="module")
def measured(recording: Path) -> MeasuredFile:
    return read_measured(recording)


def test_each_command_lasts_until_the_next_one_is_sent(measured: MeasuredFile) -> None:
    given = measured.commands

    assert [each.name for each in given] == [
        "ClampFront", "ClampRear", "DriveForward", "Brake", "RelaxRear", "ClampRear",
        "DriveBackward", "Brake",
    ]  # fmt: skip
    assert [each.until_s for each in given[:-1]] == [each.from_s for each in given[1:]]
    assert {each.nth for each in given} == {0}
    assert len({(each.name, each.place) for each in given}) == len(given)


def test_duration_load_and_slip_of_each_command_are_known(measured: MeasuredFile) -> None:
    known = quantities(measured)

    drive = next(each for each in measured.commands if each.name == "DriveForward")
    of_drive = {q: value for q, value in known.items() if q.command == "DriveForward"}
    assert next(v for q, v in of_drive.items() if q.kind == DURATION) == pytest.approx(
        drive.until_s - drive.from_s
    )
    assert next(v for q, v in of_drive.items() if q.kind == SLIP) >= 0
    assert sum(np.isfinite(v) for q, v in of_drive.items() if q.kind == LOAD) == 6


def test_what_was_measured_before_a_time_is_cut_there(measured: MeasuredFile) -> None:
    before = measured.before(5.0)

    assert 4.5 < before.columns["time_s"][-1] <= 5.0
    assert before.setpoints["time_s"][-1] <= 5.0
    assert before.with_columns(measured.columns).columns["time_s"][-1] <= 5.0


def test_coverage_counts_what_lies_in_its_band() -> None:
    quantity = CommandValue(SLIP, "", "DriveForward", "m.yaml:1:1", 0)
    found = [Predicted(quantity, 5.0, 1.0, 2.0, value) for value in (0.9, 1.0, 1.5, 2.1)]

    assert coverage(found) == {DURATION: (0, 0), LOAD: (0, 0), SLIP: (2, 4)}


def test_a_band_is_widened_about_its_middle_and_not_below_zero() -> None:
    band = Predicted(CommandValue(SLIP, "", "DriveForward", "m.yaml:1:1", 0), 5.0, 1.0, 3.0, 4.0)

    assert band.off == pytest.approx(2.0)
    assert (band.widened(1.5).low, band.widened(1.5).high) == (0.5, 3.5)
    assert band.widened(4).low == 0
    assert band.widened(band.off).held


WAIT = CommandValue(DURATION, "", "DriveForward", "m.yaml:1:1", 0)


def test_a_wait_that_all_robots_do_alike_is_no_prediction_whatever_its_rounding() -> None:
    alike = [4.0 + number * 1e-16 for number in range(64)]

    assert band(WAIT, 5.0, 4.02, alike, 0.05) == "all robots do alike"


def test_what_only_the_recorded_robot_does_otherwise_is_a_miss_that_widens_nothing() -> None:
    found = band(WAIT, 5.0, 9.0, [4.0] * 64, 0.05)

    assert isinstance(found, Predicted)
    assert not found.held
    others = [Predicted(WAIT, 5.0, 1.0, 3.0, 2.0)] * 9
    assert widening([found] * 9 + others)[DURATION] == (1.0, 9)


@pytest.mark.parametrize(("known", "reason"), [(18, "fewer than 19"), (30, "fewer than 32")])
def test_too_few_robots_make_no_band(known: int, reason: str) -> None:
    simulated = [*np.linspace(1, 2, known), *[np.nan] * (64 - known if known > 19 else 2)]

    assert reason in str(band(WAIT, 5.0, 1.5, simulated, 0.05))


def test_bands_are_widened_by_what_they_miss_of_nine_values_or_more() -> None:
    first = [Predicted(WAIT, 5.0, 1.0, 3.0, value) for value in (2, 2, 2, 2, 2, 2, 2, 2, 5)]

    assert widening(first)[DURATION] == (3.0, 9)
    assert widening(first[1:])[DURATION] == (1.0, 8)
    assert not widening(first[1:])[DURATION].known


def test_a_process_that_is_killed_is_told() -> None:
    with pytest.raises(UsageError, match="a process that simulates was killed"):
        list(in_processes(os._exit, [3], 1, lambda share: None))


def test_processes_return_results_in_order() -> None:
    assert list(in_processes(abs, [-1, 2, -3], 2, lambda share: None)) == [1, 2, 3]


def test_a_table_predicts_nothing(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("time_s,a\n0,1\n1,2\n")

    with pytest.raises(UsageError, match="a table does not say"):
        predict(tmp_path / "table.csv", 19, 1, lambda share: None)


@pytest.mark.thorough
def test_the_second_half_is_predicted_by_the_robots_of_the_first(recording: Path) -> None:
    made = predict(recording, 24, 2, lambda share: None)
    found = made.predicted

    held, of = (sum(column) for column in zip(*coverage(found).values(), strict=True))
    assert of > 15
    assert held / of > 0.7
    middle_s = read_measured(recording).columns["time_s"][-1] / 2
    assert all(each.from_s > middle_s and each.low <= each.high for each in found)
    assert made.failed < 6
    assert made.left_out["all robots do alike"] > 0
