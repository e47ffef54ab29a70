"""Tables of a recording in Parquet: the same as in CSV, with types and units."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from late import late
from recording_runs import record

from pirate_sm.core.errors import UsageError
from pirate_sm.running.recording import parquet_files
from pirate_sm.running.recording.csv_files import write_tables
from pirate_sm.running.recording.parquet_files import UNIT, write_parquet
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.wiring import Order

pandas = late("pandas")
parquet = late("pyarrow.parquet")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("tables")
    recording = record(folder / "run.mcap", Order("mitre_bend", seed=2))
    with recorded_mission(recording.header) as loaded, pytest.MonkeyPatch.context() as patch:
        # So that tables have several row groups.
        patch.setattr(parquet_files, "_ROWS", 500)
        written = write_parquet(recording, loaded, folder / "parquet")
        as_csv = write_tables(recording, loaded, folder / "csv")
    assert [path.stem for path in written] == [path.stem for path in as_csv]
    return folder


def tables(folder: Path) -> list[str]:
    return sorted(path.stem for path in (folder / "parquet").iterdir())


@pytest.mark.thorough
def test_the_tables_are_those_of_csv(folder: Path) -> None:
    assert {"signals", "commands", "states", "environment", "log", "waits"} <= set(tables(folder))
    for name in tables(folder):
        found = pandas.read_parquet(folder / "parquet" / f"{name}.parquet")
        text = {key: str for key in found.columns if found[key].dtype == "str"}
        empty = {key: [""] for key in found if key not in text}
        path = folder / "csv" / f"{name}.csv"
        wanted = pandas.read_csv(path, dtype=text, keep_default_na=False, na_values=empty)

        for key in text:  # an apostrophe keeps a spreadsheet from taking text for a formula
            wanted[key] = wanted[key].str.removeprefix("'")
        pandas.testing.assert_frame_equal(found, wanted, check_dtype=False, check_exact=True)


def test_columns_have_units_and_files_say_what_they_are_of(folder: Path) -> None:
    def units(table: str) -> dict[str, str]:
        schema = parquet.read_schema(folder / "parquet" / f"{table}.parquet")
        return {each.name: each.metadata[UNIT].decode() for each in schema if each.metadata}

    signals = units("signals")
    assert signals["time_s"] == "s"
    assert signals["gamma_1_rad"] == "rad"
    assert signals["bend_torque_1_Nm"] == "Nm"
    assert signals["speed_m_per_s"] == "m/s"
    assert "mu_1" not in signals  # a ratio
    assert units("environment") == {
        **{"time_s": "s", "roll_rad": "rad", "pitch_rad": "rad", "diameter_m": "m"},
        **{"opening_roll_rad": "rad", "distance_m": "m", "diameter_ahead_m": "m", "arc_m": "m"},
    }
    assert units("commands") == {"time_s": "s"}
    about = parquet.read_schema(folder / "parquet" / "signals.parquet").metadata
    assert (about[b"mission"], about[b"robot"]) == (b"mitre_bend", b"pirate_ii")
    assert about[b"began"].startswith(b"2026-01-02T03:04:05")


def test_a_long_table_is_written_in_parts(folder: Path) -> None:
    file = parquet.ParquetFile(folder / "parquet" / "signals.parquet")

    assert file.num_row_groups > 2
    assert {str(field.type) for field in file.schema_arrow} == {"double"}


def test_a_folder_that_cannot_be_made_is_an_error_of_the_disk(tmp_path: Path) -> None:
    recording = record(tmp_path / "run.mcap", Order("enter_2d", backend="trace"))
    (tmp_path / "file").write_text("", encoding="utf-8")

    with (
        recorded_mission(recording.header) as loaded,
        pytest.raises(OSError, match="directory"),
    ):
        write_parquet(recording, loaded, tmp_path / "file" / "in")


def test_without_pyarrow_the_one_command_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, parquet_files.__name__)
    monkeypatch.setitem(sys.modules, "pyarrow", None)

    with pytest.raises(UsageError, match=r"pip install 'pirate-sm\[parquet\]'"):
        __import__(parquet_files.__name__)
