"""What a command writes never takes the place of what somebody else wrote."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pirate_sm.cli.output.files import write_file
from pirate_sm.errors import UsageError

STYLE = ".drawing text { font-family: monospace; font-size: 12px; fill: #222; stroke: none; }"
DRAWING = f'<svg xmlns="x" width="1">\n<style>\n{STYLE}\n</style>\n<text>a</text></svg>\n'
PAGE = '<!doctype html>\n<meta name="generator" content="pirate-sm 0.2.0">\n<title>a</title>\n'


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (DRAWING, DRAWING.replace(">a<", ">another<").replace('"1"', '"2000"')),
        (PAGE, PAGE.replace("0.2.0", "0.3.0").replace(">a<", ">b<")),
        ("", DRAWING),
    ],
    ids=["drawing", "page", "empty"],
)
def test_what_a_command_has_written_is_written_again(tmp_path: Path, old: str, new: str) -> None:
    place = tmp_path / "it.svg"
    place.write_text(old)

    write_file(place, new)

    assert place.read_text() == new


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("first.yaml", "mission: first\n", DRAWING),
        ("pipe.yaml", "# made by a map\npipe: a\n", "# made by a map\npipe: a\n"),
        ("pipe.yml", "pipe: a\n", "pipe: b\n"),
        ("mine.svg", '<svg xmlns="x" id="mine">\n</svg>\n', DRAWING),
        ("mine.svg", "\ufeff" + DRAWING, DRAWING),
        ("index.html", "<!doctype html>\n<title>mine</title>\n", PAGE),
        ("data.bin", "\0\1\2", DRAWING),
    ],
)
def test_anything_else_stays_as_it_is(tmp_path: Path, name: str, old: str, new: str) -> None:
    place = tmp_path / name
    place.write_text(old)

    with pytest.raises(UsageError, match=f"{name}' exists.*stays: move it away"):
        write_file(place, new)

    assert place.read_text() == old


@pytest.mark.parametrize("link", [Path.symlink_to, Path.hardlink_to])
def test_a_link_to_an_input_is_that_input(tmp_path: Path, link: object) -> None:
    mission, drawing = tmp_path / "first.yaml", tmp_path / "first.svg"
    mission.write_text("mission: first\n")
    assert callable(link)
    link(drawing, mission)

    with pytest.raises(UsageError, match="stays"):
        write_file(drawing, DRAWING)

    assert mission.read_text() == "mission: first\n"


def test_an_edited_file_keeps_its_permissions_and_its_link(tmp_path: Path) -> None:
    place, link = tmp_path / "pipe.yaml", tmp_path / "link.yaml"
    place.write_text("pipe: a\n")
    place.chmod(0o640)
    link.symlink_to(place)

    write_file(link, "pipe: b\n", edited=True)

    assert (place.read_text(), place.stat().st_mode & 0o777) == ("pipe: b\n", 0o640)
    assert link.is_symlink()


def test_a_new_file_has_the_usual_permissions(tmp_path: Path) -> None:
    (tmp_path / "usual").touch()

    write_file(tmp_path / "new.svg", DRAWING)

    assert (tmp_path / "new.svg").stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_where_a_file_cannot_be_written_the_old_one_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = tmp_path / "it.svg"
    place.write_text(DRAWING)

    def full(*_: object, **__: object) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fdopen", full)
    with pytest.raises(UsageError, match="cannot be written: No space left on device"):
        write_file(place, DRAWING.replace(">a<", ">b<"))

    assert [each.name for each in tmp_path.iterdir()] == ["it.svg"]
    assert place.read_text() == DRAWING


def test_a_pipe_is_written_to(tmp_path: Path) -> None:
    place = tmp_path / "pipe"
    os.mkfifo(place)
    reader = os.open(place, os.O_RDONLY | os.O_NONBLOCK)

    write_file(place, DRAWING)

    assert os.read(reader, 1000).decode() == DRAWING
    os.close(reader)
