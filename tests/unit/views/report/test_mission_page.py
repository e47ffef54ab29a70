"""The page of a mission before its run: its findings at their lines, its diagram and its pipe."""

from __future__ import annotations

import re
from pathlib import Path

from pirate_sm.core import library
from pirate_sm.views.report.mission_page import mission_page

NEWT = Path(__file__).resolve().parents[3] / "robots" / "newt"


def test_each_phase_leads_to_its_line() -> None:
    path = NEWT / "patrol.yaml"
    lines = path.read_text().splitlines()

    page = mission_page(path)

    found = re.findall(r'<a href="#L(\d+)">\s*<g class="[^"]*" data-node="(\w+)"', page)
    assert found
    for number, name in found:
        assert lines[int(number) - 1].strip().startswith(f"{name}:")
        assert f'<li id="L{number}"' in page


def test_a_finding_leads_to_its_line_which_is_marked(tmp_path: Path) -> None:
    lines = library.find_mission("mitre_bend").read_text().splitlines()
    number = 1 + next(i for i, line in enumerate(lines) if "command: ClampRear" in line)
    lines[number - 1] = lines[number - 1].replace("ClampRear", "ClampRaer")
    path = tmp_path / "mine.yaml"
    path.write_text("\n".join([*lines, "# <b>&</b>"]))

    page = mission_page(path)

    assert f'<a href="#L{number}">line {number}</a>' in page
    assert "there is no command &#x27;ClampRaer&#x27; [mission.command]" in page
    assert re.search(rf'<li id="L{number}" class="error" title="there is no command', page)
    assert "<b>" not in page


def test_the_pipe_is_the_one_that_was_asked_for() -> None:
    mission = library.find_mission("mitre_bend")
    page = mission_page(mission, pipe="straight_113")
    assert "in pipe straight_113" in page
    assert "straight_113: " in page
    assert "mitre_90: " not in page


def test_what_cannot_be_read_at_all_is_a_finding(tmp_path: Path) -> None:
    path = tmp_path / "torn.yaml"
    path.write_text("mission: [\x00")
    assert "error" in mission_page(path)


def test_a_file_that_is_removed_meanwhile_is_named(tmp_path: Path) -> None:
    assert "there is no file or folder" in mission_page(tmp_path / "gone.yaml")
