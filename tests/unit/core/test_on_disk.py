from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from pirate_sm.core.on_disk import (
    is_file,
    is_folder,
    is_there,
    listed,
    noting,
    opened,
    replace_file,
    unsaved,
    why_hidden,
)


@pytest.fixture
def hidden(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A file in a folder that may not be entered, also for somebody who may enter any."""
    path, stat, lstat = tmp_path / "locked" / "file", os.stat, os.lstat

    def refusing(asked: object, *rest: object, **more: object) -> object:
        if str(asked) == str(path):
            raise PermissionError(13, "Permission denied")
        return (stat if more.get("follow_symlinks", True) else lstat)(asked)  # type: ignore[arg-type]

    monkeypatch.setattr(os, "stat", refusing)
    monkeypatch.setattr(os, "lstat", refusing)
    yield path
    monkeypatch.undo()


def test_what_is_hidden_is_there_and_whoever_opens_it_says_why(hidden: Path) -> None:
    assert is_there(hidden)
    assert why_hidden(hidden) == "Permission denied"
    assert not is_file(hidden)
    assert not is_folder(hidden)


@pytest.mark.parametrize("name", ["nowhere", "file/inside", "n" * 300, "a\0b"])
def test_nothing_is_at_a_path_that_no_file_has(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").touch()
    path = tmp_path / name

    assert not is_there(path)
    assert not why_hidden(path)
    assert not is_file(path)
    assert not is_folder(path)


def test_files_folders_and_broken_links_are_told_apart(tmp_path: Path) -> None:
    file, link = tmp_path / "file", tmp_path / "link"
    file.touch()
    link.symlink_to("nowhere")

    assert all(map(is_there, (file, link, tmp_path)))
    assert list(map(is_file, (file, link, tmp_path))) == [True, False, False]
    assert list(map(is_folder, (file, link, tmp_path))) == [False, False, True]
    assert not any(map(why_hidden, (file, link, tmp_path)))


@pytest.mark.timeout(10)
def test_a_named_pipe_that_takes_the_place_of_a_file_is_refused_without_waiting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, pipe = tmp_path / "file", tmp_path / "pipe"
    file.touch()
    os.mkfifo(pipe)
    before, closed, close = file.stat(), [], os.close

    def closing(number: int) -> None:
        closed.append(number)
        close(number)

    with monkeypatch.context() as patch:
        patch.setattr(os, "stat", lambda *asked, **how: before)
        patch.setattr(os, "close", closing)
        with pytest.raises(OSError, match="not a regular file"):
            opened(pipe)
    assert len(closed) == 1


def test_a_file_is_replaced_whole_and_keeps_its_mode(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / ("a" * 250)
    replace_file(file, b"first")
    file.chmod(0o640)
    synchronised: list[int] = []
    monkeypatch.setattr(os, "fsync", synchronised.append)

    replace_file(file, memoryview(b"second"))

    assert len(synchronised) == 1
    assert file.read_bytes() == b"second"
    assert file.stat().st_mode & 0o777 == 0o640
    assert list(tmp_path.iterdir()) == [file]


def test_a_link_is_replaced_and_what_it_leads_to_stays(tmp_path: Path) -> None:
    file, link, broken = (tmp_path / name for name in ("file", "link", "broken"))
    file.write_bytes(b"first")
    link.symlink_to(file)
    broken.symlink_to(tmp_path / "nowhere")

    for each in (link, broken):
        replace_file(each, b"second")

    assert [each.read_bytes() for each in (file, link, broken)] == [b"first", b"second", b"second"]
    assert not (tmp_path / "nowhere").exists()


def test_a_file_that_may_not_be_written_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "file"
    file.write_bytes(b"first")
    usual = Path.open

    def refusing(self: Path, mode: str = "r", *rest: object) -> object:
        if self == file:
            raise PermissionError(13, "Permission denied")
        return usual(self, mode, *rest)  # type: ignore[call-overload]

    with monkeypatch.context() as patch:
        patch.setattr(Path, "open", refusing)
        with pytest.raises(PermissionError):
            replace_file(file, b"second")

    assert file.read_bytes() == b"first"
    assert list(tmp_path.iterdir()) == [file]


def test_a_regular_file_is_opened_to_be_read_and_nothing_else_is(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"content")

    with opened(tmp_path / "file") as file:
        assert file.read() == b"content"
    with pytest.raises(IsADirectoryError):
        opened(tmp_path)
    with pytest.raises(OSError, match="not a regular file"):
        opened("/dev/null")


def content(file: Path) -> bytes:
    with opened(file) as stream:
        return stream.read()


def test_files_hold_what_is_not_saved_yet_under_every_name_that_they_have(tmp_path: Path) -> None:
    old, new, link = (tmp_path / name for name in ("old.yaml", "new.yaml", "link.yaml"))
    old.write_bytes(b"old")
    link.symlink_to(old)
    texts = {str(old.resolve()): b"typed", str(new.resolve()): b"never saved"}

    with unsaved(texts):
        told = [content(each) for each in (old, new, link)]
        there = is_file(new), is_there(new), is_folder(new), why_hidden(new)
        names = [each.name for each in listed(tmp_path)]
        away = [each.name for each in listed(tmp_path.parent)]

    assert told == [b"typed", b"never saved", b"typed"]
    assert there == (True, True, False, "")
    assert names == ["link.yaml", "new.yaml", "old.yaml"]
    assert "new.yaml" not in away
    assert [each.name for each in listed(tmp_path)] == ["link.yaml", "old.yaml"]
    assert (is_file(new), content(old)) == (False, b"old")


def test_what_was_asked_of_unsaved_files_has_another_answer_later(tmp_path: Path) -> None:
    file = tmp_path / "new.yaml"
    texts = {str(file.resolve()): b"typed"}
    with unsaved(texts), noting() as asked:
        opened(file).close()
        listed(tmp_path)
        assert asked.holds()

    assert not asked.holds()
    with unsaved(texts):
        assert asked.holds()
    with unsaved({str(file.resolve()): b"typed on"}):
        assert not asked.holds()
