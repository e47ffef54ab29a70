from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from representative import thorough_but

from pirate_sm.running.recording.read.reader import read_recording

from ..conftest import NEWT


@pytest.fixture
def run(pirate_run: Any, tmp_path: Path) -> Path:
    path = tmp_path / "run.mcap"
    pirate_run(NEWT / "patrol.yaml", "--quiet", "--record", path)
    return path


def test_everything_that_is_asked_for_is_written_and_named(
    pirate: Any, run: Path, tmp_path: Path
) -> None:
    files = {kind: tmp_path / kind for kind in ("urdf", "lichtblick", "plotjuggler")}
    options = [each for kind, file in files.items() for each in (f"--{kind}", file)]

    result = pirate("export", run, "--csv", tmp_path / "csv", *options)

    assert result.exit_code == 0
    assert result.stdout.splitlines()[-3:] == [str(file) for file in files.values()]
    assert str(tmp_path / "csv" / "places.csv") in result.stdout.splitlines()
    assert ElementTree.parse(files["urdf"]).getroot().tag == "robot"
    assert "3D!scene" in json.loads(files["lichtblick"].read_text("utf-8"))["configById"]
    assert ElementTree.parse(files["plotjuggler"]).getroot().tag == "root"


@pytest.mark.thorough
def test_the_recording_for_viewers_is_a_new_file(pirate: Any, run: Path, tmp_path: Path) -> None:
    place, other = tmp_path / "all.mcap", tmp_path / "other.mcap"
    other.write_text("mine")

    done = pirate("export", run, "--viewers", place)
    refused = pirate("export", run, "--viewers", other)

    assert (done.exit_code, done.stdout.splitlines()[-1]) == (0, str(place))
    assert read_recording(place).header.viewers
    assert any(True for _ in read_recording(place).shown("/signals"))
    assert refused.exit_code == 2
    assert "exists already" in refused.stderr
    assert other.read_text() == "mine"


@pytest.mark.thorough
def test_parquet_and_a_bag_of_ros_are_folders(pirate: Any, run: Path, tmp_path: Path) -> None:
    tables, bag = tmp_path / "tables", tmp_path / "bag"

    done = pirate("export", run, "--parquet", tables, "--ros2", bag)
    refused = pirate("export", run, "--ros2", bag)

    assert (done.exit_code, done.stdout.splitlines()[-1]) == (0, str(bag))
    assert str(tables / "signals.parquet") in done.stdout.splitlines()
    assert {each.name for each in bag.iterdir()} == {"bag.mcap", "metadata.yaml"}
    assert refused.exit_code == 2
    assert "exists already; nothing is written there" in refused.stderr


def test_to_ask_for_nothing_is_refused_with_what_there_is(pirate: Any, run: Path) -> None:
    result = pirate("export", run)

    assert result.exit_code == 2
    asked = (
        "--csv, --parquet DIR, --viewers OUT.mcap, --ros2 DIR, --urdf, --lichtblick, "
        "--plotjuggler FILE"
    )
    assert asked in result.stderr


@pytest.mark.parametrize("option", ["--urdf", "--lichtblick", "--plotjuggler"])
def test_a_file_that_cannot_be_written_is_reported(
    pirate: Any, run: Path, tmp_path: Path, option: str
) -> None:
    result = pirate("export", run, option, tmp_path / "nowhere" / "file")

    assert result.exit_code == 2
    assert "cannot be written" in result.stderr


@pytest.mark.parametrize(
    "option",
    ["--csv", "--parquet", "--viewers", "--ros2", "--urdf", "--lichtblick", "--plotjuggler"],
)
@pytest.mark.parametrize("linked", thorough_but([True], [False, True]))
def test_no_recording_is_overwritten(
    pirate: Any, run: Path, tmp_path: Path, option: str, linked: bool
) -> None:
    before = run.read_bytes()
    place = tmp_path / "link" if linked else run
    if linked:
        place.hardlink_to(run)

    result = pirate("export", run, "--csv", tmp_path / "csv", option, place)

    assert result.exit_code == 2
    assert "is a recording: nothing is written over it" in result.stderr
    assert run.read_bytes() == before
    assert not (tmp_path / "csv").exists()


def test_a_name_that_is_given_twice_is_refused_before_anything_is_written(
    pirate: Any, run: Path, tmp_path: Path
) -> None:
    result = pirate("export", run, "--urdf", tmp_path / "x", "--lichtblick", tmp_path / "." / "x")

    assert result.exit_code == 2
    assert "is named twice" in result.stderr
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize("kind", ["without contents", "damaged"])
def test_of_a_recording_without_contents_or_with_damage_no_folder_is_left(
    pirate: Any, run: Path, tmp_path: Path, kind: str
) -> None:
    data = bytearray(run.read_bytes())
    first = read_recording(run).content.pieces[0]
    if kind == "damaged":
        data[first.at + first.size // 2] ^= 0xFF
    run.write_bytes(data if kind == "damaged" else data[: first.at - 9])

    result = pirate("export", run, "--csv", tmp_path / "csv")

    assert result.exit_code == 2
    assert ("is damaged" if kind == "damaged" else "has no data for tables") in result.stderr
    assert not (tmp_path / "csv").exists()


@pytest.mark.parametrize("kind", thorough_but(["csv"], ["csv", "parquet"]))
def test_tables_are_written_again_but_not_over_somebodys_work(
    pirate: Any, run: Path, tmp_path: Path, kind: str
) -> None:
    if kind == "parquet":
        pytest.importorskip("pyarrow")
    folder = tmp_path / "tables"
    export = ("export", run, f"--{kind}", folder)
    assert pirate(*export).exit_code == pirate(*export).exit_code == 0
    before = {each.name: each.read_bytes() for each in folder.iterdir()}
    mine = {f"{name}.{kind}": b"time_s,mine\n" for name in ("end", "signals")}
    for name, text in mine.items():
        (folder / name).write_bytes(text)

    refused = pirate(*export)
    kept = {each.name: each.read_bytes() for each in folder.iterdir()}
    written = pirate(*export, "--overwrite")

    assert refused.exit_code == 2
    assert all(
        f"{name}' exists and was not written by this program" in refused.stderr for name in mine
    )
    assert kept == before | mine
    assert written.exit_code == 0
    assert {each.name: each.read_bytes() for each in folder.iterdir()} == before


@pytest.mark.thorough
def test_a_damaged_recording_leaves_the_tables_that_were_there(
    pirate: Any, run: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "csv"
    pirate("export", run, "--csv", folder)
    before = {each.name: each.read_bytes() for each in folder.iterdir()}
    data = bytearray(run.read_bytes())
    first = read_recording(run).content.pieces[0]
    data[first.at + first.size // 2] ^= 0xFF
    run.write_bytes(data)

    result = pirate("export", run, "--csv", folder)

    assert result.exit_code == 2
    assert {each.name: each.read_bytes() for each in folder.iterdir()} == before


def test_the_current_folder_is_not_taken_for_a_name_that_is_none(
    pirate: Any, run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = pirate("export", run, "--csv", "")

    assert result.exit_code == 2
    assert "'' is none" in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["run.mcap"]
