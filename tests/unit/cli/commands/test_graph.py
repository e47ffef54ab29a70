from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from representative import thorough_but

from ..conftest import NEWT, ROOT

CHART = ROOT / "hardware_profiles" / "pirate_ii" / "chart.yaml"


@pytest.mark.parametrize(
    "what",
    thorough_but(
        ["mitre_bend", "pirate_ii", CHART],
        ["mitre_bend", "pirate_ii", NEWT, NEWT / "profile.yaml", NEWT / "patrol.yaml", CHART],
    ),
)
@pytest.mark.parametrize(
    ("kind", "begins"),
    [("mermaid", "---"), ("dot", "digraph"), ("svg", "<svg"), ("scxml", "<?xml")],
)
def test_missions_robots_and_charts_are_drawn(
    pirate: Any, what: Any, kind: str, begins: str
) -> None:
    result = pirate("graph", what, "--format", kind)

    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout.startswith(begins)


@pytest.mark.parametrize(
    ("name", "begins"),
    [
        *(("a.svg", "<svg"), ("a.gv", "digraph"), ("a.mmd", "---"), ("a", "---")),
        ("a.scxml", "<?xml"),
    ],
)
def test_the_output_names_the_format(pirate: Any, name: str, begins: str, tmp_path: Path) -> None:
    assert pirate("graph", "climb", "-o", tmp_path / name).exit_code == 0
    assert (tmp_path / name).read_text("utf-8").startswith(begins)


def test_an_ending_of_no_format_is_refused(pirate: Any, tmp_path: Path) -> None:
    result = pirate("graph", "climb", "-o", tmp_path / "a.bmp")

    assert result.exit_code == 2
    assert "possible are .svg, .dot" in result.stderr
    assert not (tmp_path / "a.bmp").exists()


@pytest.mark.parametrize("format", [(), ("--format", "svg"), ("--format", "scxml")])
def test_a_drawing_takes_the_place_of_no_mission(
    pirate: Any, tmp_path: Path, format: tuple[str, ...]
) -> None:
    mission = tmp_path / "first.yaml"
    mission.write_text((ROOT / "sequences" / "climb.yaml").read_text())
    before = mission.read_text()

    result = pirate("graph", mission, "-o", mission, *format)

    assert result.exit_code == 2
    assert mission.read_text() == before


def test_a_file_is_named_that_lacks_only_its_ending(
    pirate: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "first.yaml").write_text("format: 1\n", "utf-8")

    assert "did you mean 'first.yaml'?" in pirate("graph", "first").stderr


@pytest.mark.parametrize("name", ["a.svg", "a.dot", "a.mmd"])
def test_a_drawing_is_drawn_again(pirate: Any, tmp_path: Path, name: str) -> None:
    for mission in ("climb", "mitre_bend"):
        assert pirate("graph", mission, "-o", tmp_path / name).exit_code == 0

    assert "mitre_bend" in (tmp_path / name).read_text("utf-8")


@pytest.mark.parametrize("what", ["newt", "./newt", "newt/", "newt/profile.yaml"])
def test_a_robots_folder_here_is_drawn(
    pirate: Any, what: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(NEWT.parent)

    result = pirate("graph", what)

    assert (result.exit_code, result.stderr) == (0, "")
    assert 'title: "newt"' in result.stdout


def test_a_path_is_marked(pirate: Any) -> None:
    result = pirate("graph", "climb", "--format", "svg", "--highlight", "up, holding,slipped,")

    classes = [each.get("class") for each in ElementTree.fromstring(result.stdout).iter()]
    assert classes.count("phase visited") == 2
    assert classes.count("fail visited") == 1


def test_called_missions_are_drawn_when_asked_for(pirate: Any) -> None:
    assert "subgraph" not in pirate("graph", "mitre_bend").stdout
    assert pirate("graph", "mitre_bend", "--calls").stdout.count("subgraph") == 2


def test_what_is_wrong_with_a_mission_is_told_with_its_place(pirate: Any, tmp_path: Path) -> None:
    text = (ROOT / "sequences" / "climb.yaml").read_text("utf-8")
    mission = tmp_path / "wrong.yaml"
    mission.write_text(text.replace("go: holding", "go: holdin"), encoding="utf-8")
    result = pirate("graph", mission)

    assert result.exit_code == 2
    assert result.stdout == ""
    assert "wrong.yaml:" in result.stderr
    assert "did you mean 'holding'?" in result.stderr


def test_what_is_wrong_with_a_chart_is_told_with_its_place(pirate: Any, tmp_path: Path) -> None:
    chart = tmp_path / "chart.yaml"
    chart.write_text("states: {robot: {}}\n", encoding="utf-8")
    result = pirate("graph", chart)

    assert result.exit_code == 2
    assert "chart.yaml:1" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["mitre_bnd"], "did you mean 'mitre_bend'?"),
        (["nothing/of/this/name.yaml"], "nothing/of/this/name.yaml"),
        (["climb", "--highlight", "upp"], "did you mean 'up'?"),
        (["climb", "--format", "scxml", "--calls"], "SCXML has no place for --calls"),
        (["climb", "--format", "scxml", "--highlight", "up"], "no place for --highlight"),
        (["mitre_90", "--format", "scxml"], "'mitre_90' is a pipe"),
        (["climb", "--set", "height"], "expected NAME=VALUE"),
        (["climb", "-o", "no/such/folder/a.svg"], "cannot be written"),
        ([ROOT / "sequences"], "there is no robot"),
    ],
)
def test_misuse_is_told_in_a_line(pirate: Any, arguments: list[Any], says: str) -> None:
    result = pirate("graph", *arguments)

    assert (result.exit_code, result.stdout) == (2, "")
    assert says in result.stderr


BAD = """\
format: 1
mission: bad
robot: pirate_ii
start: grip
phases:
  grip: {do: [ClampFront, ClampRear], wait: [{when: detector == close, go: on}], within: {time: 5 s, go: lost}}
  on: {do: [ClampFront], go: good}
  lost: {do: [{command: Brake, unneeded: skip}], go: bad}
on_failure: lost
ends:
  good: {succeed: There}
  bad: {fail: "Not there: {cause}"}
"""  # noqa: E501


@pytest.fixture
def counterexample(pirate: Any, tmp_path: Path) -> tuple[Path, Path]:
    """A mission whose second phase is refused, and the script that leads there."""
    mission = tmp_path / "bad.yaml"
    mission.write_text(BAD, encoding="utf-8")
    assert pirate("check", mission, "--counterexamples", tmp_path / "out").exit_code == 1
    (script,) = (tmp_path / "out").glob("*.script.yaml")
    return mission, script


def test_the_way_of_a_counterexample_is_marked(
    pirate: Any, counterexample: tuple[Path, Path]
) -> None:
    mission, script = counterexample
    result = pirate("graph", mission, "--counterexample", script)

    assert (result.exit_code, result.stderr) == (0, "")
    for phase in ("(1) grip", "(2) on", "(3) lost", "(4) ✗ bad"):
        assert f"<b>{phase}</b>" in result.stdout
    assert "<b>✓ good</b>" in result.stdout
    assert "n_start ==> n_grip" in result.stdout
    assert 'n_grip ==>|"detector == close"| n_on' in result.stdout
    assert 'n_grip -->|"not within 5 s"| n_lost' in result.stdout
    assert 'n_any_phase ==>|"a step fails"| n_lost' in result.stdout


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["climb", "--counterexample", "nowhere.yaml"], "nowhere.yaml"),
        (["climb", "--counterexample", "SCRIPT", "--highlight", "up"], "exclude each other"),
        (["pirate_ii", "--counterexample", "SCRIPT"], "is not a mission"),
        (["climb", "--counterexample", "LIST"], "lays down no event sequence"),
    ],
)
def test_what_cannot_be_marked_is_said(
    pirate: Any, counterexample: tuple[Path, Path], tmp_path: Path, options: list[str], words: str
) -> None:
    (tmp_path / "list.yaml").write_text("- {trigger: halt}", encoding="utf-8")
    named = {"SCRIPT": counterexample[1], "LIST": tmp_path / "list.yaml"}
    result = pirate("graph", *(named.get(each, each) for each in options))

    assert (result.exit_code, result.stdout) == (2, "")
    assert words in result.stderr


def test_a_pipe_is_drawn_by_name_or_file(pirate: Any, tmp_path: Path) -> None:
    named = pirate("graph", "mitre_90")
    assert named.exit_code == 0
    assert "mitre 90" in named.stdout
    faulty = tmp_path / "faulty.yaml"
    faulty.write_text(
        "format: 1\ndiameter: 120 mm\nsegments: [{mitre: 90 deg}]\n", encoding="utf-8"
    )
    result = pirate("graph", faulty)
    assert result.exit_code == 2
    assert "begins and ends with a straight" in result.stderr


@pytest.mark.parametrize("name", ["a.svg", "a.gv", "a.mmd"])
@pytest.mark.parametrize("what", ["climb", NEWT])
def test_a_drawing_is_drawn_again_at_will(
    pirate: Any, what: Any, name: str, tmp_path: Path
) -> None:
    for _ in range(2):
        done = pirate("graph", what, "-o", tmp_path / name)
        assert (done.exit_code, done.stderr) == (0, "")


@pytest.mark.parametrize("given", [(), ("--format", "svg", "--overwrite")])
def test_a_mission_is_not_drawn_over_itself(
    pirate: Any, given: tuple[str, ...], tmp_path: Path
) -> None:
    assert pirate("graph", "climb", "-o", tmp_path / "a.yaml").exit_code == 2
    mission = tmp_path / "first.yaml"
    mission.write_text("mission: first\n", "utf-8")
    done = pirate("graph", mission, "-o", mission, *given)
    assert (done.exit_code, mission.read_text("utf-8")) == (2, "mission: first\n")


def test_an_unknown_ending_is_refused_with_the_possible_ones(pirate: Any, tmp_path: Path) -> None:
    done = pirate("graph", "climb", "-o", tmp_path / "a.bmp")
    assert done.exit_code == 2
    assert "no drawing ends in '.bmp'; possible are .svg, .dot" in done.stderr
    assert not (tmp_path / "a.bmp").exists()


def test_a_path_that_is_not_there_may_be_meant_as_any_kind(pirate) -> None:
    told = pirate("graph", "nothere.yaml")

    assert told.exit_code == 2
    assert "there is no mission, robot or pipe at 'nothere.yaml'" in told.stderr
