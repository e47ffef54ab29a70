"""A robot's page, in both of its forms."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path

import pytest

from pirate_sm.core.loading import load_robot
from pirate_sm.core.spelling import listed
from pirate_sm.views.drawing.robot_page import (
    Heading,
    PageTable,
    Paragraph,
    html,
    markdown,
    robot_page,
)

ROOT = Path(__file__).resolve().parents[5]
FOLDERS = [ROOT / "hardware_profiles" / "pirate_ii", ROOT / "tests" / "robots" / "newt"]


@pytest.fixture(scope="module", params=FOLDERS, ids=lambda folder: folder.name)
def robot(request):
    return load_robot(request.param)


def test_each_command_and_each_state_is_on_the_page(robot):
    page = markdown(robot_page(robot))

    for name in robot.profile.commands:
        section = page.partition(f"### {name}\n")[2].partition("\n#")[0]
        for word in (
            "**Needs** ",
            "| region | from | to | motors |",
            "**Done** when",
            "**Fails** ",
        ):
            assert word in section, name
    for region, states in zip(robot.table.regions, robot.table.states, strict=True):
        section = page.partition(f"### {region}\n")[2].partition("\n### ")[0]
        assert "```mermaid" in section
        for state in states:
            assert f"| {state} |" in section


def test_each_control_and_what_it_changes_is_on_the_page(robot):
    page = markdown(robot_page(robot)).partition("## Controls\n")[2].partition("\n## ")[0]

    assert bool(page) is bool(robot.profile.controls)
    for name, control in robot.profile.controls.items():
        section = page.partition(f"### {name}\n")[2].partition("\n### ")[0]
        assert control.description in section
        for region, states in control.actuation.items():
            assert all(f"| {region} | {state} |" in section for state in states)


def test_every_row_of_a_table_has_as_many_cells_as_its_header(robot):
    for block in robot_page(robot):
        if isinstance(block, PageTable):
            assert {len(row) for row in block.rows} == {len(block.header)}


def test_only_the_command_that_may_open_the_last_clamp_says_so(robot):
    page = markdown(robot_page(robot))
    opening = [name for name, each in robot.profile.commands.items() if each.lets_go]

    assert page.count("**Lets go:**") == len(opening) == 1


def test_each_command_is_done_when_something_shows_it(robot):
    angles = {slot.name: "its angle" for slot in robot.profile.slots}
    for name, command in robot.profile.commands.items():
        text = command.done.in_words(angles)
        assert len(text) > 20, name
        assert not text.endswith(" ")


class Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.seen.append(tag)
        if tag != "meta":
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: object) -> None:
        self.seen.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_in_html_has_a_picture_of_the_robot_and_one_for_each_region(robot):
    tags = Tags()
    tags.feed(html(robot_page(robot)))

    assert tags.open == []
    assert tags.seen.count("svg") == 1 + len(robot.table.regions)
    assert "script" not in tags.seen


def test_text_of_a_file_is_no_markup():
    blocks = [
        Heading(1, "a"),
        Paragraph("<b>|*x*|</b>\nline", "`lead`"),
        PageTable(("h",), [("a|b",)]),
    ]

    assert markdown(blocks, "note") == (
        "# a\n\n<!-- note -->\n\n**\\`lead\\`** \\<b>\\|\\*x\\*\\|\\</b> line\n\n"
        "| h |\n| --- |\n| a\\|b |\n"
    )
    assert "&lt;b&gt;|*x*|&lt;/b&gt; line" in html(blocks)


@pytest.mark.parametrize(
    ("names", "text"), [((), ""), (("a",), "a"), (("a", "b"), "a and b"), ("abc", "a, b and c")]
)
def test_names_are_listed_as_one_would_say_them(names, text):
    assert listed(names) == text
