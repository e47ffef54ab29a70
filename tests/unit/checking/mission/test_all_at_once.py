"""What is wrong with a mission's parts is reported at once, whatever stage of loading finds it."""

from __future__ import annotations

import pytest

from pirate_sm.checking.mission.check_mission import check_mission
from pirate_sm.core.documents import LoadError
from pirate_sm.core.loading import load_pipe

MISSION = """\
format: 1
mission: m
robot: pirate_ii
pipe:
  diameter: 118 mm
  segments:
    - {straight: 1 m}
    - {tee: 90 deg}
    - {straight: 1 m}
start: a
phases:
  a: {do: [ClampFrnt], go: e}
ends:
  e: {succeed: ok}
"""


def found(folder, text: str) -> list[tuple[int, str]]:
    path = folder / "m.yaml"
    path.write_text(text, encoding="utf-8")
    return [(each.place.line, each.code) for each in check_mission(path).findings]


def test_a_tee_without_its_way_hides_neither_the_section_nor_a_misspelt_command(tmp_path):
    assert found(tmp_path, MISSION) == [
        (8, "missing-key"),
        (8, "pipe.section"),
        (12, "mission.command"),
    ]


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("time_limit: 5 fortnights", "quantity"),
        ("on_fault: [{fault: robot.stuck, got: e}]", "unknown-key"),
        ("timelimit: 5 min", "unknown-key"),
        ("polarity: normale", "choice"),
        ("  f: {fial: no}", "unknown-key"),
    ],
)
def test_a_faulty_part_that_nothing_names_hides_no_fault_of_the_others(tmp_path, line, code):
    said = found(tmp_path, MISSION.replace("tee: 90 deg", "tee: 90 deg, take: on") + line + "\n")

    assert (15, code) in said
    assert (12, "mission.command") in said


@pytest.mark.parametrize(
    "line", ["parametrs: {x: {type: duration}}", "parameters: {x: {typ: count}}"]
)
def test_a_name_whose_definition_is_faulty_is_not_reported_as_unknown(tmp_path, line):
    text = MISSION.replace("ClampFrnt], go: e", "ClampFront], wait: [{after: $x, go: e}]")

    assert "mission.name" not in {code for _, code in found(tmp_path, f"{text}{line}\n")}


def test_a_pipe_file_with_a_faulty_tee_says_that_the_tee_needs_a_round_pipe(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text(
        "format: 1\npipe: p\ndiameter: 118 mm\n"
        "segments: [{straight: 1 m}, {tee: 90 deg}, {straight: 1 m}]\n",
        encoding="utf-8",
    )
    with pytest.raises(LoadError) as caught:
        load_pipe(path)
    assert [each.code for each in caught.value.problems] == ["missing-key", "pipe.section"]
