from pathlib import Path

import numpy as np
import pytest

from pirate_sm.core import library
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import load_robot
from pirate_sm.lab.fitting.measurements import column, has, read_measured
from pirate_sm.lab.fitting.traction_again import signals_with
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.read.repair import repair
from pirate_sm.running.wiring import Order
from tests.unit.running.recording.recording_runs import record, spoilt_in


def test_a_table_is_read_by_its_header_with_nan_for_empty_cells(tmp_path: Path) -> None:
    file = tmp_path / "signals.csv"
    file.write_text("time_s,slip_m_per_s\n0,0.5\n1,\n")

    columns = read_measured(file).columns

    assert columns["time_s"].tolist() == [0, 1]
    assert np.isnan(column(columns, "slip")[1])
    assert has(columns, ["slip"])
    assert not has(columns, ["slide"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not a table"),
        ("a,b\n", "no rows"),
        ("a,b\n1,x\n", "not a table"),
        ("a,b\n1\n1,2\n", "not a table"),
    ],
)
def test_what_is_no_table_is_refused(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "signals.csv"
    file.write_text(text)

    with pytest.raises(UsageError, match=message):
        read_measured(file)


def test_a_missing_table_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="cannot be read"):
        read_measured(tmp_path / "none.csv")


def test_a_misspelt_signal_is_suggested() -> None:
    with pytest.raises(UsageError, match="did you mean 'slip_speed_1'"):
        column({"slip_speed_1": np.zeros(1)}, "slip_sped_1")


@pytest.mark.thorough
def test_no_setpoint_of_before_a_gap_is_in_force_after_it(tmp_path: Path) -> None:
    """Another one may have been sent in it: motors were fitted to a duty that they did not have."""
    recording = record(tmp_path / "run.mcap", Order("mitre_bend"))
    repair(spoilt_in(recording, tmp_path / "spoilt.mcap", 5), tmp_path / "good.mcap")
    (gap,) = read_recording(tmp_path / "good.mcap").gaps
    setpoints = read_measured(tmp_path / "good.mcap").setpoints
    times, slots = setpoints["time_s"], {*setpoints} - {"time_s"}

    (torn,) = np.flatnonzero(times == gap.from_s)[-1:]
    assert all(np.isnan(setpoints[name][torn]) for name in slots)
    assert np.all(np.diff(times) >= 0)
    assert times[torn + 1] >= gap.until_s


@pytest.mark.thorough
def test_slip_before_a_gap_does_not_count_after_it(tmp_path: Path) -> None:
    recording = record(tmp_path / "run.mcap", Order("mitre_bend"))
    repair(spoilt_in(recording, tmp_path / "spoilt.mcap", 5), tmp_path / "good.mcap")
    motors = load_robot(library.find_robot("pirate_ii")).profile.motors
    whole = signals_with(tmp_path / "run.mcap", motors)
    torn = signals_with(tmp_path / "good.mcap", motors)
    assert whole is not None
    assert torn is not None
    (gap,) = read_recording(tmp_path / "good.mcap").gaps
    soon = (torn["time_s"] >= gap.until_s) & (torn["time_s"] < gap.until_s + 0.1)

    assert soon.any()
    for name in (each for each in torn if each.startswith(("mu_", "slip_speed_"))):
        assert np.all(np.isnan(torn[name][soon]))
    before = torn["time_s"] <= gap.from_s
    angle = torn["gamma_1"][before]
    assert np.array_equal(angle, whole["gamma_1"][: len(angle)], equal_nan=True)
