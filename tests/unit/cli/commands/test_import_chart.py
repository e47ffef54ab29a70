from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from ..conftest import NEWT


@pytest.fixture
def newt(pirate: Any, tmp_path: Path) -> Path:
    """Return the newt's chart as SCXML."""
    place = tmp_path / "newt.scxml"
    assert pirate("graph", NEWT, "-o", place).exit_code == 0
    return place


def test_a_chart_that_was_written_can_be_used_again(
    pirate: Any, newt: Path, tmp_path: Path
) -> None:
    robot = tmp_path / "newt"
    robot.mkdir()
    (robot / "profile.yaml").write_text((NEWT / "profile.yaml").read_text("utf-8"), "utf-8")
    (robot / "messages").symlink_to(NEWT / "messages")

    result = pirate("import", newt, "-o", robot / "chart.yaml")

    assert (result.exit_code, result.stderr) == (0, "")
    counted = "is a chart with 3 regions, 9 commands and 20 configurations"
    assert result.stdout == f"{robot / 'chart.yaml'} {counted}\n"
    checked = pirate("check", robot)
    assert (checked.exit_code, checked.stdout.endswith(": no findings\n")) == (0, True)


def test_without_an_output_the_chart_is_printed(pirate: Any, newt: Path) -> None:
    result = pirate("import", newt)

    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout.startswith("# Made from newt.scxml by `pirate import`.\nname: newt\n")


def test_the_chart_does_not_replace_its_source(pirate: Any, newt: Path) -> None:
    before = newt.read_bytes()

    result = pirate("import", newt, "-o", newt.parent / "." / "newt.scxml")

    assert result.exit_code == 2
    assert "is read by this command" in result.stderr
    assert newt.read_bytes() == before


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (None, "there is no such file"),
        (b"<scxml>\n<history/>\n</scxml>", "x.scxml:2:1: <history> in <scxml> is not supported"),
        (b"<scxml", "x.scxml:1:1: this is not XML"),
        (b"\xff\xfe<\0", "is written in UTF-16; save it as UTF-8"),
        (b"<a>\xe9</a>", "x.scxml:1:4: byte 0xe9 is not UTF-8"),
        (b"a\0\xe9", "is a binary file; SCXML is expected"),
        (b" " * (1 << 20) + b"<a/>", "is larger than 1 MiB"),
    ],
)
def test_what_is_no_chart_is_reported(
    pirate: Any, tmp_path: Path, content: bytes | None, says: str
) -> None:
    if content is not None:
        (tmp_path / "x.scxml").write_bytes(content)

    result = pirate("import", tmp_path / "x.scxml", "-o", tmp_path / "chart.yaml")

    assert (result.exit_code, result.stdout) == (2, "")
    assert says in result.stderr
    assert not (tmp_path / "chart.yaml").exists()
