from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from ..conftest import NEWT


def test_a_robot_s_page_is_printed(pirate: Any) -> None:
    result = pirate("robot", NEWT)

    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout.startswith("# newt\n")
    assert "### HoldNose" in result.stdout


def test_without_a_name_it_is_that_of_the_first_shipped(pirate: Any) -> None:
    assert pirate("robot").stdout.startswith("# pirate_ii\n")


def test_it_is_written_as_html_to_a_file(pirate: Any, tmp_path: Path) -> None:
    result = pirate("robot", NEWT, "--html", "-o", tmp_path / "newt.html")

    assert (result.exit_code, result.stdout) == (0, "")
    text = (tmp_path / "newt.html").read_text("utf-8")
    assert text.startswith("<!DOCTYPE html>")
    assert "<svg" in text


def test_its_picture_alone_is_written_to_an_svg_and_shows_a_wrong_sign(
    pirate: Any, tmp_path: Path
) -> None:
    shutil.copytree(NEWT, tmp_path / "newt")
    profile = tmp_path / "newt" / "profile.yaml"
    text = profile.read_text("utf-8").replace(
        "BothHeld: {fold_neck: -50", "BothHeld: {fold_neck: 50"
    )
    profile.write_text(text, "utf-8")
    for robot, wrong in ((NEWT, 0), (tmp_path / "newt", 1)):
        picture = tmp_path / "side.svg"
        result = pirate("robot", robot, "-o", picture)

        assert (result.exit_code, result.stdout, result.stderr) == (0, "", "")
        assert picture.read_text("utf-8").count('class="bad press"') == wrong
        assert pirate("robot", robot).stdout.count("[robot.clamp_side]") == wrong


@pytest.mark.parametrize(
    ("comment", "count"), [("", 1), ("  # pirate: allow robot.unseen: later", 0)]
)
def test_everything_wrong_at_a_place_is_shown_except_for_what_a_comment_allows(
    pirate: Any, tmp_path: Path, comment: str, count: int
) -> None:
    shutil.copytree(NEWT, tmp_path / "newt")
    profile = tmp_path / "newt" / "profile.yaml"
    before, _, after = profile.read_text("utf-8").partition("seen:\n")
    seen = f"seen:{comment}\n  within: 2.5 s\nsafe_state:"
    profile.write_text(before + seen + after.partition("safe_state:")[2], "utf-8")

    page = " ".join(pirate("robot", tmp_path / "newt").stdout.split())

    for what in ("Grip: Loose", "Crawl: Resting", "Lamp: Dark", "held parts: nose, tail"):
        assert page.count(f"[robot.unseen] `seen` has no criterion for {what}") == count


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["pirate_3"], "did you mean 'pirate_ii'"),
        ([NEWT, "-o", "no/such/folder/a.md"], "cannot be written"),
        ([NEWT, "--html", "-o", "newt.svg"], "'newt.svg' is a picture"),
    ],
)
def test_misuse_is_told_in_a_sentence(pirate: Any, arguments: list[Any], says: str) -> None:
    result = pirate("robot", *arguments)

    assert result.exit_code == 2
    assert says in result.stderr


def test_no_text_of_a_file_commands_the_terminal(pirate: Any, tmp_path: Path) -> None:
    for name in ("chart.yaml", "profile.yaml"):
        text = (NEWT / name).read_text("utf-8")
        text = text.replace("description: Newt", 'description: "\\u202eNewt\\u200b" #')
        (tmp_path / name).write_text(text, encoding="utf-8")
    result = pirate("robot", tmp_path)

    assert "\\u202eNewt\\u200b" in result.stdout
    assert "\u202e" not in result.stdout


@pytest.mark.parametrize("form", [(), ("--html",)])
def test_a_page_is_written_again_but_not_over_a_persons(
    pirate: Any, form: tuple[str, ...], tmp_path: Path
) -> None:
    place = tmp_path / ("page.html" if form else "page.md")
    for _ in range(2):
        assert pirate("robot", NEWT, *form, "-o", place).exit_code == 0
    place.write_text("# Mine\n", "utf-8")
    assert pirate("robot", NEWT, *form, "-o", place).exit_code == 2
    assert place.read_text("utf-8") == "# Mine\n"
