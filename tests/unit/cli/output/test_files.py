from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from pirate_sm.cli.output.files import refuse_losses, write_file
from pirate_sm.core.errors import UsageError

MISSION = "mission: mine\n"


def test_a_file_that_a_person_wrote_stays(tmp_path: Path) -> None:
    place = tmp_path / "mine.yaml"
    place.write_text(MISSION, "utf-8")
    with pytest.raises(UsageError, match=r"mine\.yaml' exists .* --overwrite"):
        refuse_losses([place])
    refuse_losses([place], overwrite=True)


@pytest.mark.parametrize("link", [Path.symlink_to, Path.hardlink_to])
def test_an_input_stays_whatever_its_name_is(link, tmp_path: Path) -> None:
    robot = tmp_path / "robot"
    robot.mkdir()
    source, place = robot / "chart.yaml", tmp_path / "picture.svg"
    source.write_text(MISSION, "utf-8")
    link(place, source)
    for read in (source, robot):
        with pytest.raises(UsageError, match=r"picture\.svg' is read by this command"):
            refuse_losses([place], inputs=[read], overwrite=True)


@pytest.mark.parametrize(
    ("name", "text", "free"),
    [
        ("empty.svg", "", True),
        ("table.csv", "wheel,what\n1,2\n", True),
        ("table.csv", "time,mine\n1,2\n", False),
        ("wheel.yaml", "wheel,what\n", False),
        ("picture.svg", '<svg xmlns="http://www.w3.org/2000/svg"><path d=""/></svg>', False),
        ("bay.log", '{"at_s": 0.1, "event": "opened"}\n', True),
        ("bay.jsonl", '{"at_s": 0.1, "event": "opened"}\n', True),
        ("mine.log", "09:12 the pipe is wet\n", False),
        ("page.html", "<!doctype html><p>mine", False),
    ],
)
def test_a_file_of_another_make_stays(name: str, text: str, free: bool, tmp_path: Path) -> None:
    place = tmp_path / name
    place.write_text(text, "utf-8")
    if free:
        refuse_losses([place], tables=["wheel,what"])
        return
    with pytest.raises(UsageError, match="exists"):
        refuse_losses([place], tables=["wheel,what"])


def test_a_link_stays_a_link_and_the_mode_of_the_file_stays(tmp_path: Path) -> None:
    place, link = tmp_path / "a.svg", tmp_path / "b.svg"
    place.write_text("before", "utf-8")
    place.chmod(0o640)
    link.symlink_to(place)
    write_file(link, "after")
    assert (link.is_symlink(), place.read_text("utf-8")) == (True, "after")
    assert stat.S_IMODE(place.stat().st_mode) == 0o640
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.svg", "b.svg"]


def test_what_cannot_be_written_whole_leaves_the_old_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = tmp_path / "a.svg"
    place.write_text("before", "utf-8")

    def full(_handle: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(UsageError, match="cannot be written: No space left on device"):
        write_file(place, "after")
    assert place.read_text("utf-8") == "before"
    assert [each.name for each in tmp_path.iterdir()] == ["a.svg"]


def test_a_pipe_is_written_to_directly() -> None:
    write_file(Path(os.devnull), "anything")
    assert Path(os.devnull).is_char_device()
