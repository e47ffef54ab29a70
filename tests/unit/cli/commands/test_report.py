from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import pytest
from checking.robots import changed

from pirate_sm import __version__
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.views.report.recording_report import report_of

from ..conftest import NEWT


@pytest.fixture
def run(pirate_run: Any, tmp_path: Path) -> Path:
    path = tmp_path / "run.mcap"
    pirate_run(NEWT / "patrol.yaml", "--backend", "trace", "--quiet", "--record", path)
    return path


def test_a_report_stands_beside_its_recording_or_where_it_was_wanted(
    pirate: Any, run: Path, tmp_path: Path
) -> None:
    assert pirate("report", run).stdout == f"{tmp_path / 'run.html'}\n"
    assert pirate("report", run, "-o", tmp_path / "other.html").exit_code == 0

    assert (tmp_path / "run.html").read_text("utf-8").startswith("<!doctype html>")
    assert (tmp_path / "other.html").read_bytes() == (tmp_path / "run.html").read_bytes()


def test_a_report_does_not_overwrite_its_recording(pirate: Any, run: Path) -> None:
    before = run.read_bytes()
    result = pirate("report", run, "-o", run)

    assert (result.exit_code, run.read_bytes()) == (2, before)
    assert "is a recording: no page is written over it" in result.stderr


def test_a_report_does_not_overwrite_another_recording_or_a_link_to_its_own(
    pirate: Any, run: Path, tmp_path: Path
) -> None:
    other, link = tmp_path / "other.mcap", tmp_path / "link.html"
    other.write_bytes(run.read_bytes())
    link.hardlink_to(run)
    before = run.read_bytes()

    for place in (other, link):
        result = pirate("report", run, "-o", place)
        assert result.exit_code == 2
        assert "no page is written over it" in result.stderr
        assert place.read_bytes() == before


@pytest.mark.parametrize("name", ["run.html", "index.html"])
def test_what_somebody_else_wrote_is_not_replaced(pirate: Any, folder: Path, name: str) -> None:
    (folder / name).write_text("<!doctype html><title>By hand</title>", "utf-8")

    result = pirate("report", folder)

    assert result.exit_code == 2
    assert f"{name}' is not a page of this program" in result.stderr
    assert "By hand" in (folder / name).read_text("utf-8")
    assert [path.name for path in folder.glob("*.html")] == [name]


def test_an_empty_file_and_a_page_of_an_older_version_are_replaced(
    pirate: Any, run: Path, tmp_path: Path
) -> None:
    page = tmp_path / "run.html"
    page.touch()
    assert pirate("report", run).exit_code == 0
    page.write_text(page.read_text("utf-8").replace(__version__, "0.0.0"), "utf-8")

    assert pirate("report", run).exit_code == 0
    assert f'content="pirate-sm {__version__}"' in page.read_text("utf-8")


@pytest.fixture
def folder(pirate_run: Any, run: Path, tmp_path: Path) -> Path:
    other = tmp_path / "other run.mcap"
    pirate_run(NEWT / "patrol.yaml", "--seed", "3", "--quiet", "--record", other)
    (tmp_path / "broken.mcap").write_bytes(b"no recording")
    return tmp_path


def test_of_a_folder_there_is_a_list_that_leads_to_each_report(pirate: Any, folder: Path) -> None:
    result = pirate("report", folder)

    assert result.exit_code == 1
    assert "1 of 3 recordings cannot be read" in result.stderr
    assert result.stdout.splitlines() == [
        str(folder / name) for name in ("other run.html", "run.html", "index.html")
    ]
    assert "broken.mcap is not a recording" in result.stderr
    text = (folder / "index.html").read_text("utf-8")
    assert 'href="other%20run.html"' in text
    assert 'href="run.html"' in text
    assert "broken.mcap" in text


def test_a_fault_of_this_program_in_one_recording_leaves_the_others_their_pages(
    pirate: Any, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails_once(recording: Any) -> Any:
        if recording.path.name == "run.mcap":
            raise ValueError("tuple.index(x): x not in tuple")
        return report_of(recording)

    monkeypatch.setattr("pirate_sm.cli.commands.report.report_of", fails_once)

    result = pirate("report", folder)

    assert result.exit_code == 1
    assert "run.mcap: no page can be made of it: ValueError: tuple.index(x)" in result.stderr
    assert not (folder / "run.html").exists()
    assert (folder / "other run.html").exists()
    assert "run.mcap" in (folder / "index.html").read_text("utf-8")


def test_a_joint_that_no_board_measures_has_no_curve(
    pirate: Any, pirate_run: Any, tmp_path: Path
) -> None:
    joint = "    - {name: nape, wheel: right_fore, part: nose, end_stop: 90 deg, torque: nothing}\n"
    robot = changed(
        NEWT, tmp_path, "profile.yaml", ("    - {name: hip,", f"{joint}    - {{name: hip,")
    )
    run, path = tmp_path / "run.mcap", robot / "patrol.yaml"
    pirate_run(path, "--backend", "trace", "--quiet", "--no-check", "--record", run)

    assert pirate("report", run).exit_code == 0


def test_several_recordings_are_listed_where_it_was_wanted(
    pirate: Any, folder: Path, tmp_path: Path
) -> None:
    (tmp_path / "lists").mkdir()
    wanted = tmp_path / "lists" / "two.html"
    runs = (folder / "run.mcap", folder / "other run.mcap")

    assert pirate("report", *runs, "-o", wanted).exit_code == 0
    assert 'href="../other%20run.html"' in wanted.read_text("utf-8")


def test_the_page_of_the_very_recording_is_kept(pirate: Any, folder: Path) -> None:
    pirate("report", folder)
    os.utime(folder / "other run.html", (1, 1))

    assert pirate("report", folder).stdout.splitlines() == [str(folder / "index.html")]


@pytest.mark.thorough
def test_a_page_whose_recording_was_replaced_by_an_older_one_is_made_again(
    pirate: Any, folder: Path
) -> None:
    pirate("report", folder)
    (folder / "run.mcap").write_bytes((folder / "other run.mcap").read_bytes())
    os.utime(folder / "run.mcap", (1, 1))

    made = pirate("report", folder).stdout.splitlines()

    assert made == [str(folder / "run.html"), str(folder / "index.html")]
    assert (folder / "run.html").read_bytes() == (folder / "other run.html").read_bytes()


def test_a_page_of_another_version_is_made_again(pirate: Any, folder: Path) -> None:
    pirate("report", folder)
    page = folder / "run.html"
    page.write_text(page.read_text("utf-8").replace(__version__, "0.0.0"), "utf-8")

    assert str(page) in pirate("report", folder).stdout.splitlines()


def test_a_folder_without_a_recording_that_can_be_read_is_refused(
    pirate: Any, tmp_path: Path
) -> None:
    empty = pirate("report", tmp_path)
    (tmp_path / "a.mcap").write_bytes(b"")
    (tmp_path / "b.mcap").write_bytes(b"")
    broken = pirate("report", tmp_path)

    assert (empty.exit_code, broken.exit_code) == (2, 2)
    assert "there is no recording (*.mcap) in the folder" in empty.stderr
    assert "none of the recordings can be read" in broken.stderr
    assert not (tmp_path / "index.html").exists()


@pytest.mark.parametrize("name", ["run.mcap", "run.html"])
def test_a_list_does_not_overwrite_a_recording_or_its_page(
    pirate: Any, folder: Path, name: str
) -> None:
    pirate("report", folder / "run.mcap")
    before = (folder / name).read_bytes()

    result = pirate("report", folder, "-o", folder / name)

    assert (result.exit_code, (folder / name).read_bytes()) == (2, before)
    assert "name the list with --output" in result.stderr


@pytest.mark.parametrize("content", [None, b"", b"no recording", b"\x89MCAP0\r\n"])
def test_what_is_no_recording_is_refused_in_one_line(
    pirate: Any, tmp_path: Path, content: bytes | None
) -> None:
    path = tmp_path / "broken.mcap"
    if content is not None:
        path.write_bytes(content)
    result = pirate("report", path)

    assert result.exit_code == 2
    assert "broken.mcap" in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert not (tmp_path / "broken.html").exists()


def test_a_page_that_cannot_be_written_is_reported(pirate: Any, run: Path, tmp_path: Path) -> None:
    result = pirate("report", run, "-o", tmp_path / "nowhere" / "a.html")

    assert result.exit_code == 2
    assert "cannot be written" in result.stderr


@pytest.fixture
def archive(run: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a recording in which nobody can write, the superuser included."""
    folder = run.parent / "archive"
    folder.mkdir()
    run.rename(folder / run.name)
    access, open_ = os.access, Path.open

    def may(path: Any, mode: int) -> bool:
        return access(path, mode) and not (mode == os.W_OK and Path(path) == folder)

    def opened(path: Path, mode: str = "r", **options: Any) -> Any:
        if "r" not in mode and path.parent == folder:
            raise OSError(errno.EROFS, "Read-only file system")
        return open_(path, mode, **options)

    monkeypatch.setattr(os, "access", may)
    monkeypatch.setattr(Path, "open", opened)
    return folder


@pytest.mark.parametrize("what", [".", "run.mcap"])
def test_where_a_folder_is_read_only_it_is_said_what_to_do(
    pirate: Any, archive: Path, what: str
) -> None:
    result = pirate("report", archive / what)

    assert result.exit_code == 2
    assert f"the folder '{archive}' is read-only" in result.stderr
    assert "--output" in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert [each.name for each in archive.iterdir()] == ["run.mcap"]


def test_a_folder_that_is_read_only_is_listed_elsewhere_with_its_pages(
    pirate: Any, archive: Path, tmp_path: Path
) -> None:
    listing = tmp_path / "lists" / "runs.html"
    listing.parent.mkdir()

    assert pirate("report", archive, "--output", listing).exit_code == 0
    assert 'href="run.html"' in listing.read_text("utf-8")
    page = listing.with_name("run.html")
    first = page.stat().st_mtime_ns
    assert pirate("report", archive, "--output", listing).stdout == f"{listing}\n"
    assert page.stat().st_mtime_ns == first


def test_pages_of_read_only_folders_do_not_replace_one_another(
    pirate: Any, archive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = tmp_path / "other"
    other.mkdir()
    (other / "run.mcap").write_bytes((archive / "run.mcap").read_bytes())
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) == tmp_path)

    result = pirate("report", archive, other, "-o", tmp_path / "list.html")

    assert result.exit_code == 2
    assert f"'{tmp_path / 'run.html'}' would be the page of several recordings" in result.stderr


@pytest.mark.parametrize("command", [("report",), ("export", "--urdf", "a.urdf"), ("replay",)])
def test_a_disk_that_is_full_is_no_fault_of_this_program(
    pirate: Any, run: Path, command: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    monkeypatch.chdir(run.parent)
    result = pirate(*command, run)

    assert result.exit_code == 2
    assert "into a temporary folder: No space left on device" in result.stderr
    assert len(result.stderr.splitlines()) == 1


def test_what_a_recording_lacks_is_said_beside_its_page(
    pirate: Any, run: Path, tmp_path: Path
) -> None:
    whole, last = run.read_bytes(), read_recording(run).content.pieces[-1]
    assert pirate("report", run).stderr == ""
    assert pirate("report", tmp_path).stderr == ""
    for lacking, said in ((whole[:-20], "missing or damaged"), (whole[: last.at], "ends early")):
        run.write_bytes(lacking)

        one, folder = pirate("report", run), pirate("report", tmp_path)

        assert (one.exit_code, folder.exit_code) == (0, 0)
        assert one.stderr == folder.stderr
        assert one.stderr.startswith(f"{run}: ")
        assert said in one.stderr
