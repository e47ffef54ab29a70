from pathlib import Path

import numpy as np
import pytest

from pirate_sm.errors import UsageError
from pirate_sm.fitting.columns import column, has, read_measured


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
        ("", "no table"),
        ("a,b\n", "no rows"),
        ("a,b\n1,x\n", "no table"),
        ("a,b\n1\n1,2\n", "no table"),
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
